// The studio in a real browser: every sample opened, worked on and played, as a user does it.
//
//   node test/browser.mjs TRUNNION [OUTPUTS-OF-THE-COMMAND-LINE...]
//
// TRUNNION is the built program; its `studio` verb serves dist/. Pictures go to test/pictures.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, readFileSync } from "node:fs";
import { chromium } from "playwright-core";

const here = (name) => new URL(name, import.meta.url).pathname;
const root = here("../..");
const trunnion = process.argv[2] ?? `${root}target/release/trunnion`;
const pictures = here("pictures");
mkdirSync(pictures, { recursive: true });

/** Longest that a sample may take on a slow machine \[ms\]. */
const PATIENCE = 480_000;

const figures = [];
const note = (what, value) => figures.push(`${what}: ${value}`);

/** Starts `trunnion studio`, and returns its address. */
function serve(...files) {
  const child = spawn(trunnion, ["studio", "--no-open", "--site", here("../dist"), ...files, "--json"], { cwd: root });
  return new Promise((resolve, reject) => {
    let text = "";
    child.stdout.on("data", (part) => {
      text += part;
      try {
        resolve({ child, url: JSON.parse(text).url });
      } catch {
        // The rest is still to come.
      }
    });
    child.stderr.on("data", (part) => process.stderr.write(part));
    child.on("exit", (code) => reject(new Error(`trunnion studio ended with ${code}`)));
  });
}

function stop({ child }) {
  child.removeAllListeners("exit");
  child.kill();
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader"],
});

/** A page whose errors fail the test. */
async function open(url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, ...options });
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => {
    if (message.type() === "error") errors.push(`${message.text()} ${message.location().url}`);
  });
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(url);
  return { page, errors, context };
}

const clock = async (page) => Number.parseFloat(await page.locator("#clock").textContent());

/** Current line of the program. */
const current = (page) => page.locator("#program [aria-current]").getAttribute("data-line").then(Number);

/** Waits until a line is current: the text is drawn with the next frame. */
const becomes = (page, least, most) =>
  page.waitForFunction(
    ([least, most]) => {
      const line = Number(document.querySelector("#program [aria-current]")?.dataset.line);
      return line >= least && line <= most;
    },
    [least, most],
    { timeout: 20_000 },
  );

/** Number of different colours in the picture: one or two are a blank one. */
async function colours(page) {
  return page.evaluate(() => {
    const from = document.querySelector("#view canvas");
    const small = Object.assign(document.createElement("canvas"), { width: 160, height: 100 });
    const brush = small.getContext("2d");
    brush.drawImage(from, 0, 0, 160, 100);
    const { data } = brush.getImageData(0, 0, 160, 100);
    const seen = new Set();
    for (let at = 0; at < data.length; at += 4) seen.add(`${data[at] >> 4},${data[at + 1] >> 4},${data[at + 2] >> 4}`);
    return seen.size;
  });
}

/** Longest time between two frames while something happens \[ms\]. */
const watchFrames = (page) =>
  page.evaluate(() => {
    window.longest = 0;
    let before = performance.now();
    const frame = (now) => {
      window.longest = Math.max(window.longest, now - before);
      before = now;
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  });

async function sample(url, name, { passes, words }) {
  const { page, errors, context } = await open(url);
  await watchFrames(page);
  const start = performance.now();
  await page.getByRole("button", { name }).click();
  await page.locator("#verdict").waitFor({ state: "visible", timeout: PATIENCE });
  await page.locator("#progress").waitFor({ state: "hidden", timeout: PATIENCE });
  note(`${name}: opened and worked on`, `${((performance.now() - start) / 1000).toFixed(1)} s`);
  note(`${name}: longest frame`, `${(await page.evaluate(() => window.longest)).toFixed(0)} ms`);
  assert.match(await page.locator("#verdict").getAttribute("class"), passes ? /good/ : /bad/);
  assert.match(await page.locator("#problems").textContent(), words);
  assert.ok((await colours(page)) > 8, `${name}: the picture is blank`);
  await page.screenshot({ path: `${pictures}/${name}.png` });

  // The time runs, and the text runs along.
  const before = await clock(page);
  const line = await current(page);
  await page.locator("#play").click();
  await page.waitForTimeout(1500);
  await page.locator("#play").click();
  assert.ok((await clock(page)) > before, `${name}: the clock stands still`);
  await becomes(page, line + 1, Infinity);

  // A click in the text goes to its block; the block after it is the next line.
  const at = line + 9;
  await page.locator("#program").evaluate((element, top) => (element.scrollTop = top), 18 * (at - 5));
  await page.locator(`#program [data-line="${at}"]`).click();
  await becomes(page, at, at);
  const time = await clock(page);
  await page.keyboard.press(".");
  assert.ok((await clock(page)) >= time);
  await becomes(page, at + 1, at + 3);
  return { page, errors, context };
}

async function firstPaint(url) {
  const { page, context } = await open(url);
  const painted = () => performance.getEntriesByName("first-contentful-paint")[0]?.startTime;
  await page.waitForFunction(painted);
  const paint = await page.evaluate(painted);
  note("first paint", `${paint.toFixed(0)} ms`);
  await page.screenshot({ path: `${pictures}/gallery.png` });
  await context.close();
}

/** Saves an output of the page, and compares it with that of the command line. */
async function compare(page, folder) {
  await page.getByRole("tab", { name: "Files" }).click();
  let same = 0;
  const different = [];
  for (const item of await page.locator("#outputs li").all()) {
    const name = (await item.locator("span").textContent()).replace(/^out\//, "");
    const [download] = await Promise.all([page.waitForEvent("download"), item.getByText("save").click()]);
    const [made, expected] = [readFileSync(await download.path()), readFileSync(`${folder}/${name}`)];
    if (made.equals(expected)) same += 1;
    else different.push(name);
  }
  note(`outputs equal to those in ${folder}`, `${same}; different: ${different.join(", ") || "none"}`);
  return different;
}

const site = await serve();
try {
  await firstPaint(site.url);

  // Each page has one worker: two of them take the time of one.
  const kept = { passes: true, words: /is kept/ };
  const [patch, step] = await Promise.all([sample(site.url, "Bezier patch", kept), sample(site.url, "STEP face", kept)]);
  assert.deepEqual(step.errors, []);
  await step.context.close();
  const { page } = patch;
  await page.locator("#machine").check();
  await page.locator("#still").check();
  await page.waitForTimeout(300);
  assert.ok((await colours(page)) > 8);
  await page.screenshot({ path: `${pictures}/machine.png` });
  await page.locator("#still").uncheck();
  await page.locator("#machine").uncheck();

  // A click on the part names its deviation and its block; with the ruler, a distance.
  const box = await page.locator("#view").boundingBox();
  const [x, y] = [box.x + 0.42 * box.width, box.y + 0.55 * box.height];
  await page.mouse.click(x, y);
  await page.locator("#picked").waitFor({ state: "visible" });
  assert.match(await page.locator("#picked").textContent(), /µm/);
  await page.getByRole("button", { name: /block that cuts here/ }).click();
  await page.locator("#measure").check();
  await page.mouse.click(x, y);
  await page.mouse.click(x + 40, y);
  assert.match(await page.locator("#picked").textContent(), /^[\d.]+ mm/);
  await page.locator("#section").selectOption("x");
  await page.waitForTimeout(200);
  await page.screenshot({ path: `${pictures}/section.png` });
  await page.locator("#section").selectOption("");
  for (const folder of process.argv.slice(3, 4)) await compare(page, folder);

  // A fault in the job is marked at its line; the result stays.
  await page.getByRole("tab", { name: "Job" }).click();
  const job = await page.locator("#job-text").inputValue();
  await page.locator("#job-text").fill(job.replace("total = 0.02 ", "totl = 0.02 "));
  await page.locator("#faults button").first().waitFor();
  assert.match(await page.locator("#faults").textContent(), /job\.toml:\d+:\d+: .*totl[\s\S]*total/);
  assert.equal(await page.locator(".gutter .bad").count(), 1);
  assert.ok(await page.locator("#verdict").isVisible());
  await page.screenshot({ path: `${pictures}/fault.png` });
  await page.locator("#job-text").fill(job);
  await page.waitForFunction(() => document.querySelectorAll(".gutter .bad").length === 0);

  // Files of no use are refused in words, and everything else stays.
  await page.locator("#chooser").setInputFiles([
    { name: "empty.ngc", mimeType: "text/plain", buffer: Buffer.alloc(0) },
    { name: "noise.ngc", mimeType: "text/plain", buffer: Buffer.from([0, 255, 1, 254, 60, 33]) },
  ]);
  await page.locator("#problems .bad").first().waitFor();
  assert.ok(await page.locator("#view canvas").isVisible());
  assert.deepEqual(patch.errors, []);
  await patch.context.close();

  // A problem leads to its block.
  const planted = await sample(site.url, "Planted fault", { passes: false, words: /gouge/ });
  await planted.page.locator("#problems button.bad").first().click();
  const words = await planted.page.locator("#problems button.bad").first().textContent();
  const [, line] = /line (\d+)/.exec(words);
  await becomes(planted.page, Number(line), Number(line));
  assert.equal(await planted.page.locator("#program .bad").getAttribute("data-line"), line);
  await planted.page.screenshot({ path: `${pictures}/place.png` });
  assert.deepEqual(planted.errors, []);
  await planted.context.close();

  // Work can be stopped, and done again.
  const stopped = await open(site.url);
  await stopped.page.getByRole("button", { name: "STEP face" }).click();
  await stopped.page.locator("#cancel").click();
  await stopped.page.getByText("stopped on request").waitFor();
  assert.ok(await stopped.page.locator("#run").isEnabled());
  await stopped.context.close();

  // Dark, and narrow: nothing is cut off.
  for (const [name, options] of [
    ["dark", { colorScheme: "dark" }],
    ["narrow", { viewport: { width: 800, height: 900 } }],
  ]) {
    const { page, errors, context } = await open(site.url, options);
    await page.getByRole("button", { name: "Planted fault" }).click();
    await page.locator("#verdict").waitFor({ state: "visible", timeout: PATIENCE });
    await page.waitForTimeout(500);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${name}: the page is ${wide} px too wide`);
    await page.screenshot({ path: `${pictures}/${name}.png`, fullPage: true });
    assert.deepEqual(errors, []);
    await context.close();
  }
} finally {
  stop(site);
}

// A job that is named on the command line is open with its files.
const named = await serve("examples/step-face/job.toml");
try {
  const { page, errors } = await open(named.url);
  await page.locator("#run:enabled").waitFor();
  assert.match(await page.locator("#job-text").inputValue(), /step face/);
  assert.equal(await page.locator("#faults li").count(), 0);
  assert.deepEqual(errors, []);
} finally {
  stop(named);
}
await browser.close();
console.log(figures.join("\n"));
