// The studio in a real browser: every sample opened, worked on and played, as a user does it.
//
//   node test/browser.mjs TRUNNION
//
// TRUNNION is the built program; its `studio` verb serves dist/, and the page has to write the bytes that it writes.
// Pictures go to test/pictures, and are compared with those in test/expected; UPDATE_EXPECT=1 accepts them.

import assert from "node:assert/strict";
import { execFile, execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { picture } from "./pictures.mjs";
import { PATIENCE, browser, open, serve, stop, trunnion, watchFrames } from "./studio.mjs";

const here = (name) => new URL(name, import.meta.url).pathname;
/** Outputs of the command line, taken away at the end. */
const folders = [];
const figures = [];
const note = (what, value) => figures.push(`${what}: ${value}`);

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
  await picture(page, name);

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
  await picture(page, "gallery");
  await context.close();
}

/** Starts a verb of the command line on the files of the gallery; returns the folder of its outputs when it is done. */
function commandLine(...words) {
  const out = mkdtempSync(join(tmpdir(), "studio-"));
  folders.push(out);
  return new Promise((resolve, reject) => {
    execFile(trunnion, [...words, "--output", out], { cwd: here("../dist/samples") }, (error, _, messages) => {
      // 1: something is not kept, as planted.
      if (error && error.code !== 1) reject(new Error(`trunnion ${words.join(" ")}: ${messages}`));
      else resolve(out);
    });
  });
}

/** Saves every output of the page, and asserts that each has the bytes of the command line's. */
async function compare(page, name, folder) {
  await page.getByRole("tab", { name: "Files" }).click();
  const [seen, different] = [[], []];
  for (const item of await page.locator("#outputs li").all()) {
    const output = (await item.locator("span").textContent()).replace(/^[^/]*\//, "");
    const [download] = await Promise.all([page.waitForEvent("download"), item.getByText("save").click()]);
    seen.push(output);
    if (!readFileSync(await download.path()).equals(readFileSync(join(folder, output)))) different.push(output);
  }
  assert.deepEqual(seen.sort(), readdirSync(folder).sort());
  assert.deepEqual(different, [], `${name}: other bytes than those of the command line`);
  note(`${name}: outputs with the bytes of the command line`, seen.length);
}

/** A part alone gets the job that `trunnion init` proposes; clicks on faces and controls write it. */
async function planning(url) {
  const { page, errors, context } = await open(url);
  const folder = here("../../fixtures/corpus/gate");
  await page.locator("#chooser").setInputFiles(join(folder, "stepped.step"));
  const job = () => page.locator("#job-text").inputValue();
  const settled = async (before) => {
    await page.waitForFunction((text) => document.querySelector("#job-text").value !== text, before, { timeout: PATIENCE });
    await page.locator("#progress").waitFor({ state: "hidden", timeout: PATIENCE });
    return job();
  };
  const proposed = await settled("");
  const printed = execFileSync(trunnion, ["init", "stepped.step"], { cwd: folder, encoding: "utf8" });
  assert.equal(proposed, printed, "the proposal is not that of the command line");
  await picture(page, "faces");

  // Hovering names a face, a click leaves it out, another takes it in again.
  const numbers = (text) => /^faces = \[([\d, ]*)\]/m.exec(text)[1].split(", ").map(Number);
  const box = await page.locator("#view").boundingBox();
  const place = [box.x + 0.45 * box.width, box.y + 0.5 * box.height];
  await page.mouse.move(...place);
  const words = await page.locator("#hovered").textContent();
  const [, number] = /^face (\d+): .* \(is cut\)$/.exec(words);
  await page.mouse.click(...place);
  const fewer = await settled(proposed);
  assert.deepEqual(numbers(fewer), numbers(proposed).filter((other) => other !== Number(number)));
  await page.mouse.click(...place);
  const again = await settled(fewer);
  assert.ok(numbers(again).includes(Number(number)));

  // A control writes its line and nothing else; faces of an edited job change in its text.
  await page.getByLabel("Excess, mm").fill("0.015");
  await page.getByLabel("Excess, mm").press("Tab");
  const edited = await job();
  assert.match(edited, /^total = 0\.015  # largest excess/m);
  assert.equal(edited.replace("total = 0.015", /^total = \S+/m.exec(again)[0]), again);
  await page.locator("#choose-machine").selectOption("ac-trunnion");
  assert.match(await job(), /^file = "ac-trunnion"/m);
  await page.mouse.click(...place);
  assert.ok(!numbers(await job()).includes(Number(number)));
  assert.match(await job(), /^total = 0\.015/m);
  await page.waitForTimeout(600);
  assert.equal(await page.locator("#faults button").count(), 0);
  assert.deepEqual(errors, []);
  await context.close();
}

const site = await serve();
try {
  await firstPaint(site.url);

  // The same work by the command line, whose bytes the page has to write.
  const patchFolder = await commandLine("run", "examples/bezier-patch/job.toml");
  const stepFolder = await commandLine("run", "examples/step-face/job.toml");
  const plantedFolder = await commandLine("check", "edited.ngc", "--job", "examples/bezier-patch/job.toml");

  // Each page has one worker: two of them take the time of one.
  const kept = { passes: true, words: /is kept/ };
  const [patch, step] = await Promise.all([sample(site.url, "Bezier patch", kept), sample(site.url, "STEP face", kept)]);
  await compare(step.page, "STEP face", stepFolder);
  assert.deepEqual(step.errors, []);
  await step.context.close();
  const { page } = patch;
  await page.locator("#machine").check();
  await page.locator("#still").check();
  await page.waitForTimeout(300);
  assert.ok((await colours(page)) > 8);
  await picture(page, "machine");
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
  await picture(page, "section");
  await page.locator("#section").selectOption("");
  await compare(page, "Bezier patch", patchFolder);

  // A fault in the job is marked at its line; the result stays.
  await page.getByRole("tab", { name: "Job" }).click();
  const job = await page.locator("#job-text").inputValue();
  await page.locator("#job-text").fill(job.replace("total = 0.02 ", "totl = 0.02 "));
  await page.locator("#faults button").first().waitFor();
  assert.match(await page.locator("#faults").textContent(), /job\.toml:\d+:\d+: .*totl[\s\S]*total/);
  assert.equal(await page.locator(".gutter .bad").count(), 1);
  assert.ok(await page.locator("#verdict").isVisible());
  await picture(page, "fault");
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
  await picture(planted.page, "place");
  await compare(planted.page, "Planted fault", plantedFolder);
  assert.deepEqual(planted.errors, []);
  await planted.context.close();

  await planning(site.url);

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
    await picture(page, name, { fullPage: true });
    assert.deepEqual(errors, []);
    await context.close();
  }
} finally {
  stop(site);
  for (const folder of folders) rmSync(folder, { recursive: true });
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
