// Memory that the engine takes for large files, beside their sizes: the points behind the estimates in src/files.ts.
//
//   node test/memory.mjs [MB,MB,...]
//
// Every file is generated. The figures are those of the engine's memory, which only grows, and of what it hands to the page.

import { readFileSync } from "node:fs";

const here = (name) => new URL(name, import.meta.url).pathname;
const sizes = (process.argv[2] ?? "2,8").split(",").map(Number);
const wasm = readFileSync(here("../src/engine/trunnion_web_bg.wasm"));
const step = readFileSync(here("../../examples/step-face/part.step"), "latin1");
const patch = JSON.parse(readFileSync(here("../../fixtures/bezier-patch/patch.json"), "utf8"));

/** Moves of five axes, one a line, as a program of a finishing pass has them. */
function program(bytes) {
  const lines = ["G21 G90 G94"];
  for (let [at, size] = [0, 12]; size < bytes; at += 1) {
    const angle = at / 500;
    const words = [60 * Math.cos(angle), 60 * Math.sin(angle), -15 + at / 1e5, 20 * Math.sin(at / 900), (at / 40) % 360];
    lines.push(`G1 ${["X", "Y", "Z", "B", "C"].map((axis, k) => axis + words[k].toFixed(4)).join(" ")} F1000.000`);
    size += lines.at(-1).length + 1;
  }
  return [...lines, "M2", ""].join("\n");
}

/** Copies of a face beside each other, each with numbers of its own. */
function parts(bytes) {
  const start = step.indexOf("DATA;") + 5;
  const end = step.indexOf("ENDSEC;", start);
  const [head, data, tail] = [step.slice(0, start), step.slice(start, end), step.slice(end)];
  const last = Math.max(...[...data.matchAll(/^#(\d+)/gm)].map(([, number]) => Number(number)));
  const copies = Array.from({ length: Math.ceil(bytes / data.length) }, (_, k) =>
    data
      .replace(/#(\d+)/g, (_, number) => `#${Number(number) + k * last}`)
      .replace(/(CARTESIAN_POINT\('',\(\s*[^,()]+,\s*)([^,()]+)(,[^,()]+\))/g, (_, before, y, after) => `${before}${(Number(y) + 200 * k).toFixed(6)}${after}`),
  );
  return head + copies.join("") + tail;
}

/** One surface with many points. */
function surface(bytes) {
  const count = Math.ceil(Math.sqrt(bytes / 26));
  const knots = [0, 0, 0, ...Array.from({ length: count - 2 }, (_, k) => k / (count - 3)), 1, 1, 1];
  const points = Array.from({ length: count }, (_, i) => Array.from({ length: count }, (_, j) => [i, j, Math.sin(i / 9) * Math.cos(j / 7)].map((x) => Number(x.toFixed(6)))));
  return JSON.stringify({ ...patch, knots: [knots, knots], points });
}

const KINDS = [
  { name: "program.ngc", of: program, open: (engine, name) => engine.timeline([name, "--machine", "bc-trunnion", "--tool-length", "120"]), arrays: ["times", "lines", "kinds", "axes", "poses"] },
  { name: "part.step", of: parts, open: (engine, name) => engine.part(name), arrays: ["positions", "triangles", "edges"] },
  { name: "surface.json", of: surface, open: (engine, name) => engine.part(name), arrays: ["positions", "triangles", "edges"] },
];

let instance = 0;

for (const { name, of, open, arrays } of KINDS) {
  for (const size of sizes) {
    const bytes = new TextEncoder().encode(of(1e6 * size));
    // A module of its own each time: memory that was taken is never given back.
    const { default: start, Engine } = await import(`../src/engine/trunnion_web.js?${(instance += 1)}`);
    const { memory } = await start({ module_or_path: wasm });
    const engine = new Engine();
    const before = memory.buffer.byteLength;
    const begin = performance.now();
    engine.insert(name, bytes);
    const found = open(engine, name);
    const handed = arrays.reduce((sum, key) => sum + found[key]().byteLength, 0);
    const taken = memory.buffer.byteLength - before;
    const seconds = (performance.now() - begin) / 1000;
    const figures = [bytes.length, taken, handed].map((value) => (value / 1e6).toFixed(1).padStart(7));
    process.stdout.write(`${name.padEnd(13)} ${figures[0]} MB: engine ${figures[1]} MB, ${(taken / bytes.length).toFixed(1).padStart(5)} times; handed over ${figures[2]} MB; ${seconds.toFixed(1)} s\n`);
  }
}
