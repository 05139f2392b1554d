// Results of a run or check: the data of its report page, and its summary.

import { STRIDE, unpack } from "../../viewer/src/data.js";
import { prepared } from "../../viewer/src/geometry.js";
import type { Outputs, PartFaces } from "./messages";
import type { Timeline } from "./timeline";

export interface Place {
  kind: string;
  point: number[];
  deviation: number | null;
  note: string;
}

/** Arrays that the view would otherwise compute while it opens. */
export interface DrawnArrays {
  places: Float32Array;
  normals: Float32Array;
  lines: Record<string, Float32Array>;
  coarse: Uint32Array | null;
  sphere: { centre: number[]; radius: number } | null;
}

/** Part, path, tools and places as the report draws them. */
export interface Drawing {
  budget: { total: number; gouge: number };
  surface: { low: number[]; high: number[]; positions: Float32Array; deviation: Int16Array; count: number };
  path: { points: Float32Array; pieces: { kind: string; start: number; count: number; tool: number }[]; count: number; contacts: boolean };
  tools: number[][][];
  fixtures: object | null;
  check: { method: string; places: Place[] };
  prepared?: DrawnArrays;
}

export interface Summary {
  passed: boolean;
  failures: string[];
  warnings: string[];
}

const OPENING = '<script type="application/json" id="data">';

export const textOf = (bytes: Uint8Array): string => new TextDecoder().decode(bytes);

/** Data that a report page carries; null for a page without a picture. */
export function drawingOf(page: Uint8Array): Drawing | null {
  const text = textOf(page);
  const start = text.indexOf(OPENING);
  const end = text.indexOf("</script>", start);
  return start < 0 ? null : (unpack(JSON.parse(text.slice(start + OPENING.length, end))) as Drawing);
}

/** Drawing with the arrays of its view. */
export const withArrays = (drawing: Drawing): Drawing => ({ ...drawing, prepared: prepared(drawing) as DrawnArrays });

/** Lines of a program. */
export const linesOf = (text: string): string[] => text.replace(/\r?\n$/, "").split(/\r?\n/);

export function summaryOf(outputs: Outputs): Summary | null {
  const name = [...outputs.keys()].find((name) => name.endsWith("/summary.json"));
  const bytes = name && outputs.get(name);
  return bytes ? (JSON.parse(textOf(bytes)) as Summary) : null;
}

/** Drawing of a program that was not measured yet: its moves alone. */
export function movesOf(timeline: Timeline): Drawing {
  const { times, poses, kinds } = timeline.moves;
  const points = new Float32Array(STRIDE * timeline.count);
  const pieces: Drawing["path"]["pieces"] = [];
  for (let at = 0; at < timeline.count; at += 1) {
    const p = 6 * at;
    const to = STRIDE * at;
    points[to] = times[at]!;
    for (let k = 0; k < 6; k += 1) points[to + 1 + k] = poses[p + k]!;
    for (let k = 0; k < 3; k += 1) points[to + 7 + k] = poses[p + k]!;
    const kind = (kinds[at]! & 1) === 1 ? "link" : "cut";
    const last = pieces.at(-1);
    const isApart = (kinds[at]! & 2) !== 0;
    if (last && !isApart && last.kind === kind && last.tool === kinds[at]! >> 2) {
      last.count += 1;
    } else {
      pieces.push({ kind, start: at, count: 1, tool: kinds[at]! >> 2 });
    }
  }
  return {
    budget: { total: 0, gouge: 0 },
    surface: { low: [0, 0, 0], high: [0, 0, 0], positions: new Float32Array(), deviation: new Int16Array(), count: 0, ...{ triangles: new Uint32Array(), step: 0, measured: 0 } },
    path: { points, pieces, count: timeline.count, contacts: false },
    tools: timeline.moves.tools,
    fixtures: null,
    check: { method: "", places: [] },
  };
}

/** A part that nothing was measured on yet, as the stage draws it. */
export function drawingOfPart({ positions, triangles }: PartFaces): Drawing {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < positions.length; at += 1) {
    low[at % 3] = Math.min(low[at % 3]!, positions[at]!);
    high[at % 3] = Math.max(high[at % 3]!, positions[at]!);
  }
  const count = positions.length / 3;
  // Past the last measured vertex there is no deviation.
  const surface = { low, high, positions, triangles, deviation: new Int16Array(), step: 0, measured: 0, count };
  const path = { points: new Float32Array(), pieces: [], count: 0, contacts: false };
  // One tool without an outline: nothing is drawn of it.
  return { budget: { total: 0, gouge: 0 }, surface, path, tools: [[]], fixtures: null, check: { method: "", places: [] } };
}
