// Results of a run or check: the data of its report page, and its summary.

import { STRIDE, unpack } from "../../viewer/src/data.js";
import type { Outputs } from "./messages";
import type { Timeline } from "./timeline";

export interface Place {
  kind: string;
  point: number[];
  deviation: number | null;
  note: string;
}

/** Part, path, tools and places as the report draws them. */
export interface Drawing {
  budget: { total: number; gouge: number };
  surface: { low: number[]; high: number[]; positions: Float32Array; deviation: Int16Array; count: number };
  path: { points: Float32Array; pieces: { kind: string; start: number; count: number; tool: number }[]; count: number; contacts: boolean };
  tools: number[][][];
  fixtures: object | null;
  check: { method: string; places: Place[] };
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
    points.set([times[at]!, ...poses.subarray(p, p + 6), ...poses.subarray(p, p + 3)], STRIDE * at);
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
