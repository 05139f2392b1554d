// Figures of the studio beside what is wanted: printed, never asserted.
//
//   node test/measure.mjs TRUNNION
//
// Runs nothing else meanwhile: every time is that of the machine as it is.

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { gzipSync } from "node:zlib";
import { PATIENCE, browser, launch, open, serve, stop, trunnion, watchFrames } from "./studio.mjs";

const here = (name) => new URL(name, import.meta.url).pathname;
const dist = here("../dist");
const samples = join(dist, "samples");
const job = "examples/bezier-patch/job.toml";

/** Blocks of the long program. */
const BLOCKS = 100_000;
/** Faults that are planted in it, and how deep they are \[mm\]. */
const FAULTS = 5;
const DEPTH = 0.005;

function print(what, value, wanted) {
  process.stdout.write(`${what.padEnd(58)} ${value.padStart(12)}   wanted ${wanted}\n`);
}

const megabytes = (bytes) => `${(bytes / 1e6).toFixed(2)} MB`;
const seconds = (milliseconds) => `${(milliseconds / 1000).toFixed(1)} s`;

function sizes() {
  const compressed = (file) => gzipSync(readFileSync(join(dist, file)), { level: 9 }).length;
  const files = readdirSync(dist).filter((name) => name.includes("."));
  const [engine, rest] = [true, false].map((isEngine) => files.filter((name) => name.endsWith(".wasm") === isEngine).reduce((sum, name) => sum + compressed(name), 0));
  print("engine, compressed", megabytes(engine), "<= 4 MB, aim 2.5 MB");
  print("page without engine and samples, compressed", megabytes(rest), "<= 2 MB, aim 1 MB");
}

async function firstPaint(url) {
  const { page, context } = await open(url);
  const painted = () => performance.getEntriesByName("first-contentful-paint")[0]?.startTime;
  await page.waitForFunction(painted);
  print("first paint", `${(await page.evaluate(painted)).toFixed(0)} ms`, "<= 1000 ms, aim 500 ms");
  await context.close();
}

/** Works until the verdict is there; returns the time \[ms\] and the longest frame \[ms\]. */
async function work(page, start) {
  await watchFrames(page);
  const before = performance.now();
  await start();
  await page.locator("#verdict").waitFor({ state: "visible", timeout: PATIENCE });
  const time = performance.now() - before;
  return { time, longest: await page.evaluate(() => window.longest) };
}

async function planted(url) {
  const { page, context } = await open(url);
  const { time } = await work(page, () => page.getByRole("button", { name: "Planted fault" }).click());
  print("sample with a planted fault: opened and checked", seconds(time), "<= 15 s, aim 6 s");
  // The engine is loaded now: the check alone, against the program on one thread.
  await page.evaluate(() => (document.querySelector("#verdict").hidden = true));
  const again = await work(page, () => page.locator("#check").click());
  const out = mkdtempSync(join(tmpdir(), "studio-"));
  const begin = performance.now();
  try {
    execFileSync(trunnion, ["check", "edited.ngc", "--job", job, "--output", out], { cwd: samples, env: { ...process.env, RAYON_NUM_THREADS: "1" }, stdio: "ignore" });
  } catch {
    // The fault is planted: the verdict is 1.
  }
  const native = performance.now() - begin;
  rmSync(out, { recursive: true });
  print(`check in the page against the command line (${seconds(native)})`, `${(again.time / native).toFixed(2)} x`, "<= 3 x, aim 1.6 x");
  await context.close();
}

/** Divides the moves of a program into BLOCKS blocks, and lowers the tool at the middle of some passes. */
function longProgram(text) {
  const lines = text.split("\n");
  const moves = lines.filter((line) => /^G1 /.test(line)).length;
  const parts = Math.ceil(BLOCKS / moves);
  const starts = lines.flatMap((line, at) => (/^\(pass \d+\)/.test(line) ? [at] : []));
  const passes = Array.from({ length: FAULTS }, (_, k) => Math.floor(((k + 1) * starts.length) / (FAULTS + 1)));
  const faulty = new Set(passes.map((pass) => Math.floor((starts[pass] + (starts[pass + 1] ?? lines.length)) / 2)));
  const modal = {};
  const out = [];
  const places = [];
  lines.forEach((line, at) => {
    const words = Object.fromEntries([...line.matchAll(/([XYZBCF])(-?[\d.]+)/g)].map(([, letter, value]) => [letter, Number(value)]));
    const isMove = /^G1 /.test(line) && ["X", "Y", "Z"].every((letter) => letter in modal);
    if (!isMove) {
      out.push(line);
      if (!line.startsWith("(")) Object.assign(modal, words);
      return;
    }
    const from = { ...modal };
    Object.assign(modal, words);
    for (let part = 1; part <= parts; part += 1) {
      const mixed = ["X", "Y", "Z", "B", "C"].filter((letter) => letter in from).map((letter) => {
        const value = from[letter] + ((modal[letter] - from[letter]) * part) / parts;
        const lowered = letter === "Z" && part === parts && faulty.has(at) ? value - DEPTH : value;
        return `${letter}${lowered.toFixed(4)}`;
      });
      if (part === parts && faulty.has(at)) places.push(out.length + 1);
      out.push(`G1 ${mixed.join(" ")} F${(modal.F * parts).toFixed(3)}`);
    }
  });
  return { text: out.join("\n"), places };
}

/** Frames per second while a program plays for a time [ms], and the longest frame [ms]. */
const played = (page, time) =>
  page.evaluate(async (time) => {
    document.querySelector("#play").click();
    const begin = performance.now();
    let [frames, longest, before] = [0, 0, begin];
    while (before - begin < time) {
      await new Promise(requestAnimationFrame);
      const now = performance.now();
      longest = Math.max(longest, now - before);
      before = now;
      frames += 1;
    }
    document.querySelector("#play").click();
    return { rate: (1000 * frames) / (before - begin), longest };
  }, time);

/** Plays from the middle, where stock is there already, with stock that is cut and without. */
async function play(page, how) {
  const end = Number(await page.locator("#time").getAttribute("max"));
  for (const isCut of [true, false]) {
    await page.getByLabel("Stock").setChecked(isCut);
    await page.locator("#time").fill(`${0.4 * end}`);
    await page.waitForTimeout(2000);
    await page.locator("#behind").waitFor({ state: "hidden", timeout: PATIENCE });
    await page.waitForTimeout(2000);
    const { rate, longest } = await played(page, 5000);
    const what = `${how}, ${isCut ? "stock is cut" : "no stock"}`;
    print(`frames per second: ${what}`, rate.toFixed(0), ">= 20, aim 60");
    print(`longest frame: ${what}`, `${longest.toFixed(0)} ms`, "<= 100 ms");
  }
}

/** Opens the long program beside its job. */
async function openLong(url, file, of) {
  const { page, context } = await open(url, {}, of);
  const inputs = [job, "fixtures/bezier-patch/patch.json", "machines/bc-trunnion.toml"].map((name) => join(samples, name));
  await page.locator("#chooser").setInputFiles([...inputs, file]);
  await page.locator("#check:enabled").waitFor({ timeout: PATIENCE });
  const { time, longest } = await work(page, () => page.locator("#check").click());
  return { page, context, time, longest };
}

async function long(url) {
  const out = mkdtempSync(join(tmpdir(), "studio-"));
  execFileSync(trunnion, ["run", job, "--output", out], { cwd: samples, stdio: "ignore" });
  const { text, places } = longProgram(readFileSync(join(out, "program.linuxcnc.ngc"), "utf8"));
  const file = join(out, "long.ngc");
  writeFileSync(file, text);
  const { page, context, time, longest } = await openLong(url, file, browser);
  const words = await page.locator("#problems").textContent();
  const found = places.filter((line) => [...words.matchAll(/line (\d+)/g)].some(([, named]) => Math.abs(Number(named) - line) <= 40));
  const blocks = text.split("\n").length;
  print(`program of ${blocks} lines checked`, seconds(time), "<= 90 s, aim 30 s");
  print(`faults of ${(1000 * DEPTH).toFixed(0)} um found`, `${found.length} of ${places.length}`, "all");
  print("longest frame meanwhile", `${longest.toFixed(0)} ms`, "<= 100 ms");
  await play(page, "all by software GL");
  await context.close();
  // A browser without graphics card puts its pages together itself, and has software GL for pictures alone.
  const plain = await launch(["--use-angle=swiftshader-webgl"]);
  const other = await openLong(url, file, plain);
  await play(other.page, "pictures by software GL");
  await plain.close();
  rmSync(out, { recursive: true });
}

const site = await serve();
try {
  sizes();
  await firstPaint(site.url);
  await planted(site.url);
  await long(site.url);
} finally {
  stop(site);
  await browser.close();
}
