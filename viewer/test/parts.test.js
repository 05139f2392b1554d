// Tests of the parts that need no screen: `npm run check`.

import assert from "node:assert/strict";
import test from "node:test";
import { ticks } from "../src/charts.js";
import { colourOf, inTolerances } from "../src/colour.js";
import {
  UNCUT,
  deviationAt,
  endOf,
  floats,
  limitName,
  slotAt,
  toolAt,
  toolTime,
  unpack,
} from "../src/data.js";
import { namePlaces } from "../src/triad.js";
import { coarseTriangles, pathLines, vertexNormals } from "../src/geometry.js";

const base64 = (array) => Buffer.from(array.buffer).toString("base64");

test("a kept tolerance and a broken one differ sharply, on both sides", () => {
  const away = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));
  for (const limit of [-1, 1]) {
    const [inside, outside] = [colourOf(limit), colourOf(limit * 1.001)];
    assert.ok(away(inside, outside) > 100, `${inside} ${outside}`);
    assert.ok(away(inside, colourOf(limit * 0.999)) < 2);
  }
  assert.deepEqual(colourOf(-9), colourOf(-2));
  assert.deepEqual(colourOf(9), colourOf(2));
});

test("each side is measured by its own tolerance", () => {
  const budget = { total: 0.02, gouge: 0.002 };
  assert.equal(inTolerances(-0.002, budget), -1);
  assert.equal(inTolerances(0.01, budget), 0.5);
});

test("the tool lies between its points", () => {
  const points = new Float32Array([
    ...[0, 0, 0, 0, 0, 0, 1, 5, 5, 5],
    ...[2, 4, 0, 0, 0, 1, 0, 7, 5, 5],
    ...[2, 4, 0, 0, 0, 1, 0, 7, 5, 5],
    ...[3, 4, 0, 9, 0, 1, 0, 7, 5, 5],
  ]);
  const pieces = [
    { kind: "cut", start: 0, count: 2, tool: 0 },
    { kind: "link", start: 2, count: 2, tool: 1 },
  ];
  const path = { points, pieces, count: 4 };
  const tool = toolAt(path, 1);
  assert.deepEqual(tool.tip, [2, 0, 0]);
  assert.ok(Math.abs(tool.axis[1] - Math.SQRT1_2) < 1e-9);
  assert.equal(tool.kind, "cut");
  assert.equal(toolAt(path, 2.5).kind, "link");
  assert.deepEqual([toolAt(path, 1).tool, toolAt(path, 2.5).tool], [0, 1]);
  assert.equal(endOf(path), 3);
  assert.deepEqual(toolAt(path, 99).tip, [4, 0, 9]);
  assert.equal(toolAt({ points, pieces: [], count: 0 }, 1), null);
});

test("a place is where the point is deepest in the tool, whichever tool that is", () => {
  // Upright at x = 0, 10, 20; the holder of the second tool, above 30, is wide.
  const points = new Float32Array([0, 10, 20].flatMap((x, t) => [t, x, 0, 0, 0, 0, 1, x, 0, 0]));
  const pieces = [{ kind: "cut", start: 0, count: 2, tool: 0 }, { kind: "link", start: 2, count: 1, tool: 1 }];
  const slim = [[0, 0], [2, 0], [2, 60]];
  const tools = [slim, [[0, 0], [2, 0], [2, 30], [15, 30], [15, 60]]];
  const path = { points, pieces, count: 3 };
  assert.equal(toolTime(path, tools, [11, 0, 5]), 1);
  assert.equal(toolTime(path, tools, [9, 0, 40]), 2);
  assert.equal(toolTime(path, tools, [14, 0, 40]), 2);
  assert.equal(toolTime(path, [slim, slim], [14, 0, 40]), 1);
});

test("packed data come out as they went in", () => {
  const empty = { min: "", max: "" };
  const data = unpack({
    surface: {
      low: [0, 0, 0],
      high: [10, 20, 0],
      positions: base64(new Uint16Array([0, 65535, 0, 65535, 0, 0])),
      step: 0.001,
      deviation: base64(new Int16Array([-7, UNCUT])),
      triangles: "",
      measured: 2,
    },
    path: { kinds: [], counts: [], tools: [], contacts: false, points: "" },
    fixtures: { positions: base64(new Float32Array([1, 2, 3])), triangles: base64(new Uint32Array([0, 0, 0])) },
    motion: { duration: 4, axes: [], slots: 8, bands: [], speed: empty, tip: empty, binding: "" },
  });
  assert.deepEqual([...data.surface.positions], [0, 20, 0, 10, 0, 0]);
  assert.equal(deviationAt(data.surface, 0), -0.007);
  assert.equal(deviationAt(data.surface, 1), null);
  assert.equal(deviationAt(data.surface, 2), undefined);
  assert.deepEqual([[...data.fixtures.positions], data.fixtures.triangles.length], [[1, 2, 3], 3]);
  assert.equal(slotAt(data.motion, 3.99), 7);
  assert.equal(slotAt(data.motion, 9), 7);
  assert.deepEqual([...floats(base64(new Float32Array([1.5])))], [1.5]);
});

test("limits have names", () => {
  const axes = [{ name: "X" }, { name: "C" }];
  const names = [0, 1, 2, 6, 7].map((binding) => limitName(axes, binding));
  assert.deepEqual(names, ["nothing", "feed", "X velocity", "C acceleration", "C jerk"]);
  assert.equal(limitName([{ name: "X", chord: true }], 3), "X chord error");
});

test("ticks are round and within", () => {
  assert.deepEqual(ticks(0, 42, 5), [0, 10, 20, 30, 40]);
  assert.deepEqual(ticks(-1, 1, 4), [-1, -0.5, 0, 0.5, 1]);
  assert.deepEqual(ticks(3, 3, 4), [3]);
});

test("lines join the points of a piece, and no two pieces", () => {
  const point = (x) => [0, x, 0, 0, 0, 0, 1, x, 5, 0];
  const points = new Float32Array([0, 1, 2, 8, 9, 20, 21].flatMap(point));
  const count = 7;
  const pieces = [
    { kind: "cut", start: 0, count: 3 },
    { kind: "link", start: 3, count: 2 },
    { kind: "cut", start: 5, count: 2 },
  ];
  const tips = pathLines({ pieces, points, count }, { kinds: ["cut"], first: 1 });
  // The point between two others of a line is left out.
  assert.deepEqual([...tips].filter((_, at) => at % 3 === 0), [0, 2, 20, 21]);
  const contacts = pathLines({ pieces, points, count }, { kinds: ["cut"], first: 7 });
  assert.equal(contacts[1], 5);
});

test("drawn lines stay near the path, and have fewer points", () => {
  const count = 20_001;
  const points = new Float32Array(10 * count);
  for (let at = 0; at < count; at += 1) {
    const angle = (at / (count - 1)) * Math.PI;
    points.set([100 * Math.cos(angle), 100 * Math.sin(angle), 0], 10 * at + 1);
  }
  const pieces = [{ kind: "cut", start: 0, count }];
  const lines = pathLines({ pieces, points, count }, { kinds: ["cut"], first: 1 });
  const ends = Array.from({ length: lines.length / 3 }, (_, at) => [...lines.subarray(3 * at, 3 * at + 2)]);
  assert.ok(ends.length < count / 10, `${ends.length} ends`);
  // The middle of a chord is farthest from the arc; the diagonal is 224 mm.
  for (let at = 0; at < ends.length; at += 2) {
    const middle = Math.hypot((ends[at][0] + ends[at + 1][0]) / 2, (ends[at][1] + ends[at + 1][1]) / 2);
    assert.ok(100 - middle <= 2e-5 * 224 + 1e-4, `${100 - middle} mm`);
    if (at > 0) assert.deepEqual(ends[at], ends[at - 1]);
  }
  assert.ok(Math.abs(ends.at(-1)[0] + 100) < 1e-4);
});

test("normals are those of the triangles, larger ones first", () => {
  const positions = new Float32Array([0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 1]);
  const normals = vertexNormals({ positions, triangles: new Uint32Array([0, 1, 2, 0, 2, 3]) });
  assert.deepEqual([...normals.subarray(3, 6)], [0, 0, 1]);
  assert.ok(Math.abs(normals[0] / normals[2] - 0.5) < 1e-6, `${normals.subarray(0, 3)}`);
});

test("a surface of many triangles has few that lie near it, and one of few has none", () => {
  const across = 200;
  const corners = Array.from({ length: (across + 1) ** 2 }, (_, at) => {
    const [x, y] = [(at % (across + 1)) / across, Math.floor(at / (across + 1)) / across];
    return [x, y, x * y];
  });
  const square = (at) => [at, at + 1, at + across + 2, at, at + across + 2, at + across + 1];
  const cells = Array.from({ length: across ** 2 }, (_, at) => (across + 1) * Math.floor(at / across) + (at % across));
  const surface = { positions: new Float32Array(corners.flat()), triangles: new Uint32Array(cells.flatMap(square)), low: [0, 0, 0], high: [1, 1, 1] };
  const few = coarseTriangles(surface);
  assert.ok(few.length / 3 <= 8000 && few.length / 3 > 500, `${few.length / 3} triangles`);
  // They cover the square once, seen from above.
  let area = 0;
  for (let at = 0; at < few.length; at += 3) {
    const [a, b, c] = [...few.subarray(at, at + 3)].map((vertex) => corners[vertex]);
    area += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]));
  }
  assert.ok(Math.abs(area - 1) < 0.08, `area ${area}`);
  assert.equal(coarseTriangles({ ...surface, triangles: surface.triangles.subarray(0, 300) }), null);
});

test("names of axes keep apart however they are seen", () => {
  for (let turn = 0; turn < 60; turn += 1) {
    for (let tilt = -15; tilt <= 15; tilt += 1) {
      const [a, b] = [(Math.PI * turn) / 30, (Math.PI * tilt) / 30];
      const arms = [
        [Math.cos(a), -Math.sin(a) * Math.sin(b)],
        [Math.sin(a), Math.cos(a) * Math.sin(b)],
        [0, Math.cos(b)],
      ];
      const places = namePlaces(arms);
      for (const [k, other] of [[0, 1], [1, 2], [2, 0]]) {
        const away = Math.hypot(places[k][0] - places[other][0], places[k][1] - places[other][1]);
        assert.ok(away >= 14 - 1e-9, `${k} and ${other} are ${away} apart at ${turn}, ${tilt}`);
      }
      assert.ok(places.flat().every((x) => Math.abs(x) < 48 - 6), `a name is cut off: ${places}`);
    }
  }
});
