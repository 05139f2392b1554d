// Legend, layers and histogram: the small things beside the picture.

import { REACH, UNCUT_COLOUR, colourOf, css, inTolerances, micrometres } from "./colour.js";
import { ticks } from "./charts.js";

const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};

/** Micrometres with three digits at most: names of marks stand close to each other. */
const shortMicrometres = (mm) => String(Number((1000 * mm).toPrecision(3)));

export function legend(host, { budget, surface }) {
  if (surface.deviation.length === 0) {
    host.append(make("p", { className: "hint", textContent: "Nothing was measured on this surface." }));
    return;
  }
  const steps = 200;
  const stops = Array.from({ length: steps }, (_, k) => {
    const colour = css(colourOf(REACH * ((2 * (k + 0.5)) / steps - 1)));
    return `${colour} ${(100 * k) / steps}% ${(100 * (k + 1)) / steps}%`;
  });
  const bar = make("div", { className: "scale" });
  bar.style.background = `linear-gradient(to right, ${stops.join(",")})`;
  const marks = make("div", { className: "marks" });
  for (const [value, mm] of [
    [-2, -2 * budget.gouge],
    [-1, -budget.gouge],
    [0, 0],
    [1, budget.total],
    [2, 2 * budget.total],
  ]) {
    const mark = make("span", { textContent: shortMicrometres(mm) });
    if (Math.abs(value) === 1) mark.className = "limit";
    mark.style.left = `${50 + (50 * value) / REACH}%`;
    marks.append(mark);
  }
  const words = make("div", { className: "words" });
  for (const [text, at] of [["gouge", 12], ["within tolerance", 50], ["excess", 88]]) {
    const word = make("span", { textContent: text });
    word.style.left = `${at}%`;
    words.append(word);
  }
  const swatch = make("i");
  swatch.style.background = css(UNCUT_COLOUR);
  const uncut = make("p", { className: "hint" }, swatch, " not cut");
  host.append(make("h3", { textContent: "Deviation, µm" }), words, bar, marks, uncut);
}

/** Check boxes and directions of view. */
export function layers(host, view, { path, tools, fixtures }) {
  const has = (kinds) => path.pieces.some(({ kind }) => kinds.includes(kind));
  const list = [
    ["surface", "Surface", true, true],
    ["contact", "Passes (cutter contact)", true, path.contacts && has(["cut"])],
    ["tip", "Passes (tool tip)", !path.contacts, has(["cut"])],
    ["leads", "Lead-in and lead-out", true, has(["leadin", "leadout"])],
    ["links", "Links", false, has(["link"])],
    ["fixtures", "Fixtures", true, Boolean(fixtures)],
    ["tool", "Tool", true, tools.some((outline) => outline.length > 1) && path.count > 0],
  ];
  for (const [key, text, shown, exists] of list) {
    view.show(key, shown && exists);
    if (!exists) continue;
    const box = make("input", { type: "checkbox", checked: shown });
    box.addEventListener("change", () => view.show(key, box.checked));
    host.append(make("label", {}, box, ` ${text}`));
  }
  const buttons = make("div", { className: "looks" });
  for (const [text, direction] of [
    ["Reset", [-0.75, -1.15, 0.95]],
    ["Top", [0, -0.0001, 1]],
    ["Front", [0, -1, 0]],
    ["Side", [1, 0, 0]],
  ]) {
    const button = make("button", { type: "button", textContent: text });
    button.addEventListener("click", () => view.fit(direction));
    buttons.append(button);
  }
  host.append(buttons);
}

/** Counts per deviation, on a logarithmic scale: a few gouges must show beside many good points. */
export function histogram(host, { check, budget }) {
  const { start, width, counts } = check.histogram;
  const most = Math.max(0, ...counts);
  if (most === 0) {
    host.append(make("p", { className: "hint", textContent: "Nothing was measured." }));
    return;
  }
  const [W, H, L, B, T] = [520, 190, 46, 34, 10];
  const end = start + width * counts.length;
  const x = (mm) => L + ((mm - start) / (end - start)) * (W - L - 8);
  const tall = (count) => (count === 0 ? 0 : (0.06 + 0.94 * (Math.log10(count) / Math.max(Math.log10(most), 1))) * (H - B - T));
  const parts = [];
  for (let power = 0; 10 ** power <= most; power += 1) {
    const y = H - B - tall(10 ** power);
    parts.push(`<line class="grid" x1="${L}" x2="${W - 8}" y1="${y}" y2="${y}"/>`);
    parts.push(`<text class="end" x="${L - 5}" y="${y + 3.5}">${(10 ** power).toLocaleString("en")}</text>`);
  }
  counts.forEach((count, k) => {
    const from = start + k * width;
    const high = tall(count);
    const colour = css(colourOf(inTolerances(from + 0.5 * width, budget)));
    const [at, wide] = [x(from), x(from + width) - x(from)];
    const words = `${micrometres(from)} to ${micrometres(from + width)}: ${count.toLocaleString("en")}`;
    parts.push(`<rect x="${at}" y="${H - B - high}" width="${Math.max(wide - 0.6, 0.6)}" height="${high}" fill="${colour}"><title>${words}</title></rect>`);
  });
  for (const [mm, label] of [[-budget.gouge, "gouge tol."], [budget.total, "tolerance"]]) {
    if (mm < start || mm > end || mm === 0) continue;
    const side = mm < 0 ? "end" : "start";
    parts.push(`<line class="limit" x1="${x(mm)}" x2="${x(mm)}" y1="${T}" y2="${H - B}"/>`);
    parts.push(`<text class="limit ${side}" x="${x(mm) + (mm < 0 ? -4 : 4)}" y="${T + 9}">${label}</text>`);
  }
  for (const um of ticks(1000 * start, 1000 * end, 6)) {
    parts.push(`<text class="middle" x="${x(um / 1000)}" y="${H - B + 14}">${Number(um.toPrecision(4))}</text>`);
  }
  parts.push(`<text class="middle" x="${0.5 * (L + W)}" y="${H - 4}">deviation, µm (points, logarithmic)</text>`);
  parts.push(`<line class="axis" x1="${L}" x2="${W - 8}" y1="${H - B}" y2="${H - B}"/>`);
  host.innerHTML = `<svg viewBox="0 0 ${W} ${H}" role="img" aria-label="Histogram of deviations">${parts.join("")}</svg>`;
}
