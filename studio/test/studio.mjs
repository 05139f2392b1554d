// The built site in a real browser, for the test and for the measurements.

import { spawn } from "node:child_process";
import { chromium } from "playwright-core";

const here = (name) => new URL(name, import.meta.url).pathname;
const root = here("../..");
/** The built program: the first word of the command. */
export const trunnion = process.argv[2] ?? `${root}target/release/trunnion`;

/** Longest that a sample may take on a slow machine \[ms\]. */
export const PATIENCE = 480_000;

/** Starts `trunnion studio`, and returns its address. */
export function serve(...files) {
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

export function stop({ child }) {
  child.removeAllListeners("exit");
  child.kill();
}

/** Starts Chromium with further arguments. */
export const launch = (args = []) =>
  chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    // One font on every machine: the pictures are compared.
    env: { ...process.env, FONTCONFIG_FILE: here("fonts.conf") },
    args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader", ...args],
  });

export const browser = await launch();

/** A page whose errors fail the test. */
export async function open(url, options = {}, of = browser) {
  const context = await of.newContext({ viewport: { width: 1280, height: 800 }, ...options });
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => {
    if (message.type() === "error") errors.push(`${message.text()} ${message.location().url}`);
  });
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(url);
  // Its program is read after the first paint, and the gallery is made by it.
  await page.locator("#samples button").first().waitFor({ state: "attached" });
  return { page, errors, context };
}

/** Waits until everything is drawn, a surface of many triangles included. */
export async function drawn(page) {
  await page.waitForTimeout(300);
  await page.waitForFunction(() => !document.querySelector("#view canvas") || document.querySelector("#view").dataset.picture === "whole");
}

/** Longest task of the page's own thread while something happens, in milliseconds of processor time: a busy machine makes it no longer. */
export async function longestTask(page, happen) {
  await browser.startTracing(page, { categories: ["toplevel"] });
  await happen();
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString());
  const threads = traceEvents.filter(({ name, args }) => name === "thread_name" && args.name === "CrRendererMain");
  const isPage = ({ pid, tid }) => threads.some((thread) => thread.pid === pid && thread.tid === tid);
  const tasks = traceEvents.filter((event) => event.tdur !== undefined && /RunTask/.test(event.name) && isPage(event));
  return Math.max(0, ...tasks.map(({ tdur }) => tdur / 1000));
}

/** Longest time between two frames while something happens \[ms\]. */
export const watchFrames = (page) =>
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

