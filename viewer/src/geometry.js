// Arrays of the 3-D view from the data of a result. No screen is needed: a worker can make them.

import { REACH, inTolerances } from "./colour.js";
import { STRIDE, deviationAt } from "./data.js";

/** Kinds of path lines: which pieces, which point of them, colour by theme. */
export const LINES = [
  { key: "contact", kinds: ["cut"], first: 7, light: "#10243a", dark: "#0b1826" },
  { key: "tip", kinds: ["cut"], first: 1, light: "#7a4fbf", dark: "#c3a6ff" },
  { key: "leads", kinds: ["leadin", "leadout"], first: 1, light: "#1b8a4b", dark: "#59d68f" },
  { key: "links", kinds: ["link"], first: 1, light: "#b06a00", dark: "#ffb84d" },
];

/** Rows of the colour table: 0 is the scale, 1 uncut, 2 not measured. */
export const ROWS = 4;

/** Place of every vertex in the colour table. */
function colourPlaces({ surface, budget }) {
  const places = new Float32Array(2 * surface.count);
  for (let vertex = 0; vertex < surface.count; vertex += 1) {
    const deviation = deviationAt(surface, vertex);
    const row = deviation === undefined ? 2 : deviation === null ? 1 : 0;
    const value = row === 0 ? inTolerances(deviation, budget) : 0;
    const clamped = Math.min(Math.max(value, -REACH), REACH);
    places[2 * vertex] = 0.5 + (0.499 * clamped) / REACH;
    places[2 * vertex + 1] = (row + 0.5) / ROWS;
  }
  return places;
}

/** Normal of every vertex: the mean of its triangles, by area. */
export function vertexNormals({ positions, triangles }) {
  const normals = new Float32Array(positions.length);
  for (let at = 0; at < triangles.length; at += 3) {
    const [a, b, c] = [3 * triangles[at], 3 * triangles[at + 1], 3 * triangles[at + 2]];
    const [ux, uy, uz] = [positions[c] - positions[b], positions[c + 1] - positions[b + 1], positions[c + 2] - positions[b + 2]];
    const [vx, vy, vz] = [positions[a] - positions[b], positions[a + 1] - positions[b + 1], positions[a + 2] - positions[b + 2]];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const corner of [a, b, c]) {
      normals[corner] += x;
      normals[corner + 1] += y;
      normals[corner + 2] += z;
    }
  }
  for (let at = 0; at < normals.length; at += 3) {
    const size = Math.sqrt(normals[at] ** 2 + normals[at + 1] ** 2 + normals[at + 2] ** 2) || 1;
    normals[at] /= size;
    normals[at + 1] /= size;
    normals[at + 2] /= size;
  }
  return normals;
}

/** Triangles that are drawn at once on any graphics. */
const MANY = 24_000;
/** Most of the few triangles that stand for them. */
const FEW = 8000;
/** Cells along the diagonal of the box around a surface, the finest first: each becomes one vertex. */
const CELLS = [112, 80, 56, 40, 28, 20];

/** Few triangles for a surface of many, between vertices of it; null where it has few. */
export function coarseTriangles(surface) {
  if (surface.triangles.length / 3 <= MANY) return null;
  let few = null;
  for (const cells of CELLS) {
    few = clustered(surface, cells);
    if (few.length / 3 <= FEW) break;
  }
  return few;
}

/** Triangles between vertices that each stand for all of a cell. */
function clustered({ positions, triangles, low, high }, cells) {
  const step = Math.hypot(...low.map((x, k) => high[k] - x)) / cells;
  const across = cells + 2;
  const known = new Int32Array(across ** 3).fill(-1);
  const cell = (vertex, k) => Math.min(Math.max(Math.floor((positions[3 * vertex + k] - low[k]) / step), 0), cells + 1);
  const standing = new Uint32Array(positions.length / 3);
  for (let vertex = 0; vertex < standing.length; vertex += 1) {
    const key = (cell(vertex, 2) * across + cell(vertex, 1)) * across + cell(vertex, 0);
    if (known[key] < 0) known[key] = vertex;
    standing[vertex] = known[key];
  }
  const few = new Uint32Array(triangles.length);
  let count = 0;
  for (let at = 0; at < triangles.length; at += 3) {
    const [a, b, c] = [standing[triangles[at]], standing[triangles[at + 1]], standing[triangles[at + 2]]];
    if (a === b || b === c || c === a) continue;
    few[count] = a;
    few[count + 1] = b;
    few[count + 2] = c;
    count += 3;
  }
  return few.slice(0, count);
}

/** Distance of drawn lines from the path, in diagonals of the box around it: far below a pixel of the whole. */
const CHORD = 2e-5;
/** Most points that one drawn line stands for: each new point is compared with all of them. */
const MOST = 64;

/** Ends of all lines of a kind. Points that lie on the line between others are left out: a long program has many. */
export function pathLines({ pieces, points, count }, { kinds, first }) {
  const drawn = pieces.filter(({ kind }) => kinds.includes(kind));
  const chord = (CHORD * diagonal(points, count, first)) ** 2;
  const corners = [];
  const put = (at) => {
    const from = STRIDE * at + first;
    corners.push(points[from], points[from + 1], points[from + 2]);
  };
  for (const { start, count: length } of drawn) {
    let anchor = start;
    for (let at = start + 1; at < start + length; at += 1) {
      const isLast = at + 1 === start + length;
      if (!isLast && at + 1 - anchor <= MOST && isStraight(points, first, [anchor, at + 1], chord)) continue;
      put(anchor);
      put(at);
      anchor = at;
    }
  }
  return new Float32Array(corners);
}

function diagonal(points, count, first) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < count; at += 1) {
    for (let k = 0; k < 3; k += 1) {
      const value = points[STRIDE * at + first + k];
      if (value < low[k]) low[k] = value;
      if (value > high[k]) high[k] = value;
    }
  }
  return count > 0 ? Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) : 0;
}

/** True if all points between two are within a distance, squared, of the line that joins them. */
function isStraight(points, first, [from, to], chord) {
  const a = STRIDE * from + first;
  const b = STRIDE * to + first;
  const [dx, dy, dz] = [points[b] - points[a], points[b + 1] - points[a + 1], points[b + 2] - points[a + 2]];
  const size = dx * dx + dy * dy + dz * dz;
  for (let at = from + 1; at < to; at += 1) {
    const p = STRIDE * at + first;
    const [x, y, z] = [points[p] - points[a], points[p + 1] - points[a + 1], points[p + 2] - points[a + 2]];
    const share = size > 0 ? Math.min(Math.max((x * dx + y * dy + z * dz) / size, 0), 1) : 0;
    if ((x - share * dx) ** 2 + (y - share * dy) ** 2 + (z - share * dz) ** 2 > chord) return false;
  }
  return true;
}

/** Sphere around points, from the centre of their box; null without points. */
export function sphereAround(points) {
  if (points.length === 0) return null;
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < points.length; at += 1) {
    low[at % 3] = Math.min(low[at % 3], points[at]);
    high[at % 3] = Math.max(high[at % 3], points[at]);
  }
  const centre = low.map((x, k) => 0.5 * (x + high[k]));
  let radius = 0;
  for (let at = 0; at < points.length; at += 3) {
    radius = Math.max(radius, Math.hypot(points[at] - centre[0], points[at + 1] - centre[1], points[at + 2] - centre[2]));
  }
  return { centre, radius };
}

/** Everything that a view would otherwise compute while it opens. */
export function prepared(data) {
  const lines = Object.fromEntries(LINES.map((line) => [line.key, pathLines(data.path, line)]));
  return {
    places: colourPlaces(data),
    normals: vertexNormals(data.surface),
    coarse: coarseTriangles(data.surface),
    lines,
    sphere: sphereAround(lines.tip),
  };
}
