// Starts the parts of the page and lets them share the time.

import "./theme.css";
import "./parts.css";
import "./style.css";
import { Charts, limitColour, number } from "./charts.js";
import { inTolerances, micrometres } from "./colour.js";
import {
  STRIDE,
  contactTime,
  deviationAt,
  endOf,
  limitName,
  slotAt,
  toolAt,
  toolTime,
  unpack,
} from "./data.js";
import { FlatView } from "./flat.js";
import { histogram, layers, legend } from "./panels.js";
import { View } from "./scene.js";

const find = (id) => document.getElementById(id);

function start() {
  const data = unpack(JSON.parse(find("data").textContent));
  find("loading").hidden = true;
  const { view, isFlat } = open(find("view"), data);
  legend(find("legend"), data);
  layers(find("layers"), view, data);
  if (isFlat) {
    find("legend").append(
      Object.assign(document.createElement("p"), {
        className: "hint",
        textContent: "Drawn without WebGL: coarser, but complete.",
      }),
    );
  }
  histogram(find("histogram"), data);
  const clock = data.path.count > 0 ? new Clock(view, data) : null;
  picking(view, data, clock);
  places(view, data, clock);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    view.theme();
    clock?.charts?.draw();
  });
  // Paper is light and has its own width.
  addEventListener("beforeprint", () => {
    view.theme(false);
    clock?.charts?.draw();
  });
  addEventListener("afterprint", () => {
    view.theme();
    clock?.charts?.draw();
  });
}

function open(host, data) {
  try {
    return { view: new View(host, data), isFlat: false };
  } catch {
    host.replaceChildren();
    return { view: new FlatView(host, data), isFlat: true };
  }
}

/** The shared time: slider, play button, tool; charts and readout where the motion of the axes is known. */
class Clock {
  constructor(view, data) {
    this.view = view;
    this.data = data;
    this.slider = find("time");
    this.end = data.motion.slots > 0 ? data.motion.duration : endOf(data.path);
    this.slider.max = this.end;
    if (data.motion.slots > 0) {
      this.charts = new Charts(find("charts"), find("binding"), data, (t) => this.set(t));
      this.readouts();
    }
    this.slider.addEventListener("input", () => this.set(Number(this.slider.value)));
    find("play").addEventListener("click", () => this.play(!this.playing));
    find("transport").hidden = false;
    const cut = data.path.pieces.find(({ kind }) => kind === "cut");
    const middle = cut ? data.path.points[STRIDE * (cut.start + (cut.count >> 1))] : 0;
    this.set(middle);
  }

  readouts() {
    this.outputs = this.data.motion.axes.map((axis) => {
      const value = document.createElement("b");
      const cell = document.createElement("span");
      cell.append(`${axis.name} `, value, ` ${axis.unit === "deg" ? "°" : axis.unit}`);
      find("readout").append(cell);
      return value;
    });
    this.speed = document.createElement("b");
    const speed = document.createElement("span");
    speed.append("speed ", this.speed, " mm/min");
    this.limit = document.createElement("b");
    this.swatch = document.createElement("i");
    const limit = document.createElement("span");
    limit.append("limited by ", this.swatch, this.limit);
    find("readout").append(speed, limit);
  }

  set(t) {
    const { motion, path } = this.data;
    this.t = Math.min(Math.max(t, 0), this.end);
    this.slider.value = this.t;
    find("clock").textContent = `${this.t.toFixed(2)} / ${this.end.toFixed(2)} s`;
    this.view.placeTool(toolAt(path, this.t));
    if (!this.charts) return;
    this.charts.setTime(this.t);
    const slot = slotAt(motion, this.t);
    this.outputs.forEach((output, k) => {
      const { min, max } = motion.bands[k].position;
      output.textContent = (0.5 * (min[slot] + max[slot])).toFixed(2);
    });
    this.speed.textContent = number(60 * motion.speed.max[slot]);
    this.limit.textContent = limitName(motion.axes, motion.binding[slot]);
    this.swatch.style.background = limitColour(motion.binding[slot]);
  }

  play(on) {
    this.playing = on;
    find("play").textContent = on ? "❚❚" : "▶";
    if (!on) return;
    if (this.t >= this.end) this.set(0);
    let before = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      this.set(this.t + (Number(find("pace").value) * (now - before)) / 1000);
      before = now;
      if (this.t >= this.end) this.play(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}

/** Time at which the tool was at a point of the surface. */
function timeAt({ path, tools }, point) {
  return path.contacts ? contactTime(path, point) : toolTime(path, tools, point);
}

function picking(view, data, clock) {
  const host = find("view");
  const label = find("picked");
  let grip = null;
  host.addEventListener("pointerdown", (event) => {
    grip = [event.clientX, event.clientY];
  });
  host.addEventListener("click", (event) => {
    // A turn of the view is no pick.
    if (!grip || Math.hypot(event.clientX - grip[0], event.clientY - grip[1]) > 4) return;
    const vertex = view.pick(event.clientX, event.clientY);
    if (vertex === null) {
      label.hidden = true;
      view.mark(null);
      return;
    }
    const point = Array.from(data.surface.positions.subarray(3 * vertex, 3 * vertex + 3));
    view.mark(point);
    describe(label, data, clock, vertex, point);
  });
}

function describe(label, data, clock, vertex, point) {
  const deviation = deviationAt(data.surface, vertex);
  const value = document.createElement("b");
  const share = document.createElement("span");
  if (deviation === undefined) value.textContent = "not measured";
  else if (deviation === null) value.textContent = "not cut";
  else {
    value.textContent = micrometres(deviation);
    const tolerances = Math.abs(inTolerances(deviation, data.budget));
    const kind = deviation < 0 ? "gouge" : "excess";
    share.textContent = ` ${kind}, ${(100 * tolerances).toFixed(0)} % of its tolerance`;
  }
  const where = document.createElement("small");
  where.textContent = `${point.map((x) => x.toFixed(3)).join(", ")} mm`;
  label.replaceChildren(value, share, where);
  const t = clock ? timeAt(data, point) : null;
  if (t !== null) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = `Show the tool here (${t.toFixed(2)} s)`;
    button.addEventListener("click", () => clock.set(t));
    label.append(button);
  }
  label.hidden = false;
}

function places(view, data, clock) {
  for (const button of document.querySelectorAll("[data-place]")) {
    button.addEventListener("click", () => {
      const place = data.check.places[Number(button.dataset.place)];
      if (!place) return;
      const t = clock ? toolTime(data.path, data.tools, place.point) : null;
      if (t !== null) clock.set(t);
      view.mark(place.point, { look: true });
    });
  }
}

start();
