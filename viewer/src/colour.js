// Deviation -> colour. The scale is symmetric in tolerances: -1 is the gouge tolerance, +1 the
// total; beyond either the colour changes sharply, so that a broken tolerance cannot be missed.

/** Ends of the scale, in tolerances. */
export const REACH = 2;

/** Columns of the lookup texture. */
export const COLUMNS = 1024;

const STOPS = [
  [-2.0, [74, 0, 16]],
  [-1.0, [226, 40, 60]],
  [-1.0, [250, 190, 160]],
  [-0.0, [250, 247, 236]],
  [0.5, [158, 205, 214]],
  [1.0, [46, 125, 170]],
  [1.0, [255, 183, 3]],
  [2.0, [140, 80, 0]],
];

/** Where nothing was cut. */
export const UNCUT_COLOUR = [70, 70, 78];
/** Where nothing was measured. */
export const PLAIN_COLOUR = [176, 186, 196];

/** Deviation in mm -> tolerances. */
export function inTolerances(deviation, { gouge, total }) {
  if (deviation < 0) return gouge > 0 ? deviation / gouge : -REACH;
  return total > 0 ? deviation / total : REACH * Math.sign(deviation);
}

/** Tolerances -> [red, green, blue], each 0..255. */
export function colourOf(value) {
  const clamped = Math.min(Math.max(value, -REACH), REACH);
  for (let at = 1; at < STOPS.length; at += 1) {
    const [[from, low], [to, high]] = [STOPS[at - 1], STOPS[at]];
    // At a step, the value itself still keeps the tolerance.
    if (to > from && (clamped < to || (clamped === to && to > -1))) {
      const share = (clamped - from) / (to - from);
      return low.map((channel, k) => Math.round(channel + share * (high[k] - channel)));
    }
  }
  return STOPS.at(-1)[1];
}

/** Colour of a deviation in mm, null or undefined. */
export function colourOfDeviation(deviation, budget) {
  if (deviation === undefined) return PLAIN_COLOUR;
  if (deviation === null) return UNCUT_COLOUR;
  return colourOf(inTolerances(deviation, budget));
}

export const css = ([r, g, b]) => `rgb(${r} ${g} ${b})`;

/** A length in micrometres, in words. */
export function micrometres(mm) {
  const value = 1000 * mm;
  return `${Math.abs(value) >= 99.95 ? value.toFixed(0) : value.toFixed(1)} µm`;
}
