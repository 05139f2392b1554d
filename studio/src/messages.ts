// What page and worker say to each other.

import type { Drawing } from "./report";

/** Result of a verb, in the words of the command line. */
export interface Answer {
  /** Exit code: 0 kept, 1 broken, 2 bad input, 3 internal, 130 stopped. */
  code: number;
  messages: string[];
  warnings: string[];
  table: string;
  files: string[];
}

export interface Link {
  name: string;
  axis: number;
  rotary: boolean;
  direction: Triple;
  point: Triple;
  travel: [number, number] | null;
  velocity: [number, number];
}

export type Triple = [number, number, number];

/** Chain of a machine with a workpiece on it; machine coordinates, all axes at zero. */
export interface Machine {
  name: string;
  workpiece_side: Link[];
  tool_side: Link[];
  tool_axis: Triple;
  gauge: Triple;
  origin: Triple;
  rotation: [Triple, Triple, Triple];
}

/** Moves of a program: arrays with one entry a point, five axes, or six numbers of a pose. */
export interface Replay {
  times: Float64Array;
  lines: Uint32Array;
  kinds: Uint32Array;
  axes: Float64Array;
  poses: Float32Array;
  machine: Machine | null;
  tools: [number, number][][];
  /** True if there is stock, or a part whose box stands for it. */
  has_stock: boolean;
}

/** Pieces of the surface of stock, one brick after the other. */
export interface Bricks {
  /** Number, vertices and triangles of each brick. */
  counts: Uint32Array;
  /** Vertices, mm. */
  positions: Float32Array;
  /** Triangles; every brick counts its own vertices. */
  triangles: Uint32Array;
}

/** Stock at a time, with the bricks that have changed since the last one. */
export interface StockCut {
  time: number;
  /** False if the time that was asked for is still to come. */
  isThere: boolean;
  bricks: Bricks;
}

/** Stock that is drawn as it is cut. */
export interface StockInfo {
  /** Largest distance of its rays, mm. */
  cell: number;
  /** False if the box of the part stands for it. */
  is_stated: boolean;
}

/** Moves of a program with what is drawn of them. */
export interface Moves {
  replay: Replay;
  /** What the charts draw; null without axes. */
  motion: object | null;
  /** The moves as a picture; null where a measured part is drawn. */
  drawing: Drawing | null;
}

/** Cutters, holders and machines that a job may choose. */
export interface Library {
  name: string;
  /** Keys of a tool with their values as TOML. */
  cutters: { name: string; keys: [string, string][] }[];
  /** Pairs of height above the lower end and radius; the upper end is at the gauge point. */
  holders: { name: string; profile: [number, number][] }[];
  machines: { name: string; file: string }[];
}

/** Face of a part; `triangles` are the first of its triangles and their number. */
export interface FaceInfo {
  number: number;
  kind: string;
  area: number;
  concave_radius: number | null;
  triangles: [number, number];
}

/** Faces of a part as triangles and edges, mm. */
export interface PartFaces {
  faces: FaceInfo[];
  warnings: string[];
  positions: Float32Array;
  triangles: Uint32Array;
  edges: Float32Array;
}

export type Request = { id: number } & (
  | { verb: "insert"; name: string; bytes: Uint8Array<ArrayBuffer> }
  | { verb: "remove"; name: string }
  | { verb: "run"; job: string }
  | { verb: "readJob"; job: string }
  | { verb: "check"; options: string[] }
  | { verb: "propose"; options: string[] }
  | { verb: "part"; name: string; rotation: number[] }
  | { verb: "machines" }
  | { verb: "machine"; name: string }
  | { verb: "library"; name: string | null }
  | { verb: "rows"; texts: [Uint8Array<ArrayBuffer>, Uint8Array<ArrayBuffer>] }
  | { verb: "timeline"; options: string[]; isDrawn: boolean }
  | { verb: "stock"; options: string[]; cell: number }
  | { verb: "cut"; time: number }
);

export type Outputs = Map<string, Uint8Array<ArrayBuffer>>;

export type Reply = { id: number } & (
  | { kind: "progress"; stage: string; done: number; total: number }
  | { kind: "passes"; count: number; faces: Map<number, Float32Array<ArrayBuffer>> }
  | { kind: "answer"; answer: Answer; outputs: Outputs; drawing: Drawing | null }
  | { kind: "moves"; moves: Moves }
  | { kind: "part"; part: PartFaces; drawing: Drawing }
  | { kind: "machines"; names: string[] }
  | { kind: "machine"; machine: Machine }
  | { kind: "library"; library: Library }
  | { kind: "rows"; rows: Int32Array }
  | { kind: "stock"; stock: StockInfo | null }
  | { kind: "cut"; cut: StockCut }
  | { kind: "failure"; messages: string[]; isLost: boolean }
);
