// Questions about the moves of a program: time of a line, line, tool and axes at a time, charts.

import type { Link, Machine, Replay } from "./messages";

const AXES = 5;
const POSE = 6;
/** Columns of the charts: about two a pixel. */
const SLOTS = 3000;

export interface ToolPlace {
  tip: number[];
  axis: number[];
  tool: number;
  line: number;
  isRapid: boolean;
}

interface Band {
  min: Float32Array;
  max: Float32Array;
}

const band = (): Band => ({ min: new Float32Array(SLOTS).fill(Infinity), max: new Float32Array(SLOTS).fill(-Infinity) });

export class Timeline {
  readonly count: number;
  readonly end: number;
  private lengthsOfCut: Float64Array | null = null;

  constructor(readonly moves: Replay) {
    this.count = moves.times.length;
    this.end = this.count > 0 ? moves.times[this.count - 1]! : 0;
  }

  /** Last point that is not after a time. */
  private at(t: number): number {
    const { times } = this.moves;
    let [low, high] = [0, this.count - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle]! <= t) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** Point before a time, the point after it, and the share of the way between both. */
  private between(t: number): [number, number, number] {
    const { times, kinds } = this.moves;
    const from = this.at(t);
    const to = Math.min(from + 1, this.count - 1);
    // Between moves that do not meet nothing is known.
    if ((kinds[to]! & 2) !== 0 && to !== from) return [from, from, 0];
    const span = times[to]! - times[from]!;
    return [from, to, span > 0 ? Math.min(Math.max((t - times[from]!) / span, 0), 1) : 0];
  }

  toolAt(t: number): ToolPlace {
    const { poses, kinds, lines } = this.moves;
    const [from, to, share] = this.between(t);
    const mix = (k: number) => poses[POSE * from + k]! * (1 - share) + poses[POSE * to + k]! * share;
    const axis = [mix(3), mix(4), mix(5)];
    const length = Math.hypot(...axis) || 1;
    const kind = kinds[to]!;
    return {
      tip: [mix(0), mix(1), mix(2)],
      axis: axis.map((x) => x / length),
      tool: kind >> 2,
      line: lines[to]!,
      isRapid: (kind & 1) === 1,
    };
  }

  /** Axes at a time, mm and rad; null for cutter locations. */
  axesAt(t: number): number[] | null {
    const { axes } = this.moves;
    if (axes.length === 0) return null;
    const [from, to, share] = this.between(t);
    return [0, 1, 2, 3, 4].map((k) => axes[AXES * from + k]! * (1 - share) + axes[AXES * to + k]! * share);
  }

  /** Lengths of the path with feed and of rapid moves at the tip, mm. */
  lengths(): [number, number] {
    const sums: [number, number] = [0, 0];
    for (let at = 1; at < this.count; at += 1) sums[this.moves.kinds[at]! & 1]! += this.stepLength(at);
    return sums;
  }

  /** Paths with feed between rapid moves. */
  countCuts(): number {
    const { kinds } = this.moves;
    let count = 0;
    for (let at = 1; at < this.count; at += 1) if ((kinds[at]! & 1) === 0 && ((kinds[at - 1]! & 1) === 1 || at === 1)) count += 1;
    return count;
  }

  /** Point before the first move of every line, and that at the end of its last. */
  pointsOfLines(): Map<number, [number, number]> {
    const found = new Map<number, [number, number]>();
    this.moves.lines.forEach((line, at) => {
      const known = found.get(line);
      if (known) known[1] = at;
      else found.set(line, [Math.max(at - 1, 0), at]);
    });
    return found;
  }

  tipAt(point: number): number[] {
    return [0, 1, 2].map((k) => this.moves.poses[POSE * point + k]!);
  }

  /** Ends of the moves with feed of some lines, as three numbers each. */
  cutLines(isWanted: (line: number) => boolean): Float32Array {
    const { kinds, lines, poses } = this.moves;
    const isDrawn = (at: number) => (kinds[at]! & 3) === 0 && isWanted(lines[at]!);
    let count = 0;
    for (let at = 1; at < this.count; at += 1) if (isDrawn(at)) count += 1;
    const ends = new Float32Array(6 * count);
    let to = 0;
    for (let at = 1; at < this.count; at += 1) {
      if (!isDrawn(at)) continue;
      ends.set(poses.subarray(POSE * (at - 1), POSE * (at - 1) + 3), to);
      ends.set(poses.subarray(POSE * at, POSE * at + 3), to + 3);
      to += 6;
    }
    return ends;
  }

  private stepLength(at: number): number {
    const { poses, kinds } = this.moves;
    const p = POSE * at;
    if ((kinds[at]! & 2) !== 0) return 0;
    return Math.hypot(poses[p]! - poses[p - POSE]!, poses[p + 1]! - poses[p + 1 - POSE]!, poses[p + 2]! - poses[p + 2 - POSE]!);
  }

  /** Length with feed up to every point. */
  private cuts(): Float64Array {
    if (this.lengthsOfCut) return this.lengthsOfCut;
    const sums = new Float64Array(this.count);
    for (let at = 1; at < this.count; at += 1) sums[at] = sums[at - 1]! + ((this.moves.kinds[at]! & 1) === 0 ? this.stepLength(at) : 0);
    return (this.lengthsOfCut = sums);
  }

  /** Share of the path with feed that is cut at a time. */
  cutAt(t: number): number {
    const sums = this.cuts();
    const [from, to, share] = this.between(t);
    return (sums[from]! * (1 - share) + sums[to]! * share) / (sums[this.count - 1]! || 1);
  }

  /** First time at which a share of the path with feed is cut. */
  timeAtCut(share: number): number {
    const { times } = this.moves;
    const sums = this.cuts();
    const wanted = share * sums[this.count - 1]!;
    let [low, high] = [0, this.count - 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (sums[middle]! < wanted) low = middle + 1;
      else high = middle;
    }
    const before = Math.max(low - 1, 0);
    const span = sums[low]! - sums[before]!;
    const part = span > 0 ? (wanted - sums[before]!) / span : 1;
    return times[before]! + part * (times[low]! - times[before]!);
  }

  /** End of the move of a line, or of the next line that moves; null after the last. */
  timeOfLine(line: number): number | null {
    const { lines, times } = this.moves;
    for (let at = 0; at < this.count; at += 1) {
      if (lines[at]! === line) {
        while (at + 1 < this.count && lines[at + 1] === line) at += 1;
        return times[at]!;
      }
    }
    const next = lines.findIndex((other) => other > line);
    return next < 0 ? null : times[next]!;
  }

  /** Time at the end of the next (1) or previous (-1) line that moves. */
  step(t: number, by: 1 | -1): number {
    const { lines, times } = this.moves;
    // Just after a time: the end of a line belongs to it.
    let at = this.at(t + 1e-9);
    const here = lines[at];
    while (at >= 0 && at < this.count && (lines[at] === here || (by > 0 && times[at]! <= t))) at += by;
    if (at < 0) return 0;
    if (at >= this.count) return this.end;
    const there = lines[at];
    while (by > 0 && at + 1 < this.count && lines[at + 1] === there) at += 1;
    return times[at]!;
  }

  /** Time at which the tool is nearest to a point of the part, seen from its profile. */
  timeNear(point: number[], outlines: number[][][]): number | null {
    const { poses, kinds, times } = this.moves;
    const [x, y, z] = point as [number, number, number];
    let [best, nearest] = [null as number | null, Infinity];
    for (let at = 0; at < this.count; at += 1) {
      const p = POSE * at;
      const [dx, dy, dz] = [x - poses[p]!, y - poses[p + 1]!, z - poses[p + 2]!];
      const height = dx * poses[p + 3]! + dy * poses[p + 4]! + dz * poses[p + 5]!;
      const radius = Math.sqrt(Math.max(dx * dx + dy * dy + dz * dz - height * height, 0));
      const away = outside(outlines[kinds[at]! >> 2] ?? [], radius, height);
      if (away < nearest) [best, nearest] = [times[at]!, away];
    }
    return best;
  }

  /** Motion of the axes for the charts; null without axes. Velocities are means between two points. */
  motion(): object | null {
    const { machine, times, axes, poses, kinds } = this.moves;
    if (!machine || this.count < 2 || !(this.end > 0)) return null;
    const links = linksOf(machine);
    const bands = links.map(() => ({ position: band(), velocity: band() }));
    const tip = band();
    for (let at = 1; at < this.count; at += 1) {
      if ((kinds[at]! & 2) !== 0) continue;
      const span = times[at]! - times[at - 1]!;
      const [first, last] = [times[at - 1]!, times[at]!].map((t) => Math.min(Math.floor((t / this.end) * SLOTS), SLOTS - 1));
      const put = (into: Band, value: number) => {
        for (let slot = first!; slot <= last!; slot += 1) {
          if (value < into.min[slot]!) into.min[slot] = value;
          if (value > into.max[slot]!) into.max[slot] = value;
        }
      };
      links.forEach((link, k) => {
        const unit = link.rotary ? 180 / Math.PI : 1;
        const [from, to] = [axes[AXES * (at - 1) + link.axis]! * unit, axes[AXES * at + link.axis]! * unit];
        put(bands[k]!.position, from);
        put(bands[k]!.position, to);
        if (span > 0) put(bands[k]!.velocity, (to - from) / span);
      });
      const p = POSE * at;
      if (span > 0) put(tip, Math.hypot(...[0, 1, 2].map((k) => poses[p + k]! - poses[p + k - POSE]!)) / span);
    }
    for (const one of [tip, ...bands.flatMap(({ position, velocity }) => [position, velocity])]) close(one);
    const shown = links.map((link) => {
      const unit = link.rotary ? 180 / Math.PI : 1;
      return {
        name: link.name,
        unit: link.rotary ? "deg" : "mm",
        travel: link.travel?.map((end) => end * unit) ?? null,
        velocity: Math.max(...link.velocity) * unit,
        jerk: 0,
      };
    });
    return { duration: this.end, slots: SLOTS, axes: shown, bands, tip, feed: 0, binding: new Uint8Array(SLOTS) };
  }
}

/** Links in the order of the axes. */
export const linksOf = (machine: Machine): Link[] =>
  [...machine.workpiece_side, ...machine.tool_side].sort((a, b) => a.axis - b.axis);

/** Slots that no move touched repeat the one before. */
function close({ min, max }: Band): void {
  for (let slot = 0; slot < SLOTS; slot += 1) {
    if (min[slot]! > max[slot]!) min[slot] = max[slot] = slot > 0 ? max[slot - 1]! : 0;
  }
}

/** Distance of a point from the outline of a tool, below 0 inside. */
function outside(outline: number[][], radius: number, height: number): number {
  let nearest = outline.length > 0 ? Infinity : Math.hypot(radius, height);
  let isInside = false;
  for (let at = 1; at < outline.length; at += 1) {
    const [r0, h0] = outline[at - 1] as [number, number];
    const [r1, h1] = outline[at] as [number, number];
    const [dr, dh] = [r1 - r0, h1 - h0];
    const size = dr * dr + dh * dh;
    const share = size > 0 ? Math.min(Math.max(((radius - r0) * dr + (height - h0) * dh) / size, 0), 1) : 0;
    nearest = Math.min(nearest, Math.hypot(radius - r0 - share * dr, height - h0 - share * dh));
    if (h0 <= height !== h1 <= height && radius < r0 + ((height - h0) / dh) * dr) isInside = !isInside;
  }
  return isInside ? -nearest : nearest;
}
