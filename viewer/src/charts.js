// Charts over time on 2-D canvases. Every slot of time has a least and a largest value, so that a
// chart of any width shows every peak.

import { limitName, limitOf, slotAt } from "./data.js";

/** Distinct also for the colour-blind (Okabe and Ito). */
const HUES = ["#0072b2", "#009e73", "#56b4e9", "#d55e00", "#cc79a7", "#e69f00"];
const FEED_HUE = "#7b8794";

const LEFT = 52;
const RIGHT = 10;
const TOP = 8;
const BOTTOM = 18;

const inkOf = (element, name) => getComputedStyle(element).getPropertyValue(name).trim();

/** Colour of a binding limit: solid for a velocity, paler for an acceleration and again for a jerk. */
export function limitColour(binding) {
  if (binding === 0) return "transparent";
  if (binding === 1) return FEED_HUE;
  const { axis, rate } = limitOf(binding);
  return HUES[axis % HUES.length] + ["", "99", "4d"][rate];
}

/** Round steps, about `count` of them. */
export function ticks(low, high, count) {
  const span = high - low;
  if (!(span > 0) || !Number.isFinite(span)) return [low];
  const raw = span / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= raw) * power;
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, k) => (first + k) * step);
}

export function number(value) {
  const size = Math.abs(value);
  if (size < 0.0005) return "0";
  if (size >= 1000) return value.toFixed(0);
  if (size >= 100) return value.toFixed(1);
  return value.toFixed(size >= 1 ? 2 : 3);
}

const short = (value) => String(Number(value.toPrecision(6)));

function extent(band, scale) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of band.min) if (value < low) low = value;
  for (const value of band.max) if (value > high) high = value;
  return [low * scale, high * scale];
}

/** What is drawn in the cells: title, unit, range, reference lines. */
function cells({ axes, bands, speed, tip, feed }) {
  const all = [];
  if (speed) {
    all.push({
      key: "speed",
      title: "Speed of the programmed point",
      unit: "mm/min",
      hue: FEED_HUE,
      band: speed,
      scale: 60,
      low: 0,
      lines: feed > 0 ? [{ at: 60 * feed, label: "programmed feed" }] : [],
      wide: true,
    });
  }
  all.push({ title: "Speed of the tool tip", unit: "mm/min", hue: FEED_HUE, band: tip, scale: 60, low: 0, lines: [], wide: true });
  axes.forEach((axis, index) => {
    const hue = HUES[index % HUES.length];
    const { position, velocity, acceleration, jerk } = bands[index];
    const ends = axis.travel ? axis.travel.map((at) => ({ at, label: "end of travel" })) : [];
    const share = (limit) => (limit > 0 && Number.isFinite(limit) ? 100 / limit : 1);
    const hundred = [{ at: 100 }, { at: -100 }];
    all.push(
      { title: `${axis.name} position`, unit: axis.unit, hue, band: position, scale: 1, lines: ends, loose: true },
      { title: `${axis.name} velocity`, unit: "% of limit", hue, band: velocity, scale: share(axis.velocity), low: -105, high: 105, lines: hundred, real: [axis.velocity / 100, `${axis.unit}/s`] },
    );
    // The replay of a program knows no accelerations: its controls plan them.
    if (acceleration) {
      all.push({ title: `${axis.name} acceleration`, unit: "% of limit", hue, band: acceleration, scale: share(axis.acceleration), low: -105, high: 105, lines: hundred, real: [axis.acceleration / 100, `${axis.unit}/s²`] });
    }
    if (axis.jerk > 0) {
      all.push({ title: `${axis.name} jerk`, unit: "% of limit", hue, band: jerk, scale: share(axis.jerk), low: -105, high: 105, lines: hundred, real: [axis.jerk / 100, `${axis.unit}/s³`] });
    }
  });
  return all;
}

/** Longest that cells are drawn in one frame [ms]. */
const SLICE = 12;

export class Charts {
  constructor(host, strip, data, onTime) {
    this.motion = data.motion;
    this.onTime = onTime;
    this.window = [0, this.motion.duration];
    this.time = 0;
    host.classList.toggle("four", this.motion.axes.some((axis) => axis.jerk > 0));
    this.cells = cells(this.motion).map((cell) => this.addCell(host, cell));
    if (strip) this.addStrip(strip);
    new ResizeObserver(() => this.draw()).observe(host);
    this.draw();
  }

  addCell(host, cell) {
    const figure = document.createElement("figure");
    figure.className = cell.wide ? "chart wide" : "chart";
    const caption = document.createElement("figcaption");
    const swatch = document.createElement("i");
    swatch.style.background = cell.hue;
    const value = document.createElement("output");
    caption.append(swatch, `${cell.title} `, Object.assign(document.createElement("small"), { textContent: cell.unit }), value);
    const plot = document.createElement("div");
    plot.className = "plot";
    const canvas = document.createElement("canvas");
    const cursor = document.createElement("div");
    cursor.className = "cursor";
    plot.append(canvas, cursor);
    figure.append(caption, plot);
    host.append(figure);
    this.listen(plot);
    return { ...cell, plot, canvas, cursor, value };
  }

  /** The strip of what binds, and how much of the time each limit does. */
  addStrip(strip) {
    const { binding, axes, slots } = this.motion;
    const counts = new Map();
    for (const limit of binding) counts.set(limit, (counts.get(limit) ?? 0) + 1);
    const list = document.createElement("ul");
    [...counts].sort((a, b) => b[1] - a[1]).forEach(([limit, count]) => {
      const item = document.createElement("li");
      const swatch = document.createElement("i");
      swatch.style.background = limitColour(limit);
      const name = limit === 0 ? "no limit reached" : limitName(axes, limit);
      const percent = (100 * count) / slots;
      item.append(swatch, `${name} ${percent < 1 ? "under 1" : percent.toFixed(0)} %`);
      list.append(item);
    });
    const title = document.createElement("h3");
    title.textContent = "Limits that bind the motion";
    const plot = document.createElement("div");
    plot.className = "plot strip";
    this.strip = document.createElement("canvas");
    this.stripCursor = document.createElement("div");
    this.stripCursor.className = "cursor";
    plot.append(this.strip, this.stripCursor);
    strip.append(title, list, plot);
    this.listen(plot);
  }

  listen(plot) {
    const at = (event) => this.timeAt(plot, event.clientX);
    let start = null;
    plot.addEventListener("pointerdown", (event) => {
      start = event.clientX;
      plot.setPointerCapture(event.pointerId);
    });
    plot.addEventListener("pointermove", (event) => {
      if (start === null) this.hover(at(event));
      else this.brush(plot, start, event.clientX);
    });
    plot.addEventListener("pointerup", (event) => {
      const from = start;
      start = null;
      this.brush(plot, 0, 0);
      if (from === null) return;
      if (Math.abs(event.clientX - from) < 5) this.onTime(at(event));
      else this.zoom(this.timeAt(plot, from), at(event));
    });
    plot.addEventListener("pointerleave", () => this.hover(this.time));
    plot.addEventListener("dblclick", () => this.zoom(0, this.motion.duration));
  }

  brush(plot, from, to) {
    let box = plot.querySelector(".brush");
    if (!box) {
      box = Object.assign(document.createElement("div"), { className: "brush" });
      plot.append(box);
    }
    const left = Math.min(from, to) - plot.getBoundingClientRect().left;
    Object.assign(box.style, { left: `${left}px`, width: `${Math.abs(to - from)}px` });
  }

  zoom(from, to) {
    const [low, high] = [Math.min(from, to), Math.max(from, to)];
    // Below a few slots there is nothing more to see.
    if (high - low < (4 * this.motion.duration) / this.motion.slots) return;
    this.window = [low, high];
    this.draw();
  }

  timeAt(plot, clientX) {
    const box = plot.getBoundingClientRect();
    const share = (clientX - box.left - LEFT) / (box.width - LEFT - RIGHT);
    const [low, high] = this.window;
    return low + Math.min(Math.max(share, 0), 1) * (high - low);
  }

  setTime(t) {
    this.time = t;
    const [low, high] = this.window;
    if (t < low || t > high) {
      // Follow the tool with a zoomed window.
      const half = 0.5 * (high - low);
      const start = Math.min(Math.max(t - half, 0), this.motion.duration - 2 * half);
      this.window = [start, start + 2 * half];
      this.draw();
    }
    this.hover(t);
  }

  hover(t) {
    const [low, high] = this.window;
    const share = (t - low) / (high - low || 1);
    const slot = slotAt(this.motion, t);
    const place = (cursor, width) => {
      cursor.style.transform = `translateX(${LEFT + share * (width - LEFT - RIGHT)}px)`;
    };
    for (const cell of this.cells) {
      // The size at the last drawing: to ask for it anew would lay out the page in every frame.
      place(cell.cursor, cell.width ?? cell.plot.clientWidth);
      const [min, max] = [cell.band.min[slot] * cell.scale, cell.band.max[slot] * cell.scale];
      const peak = Math.abs(max) > Math.abs(min) ? max : min;
      const percent = cell.unit.startsWith("%") ? " %" : "";
      const real = cell.real ? ` (${number(peak * cell.real[0])} ${cell.real[1]})` : "";
      cell.value.textContent = `${number(peak)}${percent}${real}`;
    }
    if (this.strip) place(this.stripCursor, this.strip.parentElement.clientWidth);
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.drawFrom(0);
    });
  }

  /** Draws cells from one on; what takes longer than a part of a frame goes on in the next. */
  drawFrom(first) {
    const [start, drawing] = [performance.now(), (this.drawing = {})];
    let next = first;
    do {
      this.drawCell(this.cells[next]);
      next += 1;
    } while (next < this.cells.length && performance.now() - start < SLICE);
    if (next < this.cells.length) {
      // A newer drawing begins again from the first cell.
      requestAnimationFrame(() => this.drawing === drawing && this.drawFrom(next));
      return;
    }
    if (this.strip) this.drawStrip();
    this.hover(this.time);
  }

  prepare(canvas) {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement;
    const dots = Math.max(window.devicePixelRatio || 1, 2);
    Object.assign(canvas, { width: width * dots, height: height * dots });
    const brush = canvas.getContext("2d");
    brush.scale(dots, dots);
    return [brush, width, height];
  }

  drawStrip() {
    const [brush, width, height] = this.prepare(this.strip);
    const { binding, duration, slots } = this.motion;
    const [low, high] = this.window;
    const inner = width - LEFT - RIGHT;
    for (let column = 0; column < inner; column += 1) {
      const [t0, t1] = [column, column + 1].map((x) => low + (x / inner) * (high - low));
      const [from, to] = [Math.floor((t0 / duration) * slots), Math.ceil((t1 / duration) * slots)];
      const counts = new Map();
      for (let slot = from; slot < Math.min(Math.max(to, from + 1), slots); slot += 1) {
        counts.set(binding[slot], (counts.get(binding[slot]) ?? 0) + 1);
      }
      // A column shows what binds in most of it: one of several limits, never a mixture.
      const [limit] = [...counts].sort((a, b) => b[1] - a[1] || a[0] - b[0])[0] ?? [0];
      brush.fillStyle = limitColour(limit);
      brush.fillRect(LEFT + column, 0, 1.05, height);
    }
  }

  range(cell) {
    let [low, high] = extent(cell.band, cell.scale);
    for (const { at } of cell.lines) {
      // An end of travel far away would flatten the curve.
      if (!cell.loose) [low, high] = [Math.min(low, at), Math.max(high, at)];
    }
    const margin = 0.06 * (high - low) || 1;
    low = cell.low === undefined ? low - margin : Math.min(cell.low, low);
    high = cell.high === undefined ? high + margin : Math.max(cell.high, high);
    return [low, high];
  }

  drawCell(cell) {
    const [brush, width, height] = this.prepare(cell.canvas);
    cell.width = width;
    const [low, high] = this.range(cell);
    const y = (value) => TOP + ((high - value) / (high - low)) * (height - TOP - BOTTOM);
    const [start, end] = this.window;
    const x = (t) => LEFT + ((t - start) / (end - start || 1)) * (width - LEFT - RIGHT);
    this.drawGrid(brush, cell, { x, y, low, high, width, height });
    this.drawBand(brush, cell, x, y, width);
    for (const { at, label } of cell.lines) {
      if (at < low || at > high) continue;
      brush.strokeStyle = inkOf(cell.plot, "--limit");
      brush.setLineDash([5, 4]);
      brush.beginPath();
      brush.moveTo(LEFT, y(at));
      brush.lineTo(width - RIGHT, y(at));
      brush.stroke();
      brush.setLineDash([]);
      if (label) {
        brush.fillStyle = inkOf(cell.plot, "--limit");
        brush.textAlign = "right";
        brush.fillText(label, width - RIGHT - 2, y(at) + (y(at) > TOP + 14 ? -4 : 11));
      }
    }
  }

  drawGrid(brush, cell, { x, y, low, high, width, height }) {
    brush.font = `10.5px ${inkOf(cell.plot, "--font")}`;
    brush.lineWidth = 1;
    brush.strokeStyle = inkOf(cell.plot, "--grid");
    brush.fillStyle = inkOf(cell.plot, "--quiet");
    brush.textAlign = "right";
    brush.textBaseline = "alphabetic";
    const steps = cell.unit.startsWith("%") ? [-100, 0, 100] : ticks(low, high, 4);
    for (const value of steps) {
      brush.beginPath();
      brush.moveTo(LEFT, y(value));
      brush.lineTo(width - RIGHT, y(value));
      brush.stroke();
      brush.fillText(short(value), LEFT - 6, y(value) + 3.5);
    }
    const [start, end] = this.window;
    const marks = ticks(start, end, cell.wide ? 12 : 5);
    for (const t of marks) {
      brush.textAlign = x(t) > width - 30 ? "right" : "center";
      brush.fillText(`${short(t)}${t === marks.at(-1) ? " s" : ""}`, x(t), height - 5);
    }
  }

  drawBand(brush, cell, x, y, width) {
    const { duration, slots } = this.motion;
    const [start, end] = this.window;
    const inner = Math.max(Math.round(width - LEFT - RIGHT), 1);
    const [first, last] = [start, end].map((t) => (t / duration) * slots);
    const columns = Math.min(inner, Math.max(Math.ceil(last) - Math.floor(first), 1));
    const points = [];
    for (let column = 0; column < columns; column += 1) {
      const from = Math.floor(first + (column * (last - first)) / columns);
      const to = Math.max(Math.floor(first + ((column + 1) * (last - first)) / columns), from + 1);
      let [least, most] = [Infinity, -Infinity];
      for (let slot = from; slot < Math.min(to, slots); slot += 1) {
        least = Math.min(least, cell.band.min[slot]);
        most = Math.max(most, cell.band.max[slot]);
      }
      if (least > most) continue;
      const t = ((0.5 * (from + to)) / slots) * duration;
      points.push([x(t), y(least * cell.scale), y(most * cell.scale)]);
    }
    if (points.length === 0) return;
    brush.save();
    brush.beginPath();
    brush.rect(LEFT, 0, width - LEFT - RIGHT, 1000);
    brush.clip();
    brush.fillStyle = brush.strokeStyle = cell.hue;
    brush.lineWidth = 1.3;
    brush.lineJoin = "round";
    brush.beginPath();
    points.forEach(([at, , top], k) => (k === 0 ? brush.moveTo(at, top) : brush.lineTo(at, top)));
    for (const [at, bottom] of [...points].reverse()) brush.lineTo(at, bottom);
    brush.closePath();
    brush.globalAlpha = 0.45;
    brush.fill();
    brush.globalAlpha = 1;
    brush.stroke();
    brush.restore();
  }
}
