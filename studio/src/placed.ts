// Passes while they are placed.

/** Passes of all faces, as the engine tells them: one change after the other. */
export class PlacedPasses {
  private readonly faces = new Map<number, Float32Array[]>();
  private readonly changed = new Set<number>();

  /** Takes what is new about a face: its first `kept` passes stay, and those of `counts` points each follow, x, y, z by x, y, z. */
  take(face: number, kept: number, points: Float32Array, counts: Uint32Array): void {
    const passes = (this.faces.get(face) ?? []).slice(0, kept);
    let start = 0;
    for (const count of counts) {
      passes.push(points.slice(start, start + 3 * count));
      start += 3 * count;
    }
    this.faces.set(face, passes);
    this.changed.add(face);
  }

  /** Number of all passes. */
  get count(): number {
    return [...this.faces.values()].reduce((sum, passes) => sum + passes.length, 0);
  }

  /** Ends of the segments of every face that has changed since the last call. */
  changes(): Map<number, Float32Array<ArrayBuffer>> {
    const found = new Map([...this.changed].map((face) => [face, segments(this.faces.get(face) ?? [])] as const));
    this.changed.clear();
    return found;
  }
}

/** Both ends of every segment of polylines. */
function segments(passes: Float32Array[]): Float32Array<ArrayBuffer> {
  const lengths = passes.map((points) => Math.max(2 * points.length - 6, 0));
  const ends = new Float32Array(lengths.reduce((sum, length) => sum + length, 0));
  let at = 0;
  for (const points of passes) {
    for (let k = 0; k + 6 <= points.length; k += 3) {
      ends.set(points.subarray(k, k + 6), at);
      at += 6;
    }
  }
  return ends;
}
