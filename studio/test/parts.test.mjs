// Parts of the page that need no screen.

import assert from "node:assert/strict";
import { after, test } from "node:test";
import { Box2, Vector2 } from "three";
import { createServer } from "vite";

const root = new URL("..", import.meta.url).pathname;
const vite = await createServer({ root, configFile: `${root}vite.config.ts`, appType: "custom", logLevel: "error", server: { middlewareMode: true, ws: false, watch: null } });
after(() => vite.close());
const { rowsOf, sharedLines } = await vite.ssrLoadModule("/src/linediff.ts");
const { facesOf, toolSection, valueOf, withFaces, withHolder, withTool, withValue } = await vite.ssrLoadModule("/src/jobtext.ts");
const { Lines } = await vite.ssrLoadModule("/src/lines.ts");
const { linesOf } = await vite.ssrLoadModule("/src/report.ts");
const { Timeline } = await vite.ssrLoadModule("/src/timeline.ts");
const { PlacedPasses } = await vite.ssrLoadModule("/src/placed.ts");
const { comparePaths, timeThere } = await vite.ssrLoadModule("/src/compare.ts");
const { StockFollower, StockSurface, bricksOf } = await vite.ssrLoadModule("/src/stock.ts");
const { Tiles, patchesOf } = await vite.ssrLoadModule("/src/renewed.ts");
const { kindOf, refusalOf, warningOf, words } = await vite.ssrLoadModule("/src/files.ts");

/** Pairs of lines that are shared, counted from 1. */
const pairs = (a, b) => [...sharedLines(a, b)].flatMap((other, at) => (other < 0 ? [] : [[at + 1, other + 1]]));

test("shared lines are the longest list in order", () => {
  assert.deepEqual(pairs([..."abcde"], [..."abxde"]), [[1, 1], [2, 2], [4, 4], [5, 5]]);
  // A block that was moved is shared once: order counts.
  assert.equal(pairs([..."abcdef"], [..."defabc"]).length, 3);
  // No line is there once on both sides.
  assert.deepEqual(pairs([..."xaxbx"], [..."yaabby"]).length, 2);
  assert.deepEqual(pairs([], ["a"]), []);
});

test("shared lines have the same text and rise, and every line has a row", () => {
  let state = 7;
  const random = (below) => (state = (state * 48271) % 2147483647) % below;
  for (let trial = 0; trial < 200; trial += 1) {
    const [a, b] = [random(12), random(12)].map((size) => Array.from({ length: size }, () => "abcd"[random(4)]));
    const found = pairs(a, b);
    for (const [line, other] of found) assert.equal(a[line - 1], b[other - 1]);
    for (let at = 1; at < found.length; at += 1) assert.ok(found[at][0] > found[at - 1][0] && found[at][1] > found[at - 1][1]);
    // Rows have every line of both, in order.
    const rows = rowsOf(sharedLines(a, b), b.length);
    const column = (k) => [...rows].filter((line, at) => at % 2 === k && line > 0);
    assert.deepEqual(column(0), a.map((_, at) => at + 1));
    assert.deepEqual(column(1), b.map((_, at) => at + 1));
  }
});

test("rows of changed lines stand in turns", () => {
  assert.deepEqual([...rowsOf(sharedLines([..."aXYb"], [..."aZb"]), 3)], [1, 1, 2, 0, 0, 2, 3, 0, 4, 3]);
});

const JOB = `schema = "trunnion-job/1"

[tool]
number = 1
kind = "bull"
diameter = 16  # wide
corner_radius = 2
length = 100
holder = [[60, 12], [100, 20]]

[tolerance]
total = 0.02
`;

test("a value is written in its place, and nothing else changes", () => {
  assert.equal(withValue(JOB, "tolerance", "total", "0.05"), JOB.replace("0.02", "0.05"));
  assert.equal(withValue(JOB, "tolerance", "gouge", "0.01"), JOB.replace("[tolerance]\n", "[tolerance]\ngouge = 0.01\n"));
  assert.equal(withValue(JOB, "setup", "origin", "[0, 0, 1]"), `${JOB}\n[setup]\norigin = [0, 0, 1]\n`);
});

test("another tool brings its keys, and takes the others with the holder away", () => {
  const text = withTool(JOB, [["number", "4"], ["kind", '"ball"'], ["diameter", "6"], ["length", "80"]]);
  assert.equal(text, JOB.replace("number = 1", "number = 4").replace("bull", "ball").replace("16 ", "6 ").replace("corner_radius = 2\n", "").replace("100\nholder = [[60, 12], [100, 20]]", "80"));
});

test("a holder ends at the gauge point", () => {
  assert.equal(valueOf(withHolder(JOB, [[0, 8], [30, 13], [50, 14]]), "tool", "holder"), "[[50, 8], [80, 13], [100, 14]]");
  assert.equal(valueOf(withHolder(JOB, null), "tool", "holder"), null);
});

test("faces go out of their operations, and new ones into the first", () => {
  const operations = "[[operation]]\nfaces = [1, 2]\n[operation.tool]\nlength = 60\n\n[[operation]]\nfaces = [3]\n";
  const text = `[part]\nfaces = [1, 2, 3]\n\n${operations}`;
  assert.equal(withFaces(text, [2, 4]), `[part]\nfaces = [2, 4]\n\n${operations.replace("[1, 2]", "[2, 4]").replace("[3]", "[]")}`);
  assert.deepEqual(facesOf(text), [1, 2, 3]);
  assert.equal(facesOf('[part]\nfaces = "all"\n'), null);
  assert.equal(toolSection(text), "operation.tool");
});

/** Cuts of 10 mm in 1 s, a rapid move of 5 mm in 1 s, and another cut of 10 mm in 2 s; all along x. */
const moves = ([first, second, third]) =>
  new Timeline({
    times: new Float64Array([0, first, first + second, first + second + third]),
    lines: new Uint32Array([1, 2, 3, 4]),
    kinds: new Uint32Array([0, 0, 1, 0]),
    axes: new Float64Array(),
    poses: new Float32Array([0, 10, 15, 25].flatMap((x) => [x, 0, 0, 0, 0, 1])),
    machine: null,
    tools: [[]],
  });

test("lengths, and the share of the path that is cut", () => {
  const timeline = moves([1, 1, 2]);
  assert.deepEqual(timeline.lengths(), [20, 5]);
  assert.equal(timeline.countCuts(), 2);
  assert.deepEqual([0.5, 1, 1.5, 3].map((t) => timeline.cutAt(t)), [0.25, 0.5, 0.5, 0.75]);
  // A rapid move cuts nothing: the first time with that share is its start.
  assert.deepEqual([0.25, 0.5, 0.75, 1].map((share) => timeline.timeAtCut(share)), [0.5, 1, 3, 4]);
});

test("the second program is where the first one is", () => {
  const [first, second] = [moves([1, 1, 2]), moves([2, 2, 4])];
  assert.equal(timeThere(3, first, second, "path"), 6);
  assert.equal(timeThere(3, first, second, "share"), 6);
  assert.equal(timeThere(3, first, second, "time"), 3);
  assert.equal(timeThere(7, second, first, "time"), 4);
});

test("paths are compared move by move", () => {
  const along = (places) =>
    new Timeline({
      times: Float64Array.from(places, (_, at) => at),
      lines: Uint32Array.from(places, (_, at) => at + 1),
      kinds: new Uint32Array(places.length),
      axes: new Float64Array(),
      poses: new Float32Array(places.flatMap((x) => [x, 0, 0, 0, 0, 1])),
      machine: null,
      tools: [[]],
    });
  const rows = Int32Array.from([1, 1, 2, 2, 3, 3, 4, 4, 5, 0]);
  // The same line that ends or begins elsewhere is another move.
  const { shared, first, second } = comparePaths(along([0, 1, 2, 3, 4]), along([0, 1, 2.5, 3]), rows);
  const ends = (lines) => [...lines].filter((_, at) => at % 3 === 0);
  assert.deepEqual(ends(shared), [0, 1]);
  assert.deepEqual(ends(first), [1, 2, 2, 3, 3, 4]);
  assert.deepEqual(ends(second), [1, 2.5, 2.5, 3]);
});

test("kinds of files, options, and sizes that are said before", () => {
  const of = (text) => kindOf("a.toml", new TextEncoder().encode(text));
  assert.deepEqual([of('schema = "trunnion-library/1"'), of('schema = "trunnion-machine/1"'), of('schema = "trunnion-job/1"')], ["library", "machine", "job"]);
  assert.deepEqual(words('--job "a b.toml"  --grid 1'), ["--job", "a b.toml", "--grid", "1"]);
  assert.equal(refusalOf("a.ngc", 2 ** 30), null);
  assert.match(refusalOf("a.ngc", 2 ** 30 + 1), /^a\.ngc: has 1073741825 bytes; at most 1073741824 are read$/);
  assert.equal(warningOf("a.ngc", 1e6), null);
  assert.match(warningOf("a.ngc", 9e8), /use the command line/);
});

test("passes that stay are kept, and faces that change are drawn anew", () => {
  const placed = new PlacedPasses();
  const line = (...x) => Float32Array.from(x.flatMap((x) => [x, 0, 1]));
  placed.take(3, 0, line(1, 2, 3, 7, 8), Uint32Array.of(3, 2));
  placed.take(5, 0, line(4, 5), Uint32Array.of(2));
  assert.equal(placed.count, 3);
  const first = placed.changes();
  assert.deepEqual([...first.keys()], [3, 5]);
  assert.deepEqual([...first.get(3)], [...line(1, 2, 2, 3, 7, 8)]);
  assert.deepEqual([...placed.changes()], []);
  // The second pass gives way to another, and a third comes.
  placed.take(3, 1, line(9, 10, 11, 12), Uint32Array.of(2, 2));
  assert.equal(placed.count, 4);
  assert.deepEqual([...placed.changes().get(3)], [...line(1, 2, 2, 3, 9, 10, 11, 12)]);
  // A face that starts anew.
  placed.take(3, 0, new Float32Array(), new Uint32Array());
  assert.deepEqual([...placed.changes().get(3)], []);
  assert.equal(placed.count, 1);
});

test("lines of bytes are those of the text", () => {
  for (const text of ["", "a", "a\n", "a\r\nb", "a\r\n\r\nb\r\n", "\n", "\n\n", "\r\n", "ä°\nµ\n\n", "\ra\r\n"]) {
    const lines = new Lines(new TextEncoder().encode(text));
    const found = Array.from({ length: lines.count }, (_, line) => lines.at(line));
    assert.deepEqual(found, linesOf(text), JSON.stringify(text));
  }
});

/** Changes of bricks: number, and how many triangles fan out from its first corner. */
const changes = (...bricks) => {
  const corner = (number, at) => [number, at, at * at];
  const positions = bricks.flatMap(([number, fans]) => (fans === 0 ? [] : Array.from({ length: fans + 2 }, (_, at) => corner(number, at)).flat()));
  const triangles = bricks.flatMap(([, fans]) => Array.from({ length: fans }, (_, at) => [0, at + 1, at + 2]).flat());
  const counts = bricks.flatMap(([number, fans]) => [number, fans === 0 ? 0 : fans + 2, fans]);
  return { counts: Uint32Array.from(counts), positions: Float32Array.from(positions), triangles: Uint32Array.from(triangles) };
};

test("bricks of stock take the place of those with their number", () => {
  const surface = new StockSurface(0.5);
  const take = (of) => [...bricksOf(of)].forEach((brick) => surface.take(brick));
  take(changes([7, 1], [3, 4], [5, 2]));
  assert.equal(surface.count, 3);
  take(changes([3, 1], [5, 0], [9, 0]));
  assert.equal(surface.count, 2);
  const counts = surface.group.children.map(({ geometry }) => geometry.index.count / 3);
  assert.deepEqual(counts, [1, 1]);
});

test("patches of a surface have its triangles, each within its bounds", () => {
  const positions = Array.from({ length: 400 }, (_, at) => [at % 20, Math.floor(at / 20), (at % 7) / 7]).flat();
  const triangles = Array.from({ length: 379 }, (_, at) => [at, at + 1, at + 20]).flat();
  const patches = patchesOf(triangles, positions);
  assert.ok(patches.length > 20);
  const triples = (list) => list.flatMap((_, at) => (at % 3 === 0 ? [list.slice(at, at + 3).join()] : []));
  assert.deepEqual(patches.flatMap((patch) => triples([...patch.triangles])).sort(), triples(triangles).sort());
  for (const { triangles: own, bounds } of patches) {
    for (const vertex of own) assert.ok([0, 1, 2].every((k) => bounds.min.getComponent(k) <= positions[3 * vertex + k] && positions[3 * vertex + k] <= bounds.max.getComponent(k)));
  }
});

test("tiles of a picture that are marked are taken once, and those beside each other together", () => {
  const box = (...ends) => new Box2(new Vector2(ends[0], ends[1]), new Vector2(ends[2], ends[3]));
  const tiles = new Tiles();
  const marked = [box(10, 10, 300, 20), box(70, 60, 71, 200), box(500, 130, 510, 140), box(640, 0, 704, 64), box(5, 5, 4, 9)];
  for (const one of marked) tiles.mark(one);
  const taken = [...tiles.takeAll()];
  assert.ok(tiles.isEmpty && tiles.take(1) === null);
  const area = ({ min, max }) => (max.x - min.x) * (max.y - min.y);
  // Five in a row, three more below the second, and two alone; the last box is empty.
  assert.equal(taken.reduce((sum, one) => sum + area(one), 0), 10 * 64 * 64);
  assert.deepEqual(taken.map(({ min, max }) => [min.x, min.y, max.x, max.y])[0], [0, 0, 320, 64]);
  for (const one of marked.slice(0, 4)) {
    for (const x of [one.min.x, one.max.x - 0.5]) for (const y of [one.min.y, one.max.y - 0.5]) assert.ok(taken.some((other) => other.containsPoint(new Vector2(x, y))), `${x}, ${y}`);
  }
  tiles.mark(box(0, 0, 300, 10));
  assert.deepEqual([tiles.take(2), tiles.take(1), tiles.take(9)].map((one) => one.max.x - one.min.x), [128, 64, 128]);
});

test("stock is asked for the newest time alone, and comes to it in parts", async () => {
  const asked = [];
  const behind = [];
  let answer = null;
  const ends = {
    cut: (time) => new Promise((resolve) => (asked.push(time), (answer = (at = time) => resolve({ time: at, isThere: at === time, bricks: changes() })))),
    draw: async () => undefined,
    onBehind: (isBehind) => behind.push(isBehind),
    onRefused: assert.fail,
  };
  const follower = new StockFollower(ends, 0);
  const settled = () => new Promise((resolve) => setTimeout(resolve, 50));
  // A busy machine takes its time.
  const asks = async (count) => {
    while (asked.length < count) await settled();
  };
  for (const time of [1, 2, 3]) follower.seek(time);
  assert.deepEqual(asked, [1]);
  answer();
  await asks(2);
  assert.deepEqual(asked, [1, 3]);
  // Half of the way: the rest is asked for, unless another time is wanted meanwhile.
  answer(2.5);
  await asks(3);
  assert.deepEqual(asked, [1, 3, 3]);
  follower.seek(0);
  answer(2.8);
  await asks(4);
  answer();
  await settled();
  assert.deepEqual(asked, [1, 3, 3, 0]);
  assert.deepEqual(behind, [false, true, true, false]);
  // Where it is already, nothing is asked; after its end, nothing at all.
  follower.seek(0);
  follower.end();
  follower.seek(5);
  await settled();
  assert.equal(asked.length, 4);
});
