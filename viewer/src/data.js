// The page's JSON -> typed arrays, and questions about a moment in time.

const bytes = (text) => {
  const raw = atob(text);
  const array = new Uint8Array(raw.length);
  for (let at = 0; at < raw.length; at += 1) array[at] = raw.charCodeAt(at);
  return array;
};

export const floats = (text) => new Float32Array(bytes(text).buffer);
export const words = (text) => new Uint16Array(bytes(text).buffer);
export const shorts = (text) => new Int16Array(bytes(text).buffer);
export const longs = (text) => new Uint32Array(bytes(text).buffer);

/** Deviation that stands for "nothing was cut". */
export const UNCUT = -32768;

/** Numbers of a path point: t, tip, axis, contact. */
export const STRIDE = 10;

const band = ({ min, max }) => ({ min: floats(min), max: floats(max) });

function surface(packed) {
  const fractions = words(packed.positions);
  const positions = new Float32Array(fractions.length);
  for (let at = 0; at < fractions.length; at += 1) {
    const low = packed.low[at % 3];
    positions[at] = low + ((packed.high[at % 3] - low) * fractions[at]) / 65535;
  }
  return {
    low: packed.low,
    high: packed.high,
    positions,
    triangles: longs(packed.triangles),
    deviation: shorts(packed.deviation),
    step: packed.step,
    count: fractions.length / 3,
    measured: packed.measured,
  };
}

function path(packed) {
  const points = floats(packed.points);
  let start = 0;
  const pieces = packed.kinds.map((kind, at) => {
    const piece = { kind, start, count: packed.counts[at], tool: packed.tools[at] };
    start += piece.count;
    return piece;
  });
  return { points, pieces, count: start, contacts: packed.contacts };
}

function solid(packed) {
  return packed && { positions: floats(packed.positions), triangles: longs(packed.triangles) };
}

export function unpack(packed) {
  const { motion } = packed;
  return {
    ...packed,
    surface: surface(packed.surface),
    path: path(packed.path),
    fixtures: solid(packed.fixtures),
    motion: {
      ...motion,
      speed: band(motion.speed),
      tip: band(motion.tip),
      binding: bytes(motion.binding),
      bands: motion.bands.map(({ position, velocity, acceleration, jerk }) => ({
        position: band(position),
        velocity: band(velocity),
        acceleration: band(acceleration),
        jerk: band(jerk),
      })),
    },
  };
}

/** Deviation of a vertex in mm; null where nothing was cut, undefined where nothing was measured. */
export function deviationAt(surface, vertex) {
  if (vertex >= surface.deviation.length) return undefined;
  const packed = surface.deviation[vertex];
  return packed === UNCUT ? null : packed * surface.step;
}

/** Tool at a time: tip, axis, contact and kind of motion; null without a path. */
export function toolAt({ points, pieces, count }, t) {
  if (count === 0) return null;
  let low = 0;
  let high = count - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (points[STRIDE * middle] <= t) low = middle;
    else high = middle - 1;
  }
  const next = Math.min(low + 1, count - 1);
  const [t0, t1] = [points[STRIDE * low], points[STRIDE * next]];
  const share = t1 > t0 ? Math.min(Math.max((t - t0) / (t1 - t0), 0), 1) : 0;
  const mix = (first) =>
    [0, 1, 2].map((k) => {
      const from = points[STRIDE * low + first + k];
      return from + share * (points[STRIDE * next + first + k] - from);
    });
  const axis = mix(4);
  const length = Math.hypot(...axis) || 1;
  const { kind, tool } = pieces.find(({ start, count: size }) => low < start + size) ?? pieces.at(-1);
  return { tip: mix(1), axis: axis.map((x) => x / length), contact: mix(7), kind, tool };
}

/** Time of the last point of the path. */
export const endOf = ({ points, count }) => (count > 0 ? points[STRIDE * (count - 1)] : 0);

/** How far a point [radius, height above the tip] is off the outline of a tool; below 0 inside. */
function off(outline, [radius, height]) {
  let nearest = Infinity;
  let inside = false;
  for (let at = 1; at < outline.length; at += 1) {
    const [[r0, h0], [r1, h1]] = [outline[at - 1], outline[at]];
    const [dr, dh] = [r1 - r0, h1 - h0];
    const size = dr * dr + dh * dh;
    const share = size > 0 ? Math.min(Math.max(((radius - r0) * dr + (height - h0) * dh) / size, 0), 1) : 0;
    nearest = Math.min(nearest, Math.hypot(radius - r0 - share * dr, height - h0 - share * dh));
    if (h0 <= height !== h1 <= height && radius < r0 + ((height - h0) / dh) * dr) inside = true;
  }
  return inside ? -nearest : nearest;
}

/** Time at which the tool was nearest to a point, or the point deepest in the tool. */
export function toolTime({ points, pieces }, outlines, [x, y, z]) {
  let [best, nearest] = [null, Infinity];
  for (const { start, count, tool } of pieces) {
    for (let at = start; at < start + count; at += 1) {
      const [t, px, py, pz, i, j, k] = points.subarray(STRIDE * at, STRIDE * at + 7);
      const [dx, dy, dz] = [x - px, y - py, z - pz];
      const height = dx * i + dy * j + dz * k;
      const radius = Math.sqrt(Math.max(dx * dx + dy * dy + dz * dz - height * height, 0));
      const away = off(outlines[tool] ?? [], [radius, height]);
      if (away < nearest) [best, nearest] = [t, away];
    }
  }
  return best;
}

/** Time at which the cutter contact was nearest to a point. */
export function contactTime({ points, pieces }, [x, y, z]) {
  let [best, nearest] = [null, Infinity];
  for (const { kind, start, count } of pieces) {
    if (kind !== "cut") continue;
    for (let at = start; at < start + count; at += 1) {
      const p = STRIDE * at;
      const away = (points[p + 7] - x) ** 2 + (points[p + 8] - y) ** 2 + (points[p + 9] - z) ** 2;
      if (away < nearest) [best, nearest] = [points[p], away];
    }
  }
  return best;
}

/** Slot of a time. */
export const slotAt = ({ duration, slots }, t) =>
  Math.min(Math.max(Math.floor((t / duration) * slots), 0), slots - 1);

/** Axis and rate (0 velocity, 1 acceleration, 2 jerk) of a binding limit from 2 on. */
export const limitOf = (binding) => ({ axis: Math.floor((binding - 2) / 3), rate: (binding - 2) % 3 });

/** Name of a binding limit as numbered by the report. */
export function limitName(axes, binding) {
  if (binding === 0) return "nothing";
  if (binding === 1) return "feed";
  const { axis, rate } = limitOf(binding);
  const second = axes[axis]?.chord ? "chord error" : "acceleration";
  return `${axes[axis]?.name ?? "?"} ${["velocity", second, "jerk"][rate]}`;
}
