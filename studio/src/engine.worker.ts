// The engine in a worker, so that the page never waits for it.

import start, { Engine, lastPanic, machines } from "./engine/trunnion_web.js";
import { drawingOf } from "./report";
import type { Answer, PartFaces, Replay, Reply, Request } from "./messages";

let engine: Engine | undefined;

const ready = start().then(() => {
  engine = new Engine();
});

/** Milliseconds between two reports of progress: more would only keep the page busy. */
const PAUSE = 50;

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

function send(reply: Reply, transfer: Transferable[] = []) {
  self.postMessage(reply, { transfer });
}

/** Moves of a program as arrays of their own. */
function replay(of: Engine, options: string[]): Replay {
  const timeline = of.timeline(options);
  const { machine, tools } = JSON.parse(timeline.model());
  const arrays = {
    times: timeline.times(),
    lines: timeline.lines(),
    kinds: timeline.kinds(),
    axes: timeline.axes(),
    poses: timeline.poses(),
  };
  timeline.free();
  return { ...arrays, machine, tools };
}

/** Faces of a part as arrays of their own. */
function facesOf(of: Engine, name: string): PartFaces {
  const part = of.part(name);
  const { faces, warnings } = JSON.parse(part.model());
  const arrays = { positions: part.positions(), triangles: part.triangles(), edges: part.edges() };
  part.free();
  return { ...arrays, faces, warnings };
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
          ? of.run(request.job, reporter(id))
          : request.verb === "readJob"
            ? of.readJob(request.job)
            : of[request.verb](request.options, reporter(id));
      const done = JSON.parse(text) as Answer;
      const outputs = new Map<string, Uint8Array<ArrayBuffer>>();
      for (const name of done.files) {
        const bytes = of.file(name);
        if (bytes) outputs.set(name, bytes as Uint8Array<ArrayBuffer>);
      }
      // Unpacked here: the page would stand still for a moment.
      const page = [...outputs].find(([name]) => name.endsWith("/report.html"))?.[1];
      const drawing = page ? drawingOf(page) : null;
      return send({ id, kind: "answer", answer: done, outputs, drawing }, [...outputs.values()].map((bytes) => bytes.buffer));
    }
    case "machines":
      return send({ id, kind: "machines", names: machines() });
    case "part": {
      const part = facesOf(of, request.name);
      return send({ id, kind: "part", part }, [part.positions, part.triangles, part.edges].map((array) => array.buffer as ArrayBuffer));
    }
    case "timeline": {
      const moves = replay(of, request.options);
      const { times, lines, kinds, axes, poses } = moves;
      return send({ id, kind: "replay", replay: moves }, [times, lines, kinds, axes, poses].map((array) => array.buffer as ArrayBuffer));
    }
  }
}

/** Words for what ended a verb: messages of the engine, or a defect of it. */
function wordsOf(error: unknown): { messages: string[]; isLost: boolean } {
  if (typeof error === "string") return { messages: error.split("\n"), isLost: false };
  const panic = lastPanic();
  const cause = panic || (error instanceof Error ? error.message : String(error));
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
