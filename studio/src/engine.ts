// The worker as functions that return promises.

import type { Drawing } from "./report";
import type { Answer, Library, Machine, Moves, Outputs, PartFaces, Reply, Request, StockCut, StockInfo } from "./messages";

export type Files = Map<string, Uint8Array<ArrayBuffer>>;
export type OnProgress = (stage: string, done: number, total: number) => void;
/** Hears the number of passes so far, and the ends of the segments of faces whose passes have changed. */
export type OnPasses = (count: number, faces: Map<number, Float32Array>) => void;

/** Who hears of a verb while it works. */
interface Listeners {
  onProgress?: OnProgress;
  onPasses?: OnPasses;
}

/** Verb that could not be finished; its messages are those of the command line. */
export class Refused extends Error {
  constructor(readonly messages: string[]) {
    super(messages.join("\n"));
  }
}

interface Waiting {
  resolve: (reply: Reply) => void;
  reject: (error: Refused) => void;
  listeners: Listeners;
}

type Verb<R> = R extends { id: number } ? Omit<R, "id"> : never;

/** Result of a run or check with the files that it wrote. */
export interface Done {
  answer: Answer;
  outputs: Outputs;
  /** What the report of the outputs draws. */
  drawing: Drawing | null;
}

export class EngineClient {
  /** Everything that is open. The worker has a copy, which is made again if the worker ends. */
  readonly files: Files = new Map();
  /** Files that verbs wrote: a program among them can be checked. */
  private readonly made: Files = new Map();
  private worker = this.begin();
  private waiting = new Map<number, Waiting>();
  private last = 0;

  private begin(): Worker {
    const worker = new Worker(new URL("./engine.worker.ts", import.meta.url), { type: "module" });
    worker.onmessage = ({ data }: MessageEvent<Reply>) => this.receive(data);
    worker.onerror = (event) => this.lose([`the engine cannot start: ${event.message || "it could not be loaded"}`]);
    return worker;
  }

  private receive(reply: Reply): void {
    const waiting = this.waiting.get(reply.id);
    if (!waiting) return;
    if (reply.kind === "progress") return waiting.listeners.onProgress?.(reply.stage, reply.done, reply.total);
    if (reply.kind === "passes") return waiting.listeners.onPasses?.(reply.count, reply.faces);
    this.waiting.delete(reply.id);
    if (reply.kind !== "failure") return waiting.resolve(reply);
    waiting.reject(new Refused(reply.messages));
    // After a defect the memory of the module is not to be trusted.
    if (reply.isLost) this.restart();
  }

  /** Ends every verb that waits, with these messages. */
  private lose(messages: string[]): void {
    for (const { reject } of this.waiting.values()) reject(new Refused(messages));
    this.waiting.clear();
  }

  private restart(): void {
    this.worker.terminate();
    this.worker = this.begin();
    for (const [name, bytes] of [...this.files, ...this.made]) this.tell({ verb: "insert", name, bytes });
  }

  /** Stops what runs, at once; the files stay. */
  cancel(): void {
    this.lose(["stopped on request"]);
    this.restart();
  }

  private tell(verb: Verb<Request>): number {
    this.last += 1;
    this.worker.postMessage({ ...verb, id: this.last });
    return this.last;
  }

  private ask(verb: Verb<Request>, listeners: Listeners = {}): Promise<Reply> {
    return new Promise((resolve, reject) => {
      this.waiting.set(this.tell(verb), { resolve, reject, listeners });
    });
  }

  private async done(verb: Verb<Request>, listeners: Listeners = {}): Promise<Done> {
    const reply = await this.ask(verb, listeners);
    if (reply.kind !== "answer") throw new Refused(["the engine gave no answer"]);
    for (const [name, bytes] of reply.outputs) this.made.set(name, bytes);
    return reply;
  }

  insert(name: string, bytes: Uint8Array<ArrayBuffer>): void {
    this.files.set(name, bytes);
    this.tell({ verb: "insert", name, bytes });
  }

  remove(name: string): void {
    this.files.delete(name);
    this.tell({ verb: "remove", name });
  }

  clear(): void {
    for (const name of [...this.files.keys()]) this.remove(name);
  }

  run(job: string, onProgress: OnProgress, onPasses?: OnPasses): Promise<Done> {
    return this.done({ verb: "run", job }, { onProgress, onPasses });
  }

  check(options: string[], onProgress: OnProgress): Promise<Done> {
    return this.done({ verb: "check", options }, { onProgress });
  }

  propose(options: string[], onProgress: OnProgress): Promise<Done> {
    return this.done({ verb: "propose", options }, { onProgress });
  }

  /** Faces of a part turned about x, y and z by angles in degrees, and the part as a picture. */
  async part(name: string, rotation: number[]): Promise<{ part: PartFaces; drawing: Drawing }> {
    const reply = await this.ask({ verb: "part", name, rotation });
    if (reply.kind !== "part") throw new Refused(["the engine gave no faces"]);
    return reply;
  }

  /** Names of the machines that need no file. */
  async machines(): Promise<string[]> {
    const reply = await this.ask({ verb: "machines" });
    return reply.kind === "machines" ? reply.names : [];
  }

  async readJob(job: string): Promise<Answer> {
    return (await this.done({ verb: "readJob", job })).answer;
  }

  /** Moves of a program, with their picture if they are drawn alone. */
  async timeline(options: string[], { isDrawn }: { isDrawn: boolean }): Promise<Moves> {
    const reply = await this.ask({ verb: "timeline", options, isDrawn });
    if (reply.kind !== "moves") throw new Refused(["the engine gave no moves"]);
    return reply.moves;
  }

  /** Chain of a machine file or built-in machine. */
  async machine(name: string): Promise<Machine> {
    const reply = await this.ask({ verb: "machine", name });
    if (reply.kind !== "machine") throw new Refused(["the engine gave no machine"]);
    return reply.machine;
  }

  /** A library that is open; the standard one without a name. */
  async library(name: string | null): Promise<Library> {
    const reply = await this.ask({ verb: "library", name });
    if (reply.kind !== "library") throw new Refused(["the engine gave no library"]);
    return reply.library;
  }

  /** Lines of two texts in one list: those of the first and the second, 0 where one has none. */
  async rows(texts: [Uint8Array<ArrayBuffer>, Uint8Array<ArrayBuffer>]): Promise<Int32Array> {
    const reply = await this.ask({ verb: "rows", texts });
    return reply.kind === "rows" ? reply.rows : new Int32Array();
  }

  /** Prepares the stock of a program to be cut, with rays about `cell` mm apart; null without stock and part. */
  async stock(options: string[], cell: number): Promise<StockInfo | null> {
    const reply = await this.ask({ verb: "stock", options, cell });
    return reply.kind === "stock" ? reply.stock : null;
  }

  /** Cuts the stock towards a time, s. */
  async cut(time: number): Promise<StockCut> {
    const reply = await this.ask({ verb: "cut", time });
    if (reply.kind !== "cut") throw new Refused(["the engine cut nothing"]);
    return reply.cut;
  }

  /** Ends the worker: its memory is free again. */
  end(): void {
    this.lose(["stopped on request"]);
    this.worker.terminate();
  }
}
