// The picture without WebGL: triangles from back to front on a 2-D canvas. Can still be turned.

import { colourOfDeviation, css } from "./colour.js";
import { STRIDE, deviationAt } from "./data.js";

/** Triangles drawn at most: a tenth of a second on an old machine. */
const MOST = 40_000;

const KINDS = {
  contact: { kinds: ["cut"], first: 7, colour: "#223344" },
  tip: { kinds: ["cut"], first: 1, colour: "#8a63cc" },
  leads: { kinds: ["leadin", "leadout"], first: 1, colour: "#1b8a4b" },
  links: { kinds: ["link"], first: 1, colour: "#b06a00" },
};

export class FlatView {
  constructor(host, data) {
    this.host = host;
    this.data = data;
    this.canvas = document.createElement("canvas");
    host.append(this.canvas);
    const contact = data.path.contacts;
    this.layers = { surface: true, contact, tip: !contact, leads: true, links: false, tool: true, fixtures: true };
    this.pose = null;
    this.point = null;
    this.turn = [-0.58, 0.62];
    this.zoom = 1;
    const { low, high } = data.surface;
    this.centre = low.map((x, k) => 0.5 * (x + high[k]));
    this.radius = 0.5 * Math.hypot(...low.map((x, k) => high[k] - x)) || 1;
    this.listen();
    new ResizeObserver(() => this.draw()).observe(host);
    this.draw();
  }

  listen() {
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this.grip = [event.clientX, event.clientY];
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!this.grip) return;
      const [x, y] = this.grip;
      this.turn[0] -= 0.008 * (event.clientX - x);
      this.turn[1] = Math.min(Math.max(this.turn[1] + 0.008 * (event.clientY - y), -1.57), 1.57);
      this.grip = [event.clientX, event.clientY];
      this.draw();
    });
    this.canvas.addEventListener("pointerup", () => {
      this.grip = null;
    });
    this.canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        this.zoom *= Math.exp(-0.0015 * event.deltaY);
        this.draw();
      },
      { passive: false },
    );
  }

  /** Workpiece point -> [x, y, depth towards the eye]. */
  project() {
    const [round, up] = this.turn;
    const [s, c, su, cu] = [Math.sin(round), Math.cos(round), Math.sin(up), Math.cos(up)];
    const { clientWidth: width, clientHeight: height } = this.host;
    const scale = (this.zoom * 0.46 * Math.min(width, height * 1.25)) / this.radius;
    const [x0, y0, z0] = this.centre;
    return (x, y, z) => {
      const [dx, dy, dz] = [x - x0, y - y0, z - z0];
      const right = c * dx + s * dy;
      const away = -s * dx + c * dy;
      return [
        0.5 * width + scale * right,
        0.5 * height - scale * (su * away + cu * dz),
        su * dz - cu * away,
      ];
    };
  }

  fit() {
    this.zoom = 1;
    this.turn = [-0.58, 0.62];
    this.draw();
  }

  theme() {
    this.draw();
  }

  show(layer, visible) {
    this.layers[layer] = visible;
    this.draw();
  }

  placeTool(pose) {
    this.pose = pose;
    this.draw();
  }

  mark(point) {
    this.point = point;
    this.draw();
  }

  pick(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    const project = this.project();
    const { positions, count } = this.data.surface;
    let best = null;
    let nearest = 14 * 14;
    let front = -Infinity;
    for (let vertex = 0; vertex < count; vertex += 1) {
      const at = positions.subarray(3 * vertex, 3 * vertex + 3);
      const [x, y, depth] = project(at[0], at[1], at[2]);
      const away = (x - clientX + box.left) ** 2 + (y - clientY + box.top) ** 2;
      if (away < nearest && depth > front - 0.1 * this.radius) {
        [best, nearest, front] = [vertex, away, depth];
      }
    }
    return best;
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.paint();
    });
  }

  paint() {
    const { clientWidth: width, clientHeight: height } = this.host;
    const dots = Math.min(window.devicePixelRatio || 1, 2);
    Object.assign(this.canvas, { width: width * dots, height: height * dots });
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    const brush = this.canvas.getContext("2d");
    brush.scale(dots, dots);
    const project = this.project();
    if (this.layers.surface) this.paintSurface(brush, project);
    if (this.layers.fixtures && this.data.fixtures) this.paintFixtures(brush, project);
    for (const [key, line] of Object.entries(KINDS)) {
      if (this.layers[key]) this.paintLines(brush, project, line);
    }
    if (this.layers.tool && this.pose) this.paintTool(brush, project);
    if (this.point) {
      const [x, y] = project(...this.point);
      brush.fillStyle = "#ff2bd6";
      brush.beginPath();
      brush.arc(x, y, 5, 0, 2 * Math.PI);
      brush.fill();
    }
  }

  paintSurface(brush, project) {
    const { surface, budget } = this.data;
    const { positions, triangles } = surface;
    const stride = Math.max(1, Math.ceil(triangles.length / 3 / MOST));
    const faces = [];
    for (let at = 0; at + 2 < triangles.length; at += 3 * stride) {
      const corners = [0, 1, 2].map((k) => {
        const v = 3 * triangles[at + k];
        return project(positions[v], positions[v + 1], positions[v + 2]);
      });
      faces.push({ corners, vertex: triangles[at], depth: corners[0][2] + corners[1][2] });
    }
    faces.sort((a, b) => a.depth - b.depth);
    const grow = Math.sqrt(stride);
    brush.lineJoin = "round";
    for (const { corners, vertex } of faces) {
      const [[ax, ay], [bx, by], [cx, cy]] = corners;
      const turned = Math.abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax));
      const longest = Math.max((bx - ax) ** 2 + (by - ay) ** 2, (cx - ax) ** 2 + (cy - ay) ** 2);
      const light = 0.72 + 0.28 * Math.min(1, (1.2 * turned) / (longest || 1));
      const colour = colourOfDeviation(deviationAt(surface, vertex), budget);
      brush.fillStyle = css(colour.map((x) => Math.round(light * x)));
      brush.strokeStyle = brush.fillStyle;
      brush.lineWidth = grow;
      brush.beginPath();
      corners.forEach(([x, y], k) => (k === 0 ? brush.moveTo(x, y) : brush.lineTo(x, y)));
      brush.closePath();
      brush.fill();
      brush.stroke();
    }
  }

  /** As they would be seen through: all edges. */
  paintFixtures(brush, project) {
    const { positions, triangles } = this.data.fixtures;
    const stride = Math.max(1, Math.ceil(triangles.length / 3 / MOST));
    brush.strokeStyle = "rgb(217 142 60 / 0.6)";
    brush.lineWidth = 0.8;
    brush.beginPath();
    for (let at = 0; at + 2 < triangles.length; at += 3 * stride) {
      [0, 1, 2, 0].forEach((k, step) => {
        const [x, y] = project(...positions.subarray(3 * triangles[at + k], 3 * triangles[at + k] + 3));
        if (step === 0) brush.moveTo(x, y);
        else brush.lineTo(x, y);
      });
    }
    brush.stroke();
  }

  paintLines(brush, project, { kinds, first, colour }) {
    const { points, pieces } = this.data.path;
    brush.strokeStyle = colour;
    brush.lineWidth = 0.9;
    for (const { kind, start, count } of pieces) {
      if (!kinds.includes(kind)) continue;
      brush.beginPath();
      for (let at = start; at < start + count; at += 1) {
        const from = STRIDE * at + first;
        const [x, y] = project(points[from], points[from + 1], points[from + 2]);
        if (at === start) brush.moveTo(x, y);
        else brush.lineTo(x, y);
      }
      brush.stroke();
    }
  }

  paintTool(brush, project) {
    const { tip, axis } = this.pose;
    const side = Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const cross = (a, b) => [0, 1, 2].map((k) => {
      const [i, j] = [(k + 1) % 3, (k + 2) % 3];
      return a[i] * b[j] - a[j] * b[i];
    });
    const u = cross(axis, side);
    const length = Math.hypot(...u);
    const e1 = u.map((x) => x / length);
    const e2 = cross(axis, e1);
    brush.strokeStyle = "rgb(110 120 132 / 0.8)";
    brush.lineWidth = 1;
    for (const [radius, height] of this.data.tools[this.pose.tool] ?? []) {
      brush.beginPath();
      for (let step = 0; step <= 36; step += 1) {
        const [s, c] = [Math.sin((step * Math.PI) / 18), Math.cos((step * Math.PI) / 18)];
        const at = tip.map((x, k) => x + height * axis[k] + radius * (c * e1[k] + s * e2[k]));
        const [x, y] = project(...at);
        if (step === 0) brush.moveTo(x, y);
        else brush.lineTo(x, y);
      }
      brush.stroke();
    }
  }
}
