// Lines that two programs share, in order.

/** Largest table of a gap without unique lines; beyond it the whole gap counts as changed. */
const TABLE = 1_000_000;

type Range = [number, number, number, number];

/** Line of `b` that each line of `a` is, -1 for none; lines of `b` rise. */
export function sharedLines(a: string[], b: string[]): Int32Array {
  const numbers = new Map<string, number>();
  const number = (line: string) => {
    const known = numbers.get(line);
    if (known !== undefined) return known;
    numbers.set(line, numbers.size);
    return numbers.size - 1;
  };
  const [x, y] = [Int32Array.from(a, number), Int32Array.from(b, number)];
  const match = new Int32Array(a.length).fill(-1);
  const waiting: Range[] = [[0, x.length, 0, y.length]];
  for (let range = waiting.pop(); range; range = waiting.pop()) {
    const inner = trim(x, y, range, match);
    if (inner) for (const part of divide(x, y, inner, match)) waiting.push(part);
  }
  return match;
}

/** Matches equal lines at both ends of a range; returns what is between them, null for nothing. */
function trim(x: Int32Array, y: Int32Array, range: Range, match: Int32Array): Range | null {
  let [a0, a1, b0, b1] = range;
  for (; a0 < a1 && b0 < b1 && x[a0] === y[b0]; a0 += 1, b0 += 1) match[a0] = b0;
  for (; a0 < a1 && b0 < b1 && x[a1 - 1] === y[b1 - 1]; a1 -= 1, b1 -= 1) match[a1 - 1] = b1 - 1;
  return a0 < a1 && b0 < b1 ? [a0, a1, b0, b1] : null;
}

/** Divides a range at the lines that each side has once; a small one without such lines is matched by a table. */
function divide(x: Int32Array, y: Int32Array, [a0, a1, b0, b1]: Range, match: Int32Array): Range[] {
  const anchors = rising(once(x, y, [a0, a1, b0, b1]));
  if (anchors.length === 0) {
    if ((a1 - a0) * (b1 - b0) <= TABLE) longest(x, y, [a0, a1, b0, b1], match);
    return [];
  }
  const gaps: Range[] = [];
  let [from, to] = [a0, b0];
  for (const [a, b] of anchors) {
    match[a] = b;
    gaps.push([from, a, to, b]);
    [from, to] = [a + 1, b + 1];
  }
  return [...gaps, [from, a1, to, b1] as Range].filter(([p, q, r, s]) => p < q && r < s);
}

/** Pairs of lines that are there once on each side, in order of the first. */
function once(x: Int32Array, y: Int32Array, [a0, a1, b0, b1]: Range): [number, number][] {
  const places = (lines: Int32Array, from: number, to: number) => {
    const found = new Map<number, number>();
    for (let at = from; at < to; at += 1) found.set(lines[at]!, found.has(lines[at]!) ? -1 : at);
    return found;
  };
  const there = places(y, b0, b1);
  const pairs: [number, number][] = [];
  for (const [line, at] of places(x, a0, a1)) {
    const other = there.get(line) ?? -1;
    if (at >= 0 && other >= 0) pairs.push([at, other]);
  }
  return pairs.sort((p, q) => p[0] - q[0]);
}

/** Longest part of the pairs in which both numbers rise. */
function rising(pairs: [number, number][]): [number, number][] {
  const ends: number[] = [];
  const before = new Int32Array(pairs.length).fill(-1);
  pairs.forEach(([, b], at) => {
    let [low, high] = [0, ends.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (pairs[ends[middle]!]![1] < b) low = middle + 1;
      else high = middle;
    }
    before[at] = low > 0 ? ends[low - 1]! : -1;
    ends[low] = at;
  });
  const chain: [number, number][] = [];
  for (let at = ends.at(-1) ?? -1; at >= 0; at = before[at]!) chain.push(pairs[at]!);
  return chain.reverse();
}

/** Longest common lines of a small range. */
function longest(x: Int32Array, y: Int32Array, [a0, a1, b0, b1]: Range, match: Int32Array): void {
  const width = b1 - b0 + 1;
  const table = new Int32Array((a1 - a0 + 1) * width);
  for (let a = a1 - a0 - 1; a >= 0; a -= 1) {
    for (let b = b1 - b0 - 1; b >= 0; b -= 1) {
      const here = a * width + b;
      const isSame = x[a0 + a] === y[b0 + b];
      table[here] = isSame ? table[here + width + 1]! + 1 : Math.max(table[here + width]!, table[here + 1]!);
    }
  }
  for (let a = 0, b = 0; a < a1 - a0 && b < b1 - b0; ) {
    const here = a * width + b;
    if (x[a0 + a] === y[b0 + b]) {
      match[a0 + a] = b0 + b;
      [a, b] = [a + 1, b + 1];
    } else if (table[here + width]! >= table[here + 1]!) a += 1;
    else b += 1;
  }
}

/**
 * Rows of both programs in one list: line of the first and of the second, 0 where one has none. Lines that changed stand in
 * turns, so that the same place of both programs is in sight at once.
 */
export function rowsOf(match: Int32Array, count: number): Int32Array {
  const rows: number[] = [];
  let [first, second] = [0, 0];
  const changed = (firstEnd: number, secondEnd: number) => {
    const [m, n] = [firstEnd - first, secondEnd - second];
    for (let a = 0, b = 0; a < m || b < n; ) {
      // The program that is behind goes on; each at its own pace.
      if (b >= n || (a < m && a * n <= b * m)) rows.push(first + ++a, 0);
      else rows.push(0, second + ++b);
    }
    [first, second] = [firstEnd, secondEnd];
  };
  match.forEach((other, at) => {
    if (other < 0) return;
    changed(at, other);
    rows.push(at + 1, other + 1);
    [first, second] = [at + 1, other + 1];
  });
  changed(match.length, count);
  return Int32Array.from(rows);
}
