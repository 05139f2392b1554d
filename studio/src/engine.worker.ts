// The engine in a worker, so that the page never waits for it.

import start, { Engine, type Stock, lastPanic, machines } from "./engine/trunnion_web.js";
import { rowsOf, sharedLines } from "./linediff";
import { PlacedPasses } from "./placed";
import { drawingOf, drawingOfPart, linesOf, movesOf, textOf, withArrays } from "./report";
import { Timeline } from "./timeline";
import type { Answer, Bricks, Library, Machine, PartFaces, Replay, Reply, Request, StockCut, StockInfo } from "./messages";

let engine: Engine | undefined;
/** Stock that is cut for the picture. */
let stock: Stock | undefined;

const ready = start().then(() => {
  engine = new Engine();
});

/** Milliseconds between two reports of progress: more would only keep the page busy. */
const PAUSE = 100;

/** Milliseconds between two pictures of the passes: each is drawn anew. */
const PICTURE = 250;

function reporter(id: number) {
  let last = 0;
  return (stage: string, done: number, total: number) => {
    const now = performance.now();
    if (now - last >= PAUSE || done === total) {
      last = now;
      send({ id, kind: "progress", stage, done, total });
    }
    return true;
  };
}

/** Runs a job; passes are sent as they are placed, and the last of them before anything else is done. */
function run(of: Engine, { id, job }: { id: number; job: string }): string {
  const [placed, report] = [new PlacedPasses(), reporter(id)];
  let [stageBefore, last] = ["", 0];
  const show = () => {
    last = performance.now();
    const faces = placed.changes();
    if (faces.size > 0) send({ id, kind: "passes", count: placed.count, faces });
  };
  const onProgress = (stage: string, done: number, total: number) => {
    if (stage !== stageBefore) show();
    stageBefore = stage;
    return report(stage, done, total);
  };
  const onPasses = (face: number, kept: number, points: Float32Array, counts: Uint32Array) => {
    placed.take(face, kept, points, counts);
    if (performance.now() - last >= PICTURE) show();
  };
  return of.run(job, onProgress, onPasses);
}

function send(reply: Reply) {
  self.postMessage(reply, { transfer: [...buffersOf(reply)] });
}

/** Buffers of all arrays inside a value: handed over, they are not copied while the page waits. */
function buffersOf(value: unknown, found = new Set<ArrayBuffer>()): Set<ArrayBuffer> {
  if (ArrayBuffer.isView(value)) found.add(value.buffer as ArrayBuffer);
  else if (value instanceof Map) for (const one of value.values()) buffersOf(one, found);
  else if (Array.isArray(value)) {
    // Lists of numbers hold no arrays; only their first entry is looked at.
    if (typeof value[0] === "object") for (const one of value) buffersOf(one, found);
  } else if (value !== null && typeof value === "object") for (const one of Object.values(value)) buffersOf(one, found);
  return found;
}

/** Moves of a program as arrays of their own. */
function replay(of: Engine, options: string[]): Replay {
  const timeline = of.timeline(options);
  const { machine, tools, has_stock } = JSON.parse(timeline.model());
  const arrays = {
    times: timeline.times(),
    lines: timeline.lines(),
    kinds: timeline.kinds(),
    axes: timeline.axes(),
    poses: timeline.poses(),
  };
  timeline.free();
  return { ...arrays, machine, tools, has_stock };
}

/** Faces of a part as arrays of their own. */
function facesOf(of: Engine, name: string, rotation: number[]): PartFaces {
  const part = of.part(name, Float64Array.from(rotation));
  const { faces, warnings } = JSON.parse(part.model());
  const arrays = { positions: part.positions(), triangles: part.triangles(), edges: part.edges() };
  part.free();
  return { ...arrays, faces, warnings };
}

/** Milliseconds for which stock is cut before what has changed is sent: the slider may be elsewhere by then. */
const SLICE = 60;
/** The same on a long way: most of the time would go into pictures between. */
const LONG_SLICE = 500;
/** Shortest and longest that one call should take [ms]: between them the number of moves stays. */
const [SHORTEST, LONGEST] = [12, 40];
/** Most moves of a call: what is cut at once is cut in less time. */
const MOST = 256;
let [pace, slice] = [8, SLICE];

/** Cuts stock towards a time. */
function cutTowards(of: Stock, wanted: number): StockCut {
  const begin = performance.now();
  let [time, before, isThere] = [0, begin, false];
  do {
    time = of.cut(wanted, pace);
    // A time after the end of the program is its end.
    isThere = time >= Math.min(wanted, of.end());
    const now = performance.now();
    if (now - before > LONGEST) pace = Math.max(pace >> 1, 1);
    else if (now - before < SHORTEST) pace = Math.min(2 * pace, MOST);
    before = now;
  } while (!isThere && before - begin < slice);
  slice = isThere ? SLICE : Math.min(2 * slice, LONG_SLICE);
  return { time, isThere, bricks: changesOf(of) };
}

/** Bricks that have changed as arrays of their own. */
function changesOf(of: Stock): Bricks {
  const changes = of.changes();
  const bricks = { counts: changes.counts(), positions: changes.positions(), triangles: changes.triangles() };
  changes.free();
  return bricks;
}

function answer(of: Engine, request: Request): void {
  const { id } = request;
  switch (request.verb) {
    case "insert":
      return of.insert(request.name, request.bytes);
    case "remove":
      return of.remove(request.name);
    case "run":
    case "check":
    case "propose":
    case "readJob": {
      const text =
        request.verb === "run"
          ? run(of, request)
          : request.verb === "readJob"
            ? of.readJob(request.job)
            : of[request.verb](request.options, reporter(id));
      const read = JSON.parse(text) as Answer;
      const done = { ...read, messages: helped(read.messages) };
      const outputs = new Map<string, Uint8Array<ArrayBuffer>>();
      for (const name of done.files) {
        const bytes = of.file(name);
        if (bytes) outputs.set(name, bytes as Uint8Array<ArrayBuffer>);
      }
      // Unpacked here: the page would stand still for a moment.
      const page = [...outputs].find(([name]) => name.endsWith("/report.html"))?.[1];
      const drawing = page ? drawingOf(page) : null;
      return send({ id, kind: "answer", answer: done, outputs, drawing: drawing && withArrays(drawing) });
    }
    case "machines":
      return send({ id, kind: "machines", names: machines() });
    case "part": {
      const part = facesOf(of, request.name, request.rotation);
      return send({ id, kind: "part", part, drawing: withArrays(drawingOfPart(part)) });
    }
    case "machine":
      return send({ id, kind: "machine", machine: JSON.parse(of.machine(request.name)) as Machine });
    case "library":
      return send({ id, kind: "library", library: JSON.parse(of.library(request.name ?? undefined)) as Library });
    case "rows": {
      const [first, second] = request.texts.map((text) => linesOf(textOf(text))) as [string[], string[]];
      return send({ id, kind: "rows", rows: rowsOf(sharedLines(first, second), second.length) });
    }
    case "stock": {
      stock?.free();
      stock = of.stock(request.options, request.cell);
      return send({ id, kind: "stock", stock: stock ? (JSON.parse(stock.model()) as StockInfo) : null });
    }
    case "cut": {
      if (!stock) throw "there is no stock";
      return send({ id, kind: "cut", cut: cutTowards(stock, request.time) });
    }
    case "timeline": {
      const moves = replay(of, request.options);
      const timeline = new Timeline(moves);
      // Computed here: the page would stand still for a moment.
      const drawing = request.isDrawn && timeline.count > 0 ? withArrays(movesOf(timeline)) : null;
      return send({ id, kind: "moves", moves: { replay: moves, motion: timeline.motion(), drawing } });
    }
  }
}

/** Adds what a page can do where the engine found no memory: the words before are those of the command line. */
const helped = (messages: string[]): string[] =>
  messages.map((message) => (/out of memory/.test(message) ? `${message}\n  help: a page has at most 4 GB; use the command line` : message));

/** Words for what ended a verb: messages of the engine, or a defect of it. */
function wordsOf(error: unknown): { messages: string[]; isLost: boolean } {
  if (typeof error === "string") return { messages: helped(error.split(/\n(?! )/)), isLost: false };
  const panic = lastPanic();
  // A defect leaves its words; without any it was the allocator that gave up.
  const isFull = panic === "" && error instanceof WebAssembly.RuntimeError;
  const cause = isFull ? "its memory is used up" : panic || (error instanceof Error ? error.message : String(error));
  const memory = /memory|allocation/i.test(cause);
  const help = memory ? "this page cannot hold the work; use the command line" : "this is a defect of trunnion";
  return { messages: [`the engine stopped: ${cause}\n  help: ${help}`], isLost: true };
}

self.onmessage = async ({ data }: MessageEvent<Request>) => {
  try {
    await ready;
    if (engine) answer(engine, data);
  } catch (error) {
    send({ id: data.id, kind: "failure", ...wordsOf(error) });
  }
};
