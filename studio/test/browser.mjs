// The studio in a real browser: every sample opened, worked on and played, as a user does it.
//
//   node test/browser.mjs TRUNNION
//
// TRUNNION is the built program; its `studio` verb serves dist/, and the page has to write the bytes that it writes.
// Pictures go to test/pictures, and are compared with those in test/expected; UPDATE_EXPECT=1 accepts them.

import assert from "node:assert/strict";
import { execFile, execFileSync } from "node:child_process";
import { closeSync, mkdtempSync, openSync, readFileSync, readdirSync, rmSync, truncateSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { picture } from "./pictures.mjs";
import { PATIENCE, browser, drawn, launch, open, longestTask, serve, stop, trunnion, watchFrames } from "./studio.mjs";

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

/** All pixels of the picture, as they are. */
const wholePicture = (page) =>
  page.evaluate(() => {
    const from = document.querySelector("#view canvas");
    const whole = Object.assign(document.createElement("canvas"), { width: from.width, height: from.height });
    whole.getContext("2d").drawImage(from, 0, 0);
    return [...whole.getContext("2d").getImageData(0, 0, from.width, from.height).data];
  });

/** While the tool alone moves, nothing else is drawn: the picture has to be the one that is drawn as a whole. */
async function movesAlone(page, name) {
  await drawn(page);
  const moved = await wholePicture(page);
  // Another layer and back: everything is drawn.
  const layer = page.getByLabel("Surface", { exact: true });
  await layer.uncheck();
  await drawn(page);
  const without = await wholePicture(page);
  await layer.check();
  await drawn(page);
  const whole = await wholePicture(page);
  assert.ok(difference(without, whole) > 0.02, `${name}: the surface is not seen`);
  // Edges of the tool where it goes into the surface.
  assert.ok(difference(moved, whole) < 0.001, `${name}: ${difference(moved, whole)} of the picture is not drawn anew`);
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

  // Stock is for a test of its own.
  await page.getByLabel("Stock").uncheck();

  // The time runs, and the text runs along.
  const before = await clock(page);
  const line = await current(page);
  await page.locator("#play").click();
  await page.waitForTimeout(1500);
  // A busy machine may draw no frame for a second.
  await page.waitForFunction((before) => Number.parseFloat(document.querySelector("#clock").textContent) > before, before, { timeout: 20_000 });
  // A short program may have come to its end, where a click begins again.
  if ((await page.locator("#play").textContent()) !== "▶") await page.locator("#play").click();
  await becomes(page, line + 1, Infinity);

  // A click in the text goes to its block; the block after it is the next line.
  const at = line + 9;
  await page.locator("#program").evaluate((element, top) => (element.scrollTop = top), 18 * (at - 5));
  await page.locator(`#program [data-line="${at}"]`).click();
  await becomes(page, at, at);
  // So does one while the current line changes: the text may run along in the middle of a click.
  await page.locator(`#program [data-line="${at + 5}"]`).hover();
  await page.mouse.down();
  await page.keyboard.press(".");
  await becomes(page, at + 1, at + 3);
  await page.mouse.up();
  await becomes(page, at + 5, at + 5);
  await page.locator(`#program [data-line="${at}"]`).click();
  await becomes(page, at, at);
  const time = await clock(page);
  await page.keyboard.press(".");
  assert.ok((await clock(page)) >= time);
  await becomes(page, at + 1, at + 3);
  await movesAlone(page, name);
  return { page, errors, context };
}

/** Share of the picture that differs from another. */
const difference = (a, b) => a.filter((value, at) => Math.abs(value - b[at]) > 24).length / a.length;

/** Material goes away where the tool is, and comes back where the slider goes back. */
async function cutting(url) {
  const { page, errors, context } = await open(url);
  await page.getByRole("button", { name: "Planted fault" }).click();
  await page.locator("#verdict").waitFor({ state: "visible", timeout: PATIENCE });
  await drawn(page);
  for (const layer of ["Tool", "Passes (tool tip)", "Passes (cutter contact)"]) {
    if ((await page.getByLabel(layer, { exact: true }).count()) > 0) await page.getByLabel(layer, { exact: true }).uncheck();
  }
  const end = Number(await page.locator("#time").getAttribute("max"));
  const settled = async () => {
    await page.waitForTimeout(500);
    await page.locator("#behind").waitFor({ state: "hidden", timeout: PATIENCE });
    await drawn(page);
  };
  const seen = async (share) => {
    const begin = performance.now();
    await page.locator("#time").fill(`${share * end}`);
    await settled();
    note(`stock at ${share} of the time: seen`, `${((performance.now() - begin) / 1000).toFixed(1)} s`);
    return wholePicture(page);
  };
  const uncut = await seen(0);
  assert.match(await page.locator("#layers").textContent(), /stock: box of the part, cells of [\d.]+ mm/);
  const half = await seen(0.5);
  const all = await seen(1);
  assert.ok(difference(uncut, half) > 0.01 && difference(half, all) > 0.01, `${difference(uncut, half)} and ${difference(half, all)} of the picture change`);
  assert.ok(difference(half, await seen(0.5)) < 0.001, "the stock at a time is another one when it comes from later");
  assert.ok(difference(uncut, await seen(0)) < 0.001, "the stock before the first cut does not come back");

  // It is cut while the program plays, and the page stays free for other things.
  await page.locator("#time").fill(`${0.3 * end}`);
  await settled();
  const before = await wholePicture(page);
  const longest = await longestTask(page, async () => {
    await page.locator("#play").click();
    await page.waitForTimeout(4000);
    await page.locator("#play").click();
  });
  note("stock that is cut while it plays: longest task of the page", `${longest.toFixed(0)} ms`);
  assert.ok(longest > 0 && longest < TASK, `a task of the page took ${longest} ms`);
  await settled();
  const after = await wholePicture(page);
  assert.ok(difference(before, after) > 0.0005, "nothing was cut while it played");
  // A part of the picture was drawn anew at a time: all of it, drawn at once, is the same.
  await page.getByLabel("Surface", { exact: true }).uncheck();
  await drawn(page);
  await page.getByLabel("Surface", { exact: true }).check();
  await drawn(page);
  const whole = await wholePicture(page);
  assert.ok(difference(after, whole) < 0.001, `${difference(after, whole)} of the picture is not drawn anew`);
  await page.getByLabel("Tool", { exact: true }).check();
  // At a time of its own: where it stood after playing depends on the machine.
  await page.locator("#time").fill(`${0.75 * end}`);
  await settled();
  await picture(page, "stock");
  await page.getByLabel("Stock").uncheck();
  await drawn(page);
  assert.ok(difference(whole, await wholePicture(page)) > 0.01, "the stock stays in the picture");
  assert.deepEqual(errors, []);
  await context.close();
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

/** Asserts that the sample with a fault is today's program with one height changed, as the README changes it; UPDATE_EXPECT=1 writes it. */
function plantedSample(program) {
  const lines = program.split("\n");
  const first = lines.findIndex((line) => line.includes("pass 15"));
  const move = lines.findIndex((line, at) => at > first && line.startsWith("G1"));
  lines[move] = lines[move].replace(/ Z[-\d.]+/, " Z-13.7");
  for (const file of ["../samples/edited.ngc", "../dist/samples/edited.ngc"].map(here)) {
    if (process.env.UPDATE_EXPECT === "1") writeFileSync(file, lines.join("\n"));
    assert.equal(readFileSync(file, "utf8"), lines.join("\n"), `${file} is another program; UPDATE_EXPECT=1 writes it anew`);
  }
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

/** Pixels of the picture that are near a colour: the place of the topmost one on the screen, and their number. */
async function pixels(page, near) {
  const box = await page.locator("#view canvas").boundingBox();
  const found = await page.evaluate((near) => {
    const from = document.querySelector("#view canvas");
    const copy = Object.assign(document.createElement("canvas"), { width: from.clientWidth, height: from.clientHeight });
    const brush = copy.getContext("2d");
    brush.drawImage(from, 0, 0, copy.width, copy.height);
    const { data } = brush.getImageData(0, 0, copy.width, copy.height);
    let [first, count] = [0, 0];
    for (let at = 0; at < data.length; at += 4) {
      if (data[at + 3] < 200 || near.some((value, k) => Math.abs(data[at + k] - value) > 40)) continue;
      if (count === 0) first = at / 4;
      count += 1;
    }
    return { x: first % copy.width, y: Math.floor(first / copy.width), count };
  }, near);
  return { x: box.x + found.x, y: box.y + found.y, count: found.count };
}

/** Cutter, holder and machine come from libraries; the part is dragged on the machine. */
async function choosing(url) {
  const { page, errors, context } = await open(url);
  const job = () => page.locator("#job-text").inputValue();
  await page.locator("#chooser").setInputFiles(["job.toml", "part.step"].map((name) => here(`../../examples/step-face/${name}`)));
  await page.locator("#run:enabled").waitFor();
  const before = await job();
  const library = (kind) => ({
    name: "shop.toml",
    mimeType: "text/plain",
    buffer: Buffer.from(`schema = "trunnion-library/1"\nname = "shop"\n\n[[cutter]]\nname = "our finisher"\nnumber = 41\nkind = "${kind}"\ndiameter = 9\nlength = 95\n
[[holder]]\nname = "our chuck"\nprofile = [[0, 12], [30, 20]]\n\n[[machine]]\nname = "hall 2"\nfile = "ac-trunnion"\n`),
  });
  // A faulty library is refused at its line, and nothing of it is offered.
  await page.locator("#chooser").setInputFiles(library("bell"));
  await page.locator("#problems .bad").first().waitFor();
  assert.match(await page.locator("#problems").textContent(), /shop\.toml:7:8: /);
  assert.equal(await page.locator("#choose-cutter option", { hasText: "our finisher" }).count(), 0);
  await page.locator("#chooser").setInputFiles(library("ball"));
  await page.locator("#choose-cutter option", { hasText: "our finisher" }).waitFor({ state: "attached" });
  await page.getByRole("tab", { name: "Job" }).click();

  await page.locator("#choose-machine").selectOption({ label: "hall 2" });
  assert.match(await job(), /^file = "ac-trunnion"/m);
  await page.locator("#choose-cutter").selectOption("our finisher");
  const tool = /^\[tool\]\n([\s\S]*?)\n\n/m.exec(await job())[1];
  for (const line of ["number = 41", 'kind = "ball"', "diameter = 9", "length = 95"]) assert.ok(tool.includes(line), `${line} is not in\n${tool}`);
  assert.doesNotMatch(tool, /major_radius|minor_radius|corner_radius/);
  await page.locator("#choose-holder").selectOption("our chuck");
  // 95 mm to the gauge point, 30 mm of them in the holder.
  assert.match(await job(), /^holder = \[\[65, 12\], \[95, 20\]\]/m);
  assert.equal(await page.locator("#choose-holder").inputValue(), "our chuck");
  await page.locator("#choose-cutter").selectOption("ball end mill 12 mm");
  assert.doesNotMatch(await job(), /^holder/m);
  assert.equal(await page.locator("#choose-cutter").inputValue(), "ball end mill 12 mm");
  await page.waitForFunction(() => document.querySelectorAll("#faults li").length === 0);

  // The blue arrow of the frame is along z: dragged up, it changes z alone, and the job has the new value.
  await page.locator("#drag").selectOption("translate");
  const numbers = async (key) => new RegExp(`^${key} = \\[(.*?)\\]`, "m").exec(await job())[1].split(",").map(Number);
  await page.waitForTimeout(500);
  const origin = await numbers("origin");
  const arrow = await pixels(page, [0, 0, 255]);
  assert.ok(arrow.count > 20, "the frame has no blue arrow");
  await picture(page, "frame");
  await page.mouse.move(arrow.x, arrow.y + 4);
  await page.mouse.down();
  await page.mouse.move(arrow.x, arrow.y - 30, { steps: 4 });
  await page.mouse.up();
  const moved = await numbers("origin");
  assert.deepEqual(moved.slice(0, 2), origin.slice(0, 2));
  assert.ok(moved[2] > origin[2] + 1, `z went from ${origin[2]} to ${moved[2]}`);
  // Turned about the same axis: the origin stays.
  await page.locator("#drag").selectOption("rotate");
  await page.waitForTimeout(300);
  const ring = await pixels(page, [0, 0, 255]);
  await page.mouse.move(ring.x, ring.y + 1);
  await page.mouse.down();
  await page.mouse.move(ring.x + 40, ring.y, { steps: 4 });
  await page.mouse.up();
  assert.deepEqual(await numbers("origin"), moved);
  assert.notDeepEqual(await numbers("rotation"), /^rotation = \[(.*?)\]/m.exec(before)[1].split(",").map(Number));
  await page.locator("#drag").selectOption("");
  assert.deepEqual(errors, []);
  await context.close();
}

/** The program without its planted fault, and with one pass in the air, beside the one with the fault. */
async function comparing({ page, context, errors }, faultless) {
  const texts = [readFileSync(here("../samples/edited.ngc"), "utf8"), faultless].map((text) => text.split("\n"));
  const [planted, lines] = texts;
  const fault = planted.findIndex((text, at) => text !== lines[at]) + 1;
  const [start, end] = [13, 14].map((pass) => lines.findIndex((text) => text === `(pass ${pass})`));
  for (let at = start + 1; at < end; at += 1) lines[at] = lines[at].replace(/Z(-?[\d.]+)/, (_, z) => `Z${(Number(z) + 5).toFixed(4)}`);
  const changed = planted.map((text, at) => (text === lines[at] ? 0 : at + 1)).filter((line) => line > 0);
  const program = { name: "other.ngc", mimeType: "text/plain", buffer: Buffer.from(lines.join("\n")) };
  await page.locator("#compare").click();
  await page.locator("#second-chooser").setInputFiles(program);
  await page.waitForFunction((name) => document.querySelector("#second-choice").value === name, program.name);
  await picture(page, "compare-with");
  await page.locator("#compare-go").click();
  await page.locator("#tab-comparison").waitFor({ state: "visible", timeout: PATIENCE });
  await page.locator("#progress").waitFor({ state: "hidden", timeout: PATIENCE });
  await page.getByRole("button", { name: "Reset" }).click();
  const row = async (name) => page.locator("#comparison-table tr", { hasText: name }).locator("td").allTextContents();
  const gouge = await row("Deepest gouge");
  assert.ok(Number(gouge[0]) > 2 && Number(gouge[1]) < 2 && /better/.test(gouge[2]), `${gouge}`);
  const excess = await row("Largest excess");
  assert.ok(Number(excess[0]) < 20 && Number(excess[1]) > 40 && /worse/.test(excess[2]), `${excess}`);
  assert.match(await page.locator("#difference-count").textContent(), new RegExp(`^${2 * changed.length} lines`));
  await picture(page, "compare");
  // Where the paths differ, each has its colour.
  const [blue, orange] = [await pixels(page, [0, 114, 178]), await pixels(page, [213, 94, 0])];
  assert.ok(blue.count > 20 && orange.count > 20, `${blue.count} blue and ${orange.count} orange pixels`);
  // A difference leads to its place in both programs, and the tools go together.
  await page.locator("#program").evaluate((element) => (element.scrollTop = 0));
  await page.waitForTimeout(200);
  for (const first of changed.filter((line) => !changed.includes(line - 1))) {
    await page.locator("#next-difference").click();
    await becomes(page, first, first);
  }
  assert.equal(await current(page), fault);
  assert.equal(await page.locator("#program .first").getAttribute("data-line"), `${fault}`);
  assert.equal(await page.locator("#program .second").getAttribute("data-other"), `${fault}`);
  await page.locator("#program .there").waitFor();
  await page.locator("#time").fill("20");
  await page.waitForTimeout(300);
  assert.equal(await page.locator("#program .there").count(), 1, "the second program has no current line in sight");
  await page.locator("#show-second").uncheck();
  await page.waitForTimeout(200);
  const hidden = await pixels(page, [213, 94, 0]);
  assert.ok(hidden.count < orange.count / 2, `${hidden.count} of ${orange.count} orange pixels stay`);
  const tool = await pixels(page, [0, 114, 178]);
  await page.locator("#end-comparison").click();
  await page.waitForTimeout(200);
  assert.equal(await page.locator("#program .first, #program .second").count(), 0);
  assert.ok((await pixels(page, [0, 114, 178])).count < tool.count / 2, "the tool keeps the colour of the first program");
  assert.deepEqual(errors, []);
  await context.close();
}

/** Files that no page can hold, and files that are none: said in words, while all else stays open. */
async function limits(url) {
  const { page, errors, context } = await open(url);
  const folder = mkdtempSync(join(tmpdir(), "studio-"));
  folders.push(folder);
  const sparse = (name, size) => {
    const path = join(folder, name);
    closeSync(openSync(path, "w"));
    truncateSync(path, size);
    return path;
  };
  await page.locator("#chooser").setInputFiles(here("../samples/edited.ngc"));
  await page.locator("#view canvas").waitFor();
  // Nothing of it is read: its size says enough.
  await page.locator("#chooser").setInputFiles(sparse("two.step", 2 ** 31));
  await page.getByText(/two\.step: has 2147483648 bytes; at most \d+ are read/).waitFor();
  assert.ok(!(await page.locator("#inputs").textContent()).includes("two.step"));
  // What may work is asked for first.
  for (const [name, size, words] of [
    ["hundreds.ngc", 6e8, /hundreds\.ngc: has 600\.0 MB; opening it takes about [\d.]+ GB of memory.*use the command line/],
    ["large.step", 5e7, /large\.step: has 50\.0 MB; opening it takes about [\d.]+ MB of memory.*It may take minutes/],
  ]) {
    await page.locator("#chooser").setInputFiles(sparse(name, size));
    await page.getByText(words).waitFor();
    if (name === "large.step") await picture(page, "large");
    await page.locator("#large-leave").click();
    assert.ok(!(await page.locator("#inputs").textContent()).includes(name));
  }
  // Files of other kinds.
  for (const [name, buffer] of [
    ["empty.step", Buffer.alloc(0)],
    ["photo.step", Buffer.from([0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10, 0, 1, 2, 3])],
    ["archive.toml", Buffer.from("PK\u0003\u0004 and so on")],
    ["empty.toml", Buffer.alloc(0)],
  ]) {
    await page.locator("#chooser").setInputFiles({ name, mimeType: "", buffer });
    await page.getByText(new RegExp(`^${name}(:\\d+:\\d+)?: `)).first().waitFor();
    assert.ok(await page.locator("#view canvas").isVisible());
  }
  assert.deepEqual(errors, []);
  await context.close();
}

/** A blade is planned and checked. */
async function impeller(url, folder) {
  const { page, errors, context } = await open(url);
  const start = performance.now();
  await page.getByRole("button", { name: "Impeller" }).click();
  await page.locator("#verdict").waitFor({ state: "visible", timeout: PATIENCE });
  await page.locator("#progress").waitFor({ state: "hidden", timeout: PATIENCE });
  note("Impeller: opened and worked on", `${((performance.now() - start) / 1000).toFixed(1)} s`);
  assert.match(await page.locator("#verdict").getAttribute("class"), /good/);
  assert.ok((await colours(page)) > 8, "Impeller: the picture is blank");
  await picture(page, "Impeller");
  await compare(page, "Impeller", folder);
  assert.deepEqual(errors, []);
  await context.close();
}

/** Longest that the page may work without a break while a long program is opened and played [ms of processor time]: a frame. */
const TASK = 100;

/** A long program is opened and played in short steps. */
async function longProgram(url) {
  const { page, errors, context } = await open(url);
  const moves = Array.from({ length: 600_000 }, (_, k) => `G1 X${(k / 5000).toFixed(4)} Y${(k % 7).toFixed(4)} Z${(3 + (k % 3)).toFixed(4)} B10.0000 C${(k / 1000).toFixed(4)} F2000`);
  const folder = mkdtempSync(join(tmpdir(), "studio-"));
  folders.push(folder);
  const file = join(folder, "long.ngc");
  // From the disk: the test would otherwise hand the text over in a task of its own.
  writeFileSync(file, `G21 G90 G94\n${moves.join("\n")}\nM30\n`);
  await page.waitForTimeout(1500);
  const longest = await longestTask(page, async () => {
    await page.locator("#chooser").setInputFiles(file);
    await page.locator("#transport").waitFor({ timeout: PATIENCE });
    await page.locator("#play").click();
    await page.waitForTimeout(1500);
  });
  note("long program: longest task of the page", `${longest.toFixed(0)} ms`);
  assert.ok(longest > 0 && longest < TASK, `a task of the page took ${longest} ms`);
  assert.match(await page.locator("#lines").textContent(), /^600002 lines/);
  assert.deepEqual(errors, []);
  await context.close();
}

/** An engine without memory ends with words, and works again. */
async function outOfMemory(url) {
  const small = await launch(["--js-flags=--wasm-max-mem-pages=700"]);
  const { page, errors, context } = await open(url, {}, small);
  const long = Array.from({ length: 400_000 }, (_, k) => `G1 X${k / 1000} Y${k % 7} Z3 B10 C${k % 360} F2000`).join("\n");
  await page.locator("#chooser").setInputFiles({ name: "long.ngc", mimeType: "text/plain", buffer: Buffer.from(`G21 G90 G94\n${long}\n`) });
  await page.getByText(/long\.ngc: out of memory\s+help: .*use the command line/).first().waitFor();
  assert.match(await page.locator("#inputs").textContent(), /long\.ngc/);
  await page.locator("#chooser").setInputFiles(here("../samples/edited.ngc"));
  await page.locator("#transport").waitFor();
  // What fails deep inside ends the engine: it is said, and the files are there for the next one.
  await page.locator("#home").click();
  await page.getByRole("button", { name: "Planted fault" }).click();
  await page.getByText(/the engine stopped: its memory is used up\s+help: .*use the command line/).waitFor({ timeout: PATIENCE });
  assert.match(await page.locator("#inputs").textContent(), /edited\.ngc/);
  assert.deepEqual(errors, []);
  await context.close();
  await small.close();
}

const site = await serve();
try {
  await firstPaint(site.url);

  // The same work by the command line, whose bytes the page has to write.
  const patchFolder = await commandLine("run", "examples/bezier-patch/job.toml");
  const patchProgram = readFileSync(join(patchFolder, "program.linuxcnc.ngc"), "utf8");
  plantedSample(patchProgram);
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
  await page.locator("#measure").selectOption("distance");
  await page.mouse.click(x, y);
  await page.mouse.click(x + 40, y);
  assert.match(await page.locator("#picked").textContent(), /^[\d.]+ mm/);
  // The angle at the corner of a thin triangle, and at its other end: together with the third they are 180 degrees.
  await page.locator("#measure").selectOption("angle");
  const corners = [[x, y], [x + 60, y], [x + 30, y - 50]];
  let sum = 0;
  for (const turn of [0, 1, 2]) {
    for (const k of [0, 1, 2]) await page.mouse.click(...corners[(turn + k) % 3]);
    sum += Number.parseFloat(/^([\d.]+)°/.exec(await page.locator("#picked").textContent())[1]);
  }
  assert.ok(Math.abs(sum - 180) < 0.01, `the angles of a triangle add up to ${sum}`);
  await page.locator("#measure").selectOption("");
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

  const impellerFolder = await commandLine("run", "examples/impeller/job.toml");
  await impeller(site.url, impellerFolder);

  // A problem leads to its block.
  const planted = await sample(site.url, "Planted fault", { passes: false, words: /gouge/ });
  await planted.page.locator("#problems button.bad").first().click();
  const words = await planted.page.locator("#problems button.bad").first().textContent();
  const [, line] = /line (\d+)/.exec(words);
  await becomes(planted.page, Number(line), Number(line));
  assert.equal(await planted.page.locator("#program .bad").getAttribute("data-line"), line);
  await picture(planted.page, "place");
  await compare(planted.page, "Planted fault", plantedFolder);
  await comparing(planted, patchProgram);

  await cutting(site.url);
  await planning(site.url);
  await choosing(site.url);
  await longProgram(site.url);
  await limits(site.url);
  await outOfMemory(site.url);

  // Passes are on the part while they are placed; the work can be stopped then, and done again.
  const stopped = await open(site.url);
  const begun = performance.now();
  await stopped.page.getByRole("button", { name: "Bezier patch" }).click();
  await stopped.page.getByText(/placing strips: \d+ pass/).waitFor();
  note("Bezier patch: first passes", `${((performance.now() - begun) / 1000).toFixed(1)} s`);
  await stopped.page.getByText(/placing strips: ([3-9]|\d{2,}) passes/).waitFor();
  await stopped.page.screenshot({ path: here("pictures/placing.png") });
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
