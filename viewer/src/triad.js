// Small arrows that say where the workpiece's x, y and z point.

import { Vector3 } from "three";

/** Lengths of arrows, and of the way to their names, in units of the drawing. */
const [ARM, REACH] = [26, 35];
/** Least distance between two names: a letter is about so high. */
const APART = 14;

/** Places of the names of three arms as they are seen, each [right, up] in their lengths: no two overlap. */
export function namePlaces(arms) {
  const places = [];
  // The longest keep their place; names of arms towards the eye make way.
  const order = [0, 1, 2].sort((a, b) => Math.hypot(...arms[b]) - Math.hypot(...arms[a]));
  for (const k of order) {
    const at = arms[k].map((x) => REACH * x);
    const isFree = ([x, y]) => places.every((other) => Math.hypot(x - other[0], y - other[1]) >= APART);
    // Round the end of the arm, ever farther, until there is room.
    const around = Array.from({ length: 48 }, (_, turn) => {
      const [size, angle] = [(APART / 2) * (1 + Math.floor(turn / 12)), (Math.PI * turn) / 6];
      return [at[0] + size * Math.cos(angle), at[1] + size * Math.sin(angle)];
    });
    places[k] = [at, ...around].find(isFree) ?? at;
  }
  return places;
}

export class Triad {
  constructor(host) {
    const space = "http://www.w3.org/2000/svg";
    this.svg = document.createElementNS(space, "svg");
    this.svg.setAttribute("class", "triad");
    this.svg.setAttribute("viewBox", "-48 -48 96 96");
    this.arms = ["x", "y", "z"].map((name) => {
      const line = document.createElementNS(space, "line");
      const text = document.createElementNS(space, "text");
      line.setAttribute("class", name);
      text.textContent = name;
      this.svg.append(line, text);
      return { line, text };
    });
    host.append(this.svg);
  }

  turn(camera) {
    const view = camera.quaternion.clone().invert();
    const seen = [0, 1, 2].map((k) => new Vector3().setComponent(k, 1).applyQuaternion(view)).map(({ x, y }) => [x, y]);
    const places = namePlaces(seen);
    this.arms.forEach(({ line, text }, k) => {
      line.setAttribute("x2", ARM * seen[k][0]);
      line.setAttribute("y2", -ARM * seen[k][1]);
      text.setAttribute("x", places[k][0]);
      text.setAttribute("y", -places[k][1] + 4);
    });
  }
}
