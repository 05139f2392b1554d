// Two programs side by side: their figures with differences, and which time of one belongs to a time of the other.

import { find, make } from "./dom";
import type { Outputs } from "./messages";
import { Lines } from "./lines";
import { summaryOf } from "./report";
import type { Timeline } from "./timeline";

/** Program with what is known of it. */
export interface Side {
  /** Name of the program, and of its job or options where they differ. */
  name: string;
  /** File of the program. */
  program: string;
  text: Uint8Array<ArrayBuffer>;
  timeline: Timeline;
  outputs: Outputs;
}

/** Figures of one program; null where they are unknown. */
interface Figures {
  passed: boolean | null;
  findings: number | null;
  seconds: number | null;
  bound: number | null;
  passes: number | null;
  /** Paths with feed between rapid moves. */
  cuts: number;
  /** Lengths with feed and in rapid moves. */
  cutLength: number;
  rapidLength: number;
  gouge: number | null;
  excess: number | null;
  uncut: number | null;
  lines: number;
}

interface Row {
  name: string;
  of: (figures: Figures) => number | null;
  unit: string;
  digits: number;
  /** True if less is better; null if neither is. */
  less: boolean | null;
}

const ROWS: Row[] = [
  { name: "Time", of: ({ seconds }) => seconds, unit: "s", digits: 2, less: true },
  { name: "Least time of the axes", of: ({ bound }) => bound, unit: "s", digits: 2, less: null },
  { name: "Passes", of: ({ passes }) => passes, unit: "", digits: 0, less: null },
  { name: "Cuts between rapid moves", of: ({ cuts }) => cuts, unit: "", digits: 0, less: null },
  { name: "Path with feed", of: ({ cutLength }) => cutLength, unit: "mm", digits: 0, less: true },
  { name: "Rapid moves", of: ({ rapidLength }) => rapidLength, unit: "mm", digits: 0, less: true },
  { name: "Deepest gouge", of: ({ gouge }) => gouge && 1000 * gouge, unit: "µm", digits: 2, less: true },
  { name: "Largest excess", of: ({ excess }) => excess && 1000 * excess, unit: "µm", digits: 2, less: true },
  { name: "Not cut", of: ({ uncut }) => uncut, unit: "points", digits: 0, less: true },
  { name: "Findings", of: ({ findings }) => findings, unit: "", digits: 0, less: true },
  { name: "Lines", of: ({ lines }) => lines, unit: "", digits: 0, less: null },
];

interface CheckedFigures {
  gouge: number;
  excess: number;
  uncut: number;
}

interface AnySummary {
  passed: boolean;
  failures: string[];
  times: { planned: number; certified_bound: number | null } | null;
  cover?: { passes: number };
  deviation?: CheckedFigures | null;
  programs?: { dialect: string; file: string; same_as?: string; check?: CheckedFigures }[];
}

/** Check of a program: that of a check's summary, or that of the program in a run's. */
function checkOf({ deviation, programs = [] }: AnySummary, program: string): CheckedFigures | null {
  const own = programs.find(({ file }) => program.endsWith(`/${file}`));
  const checked = own?.same_as ? programs.find(({ dialect }) => dialect === own.same_as) : own;
  return deviation ?? checked?.check ?? null;
}

function figuresOf({ program, outputs, timeline, text }: Side): Figures {
  const summary = summaryOf(outputs) as unknown as AnySummary | null;
  const check = summary && checkOf(summary, program);
  const [cutLength, rapidLength] = timeline.lengths();
  return {
    passed: summary?.passed ?? null,
    findings: summary?.failures.length ?? null,
    seconds: summary?.times?.planned ?? (timeline.end > 0 ? timeline.end : null),
    bound: summary?.times?.certified_bound ?? null,
    passes: summary?.cover?.passes ?? null,
    cuts: timeline.countCuts(),
    cutLength,
    rapidLength,
    // Depths are below the surface, whatever their sign.
    gouge: check && Math.abs(check.gouge),
    excess: check && Math.abs(check.excess),
    uncut: check && check.uncut,
    lines: new Lines(text).count,
  };
}

/** Table of both, with the difference of the second from the first: an arrow and words say better or worse, not a colour alone. */
export function comparisonTable(first: Side, second: Side): HTMLElement {
  const [a, b] = [figuresOf(first), figuresOf(second)];
  const head = make("tr", {}, make("th"), swatch("first", "A"), swatch("second", "B"), make("th", { textContent: "B − A" }));
  const verdict = (passed: boolean | null) => make("td", { textContent: passed === null ? "–" : passed ? "✓ kept" : "✗ not kept", className: passed === null ? "" : passed ? "good" : "bad" });
  const kept = make("tr", {}, make("th", { textContent: "Tolerances, limits" }), verdict(a.passed), verdict(b.passed), make("td"));
  // What neither knows is no line.
  const rows = ROWS.filter((row) => row.of(a) !== null || row.of(b) !== null).map((row) => rowOf(row, row.of(a), row.of(b)));
  return make("table", { className: "comparison" }, make("thead", {}, head), make("tbody", {}, kept, ...rows));
}

function swatch(side: string, name: string): HTMLElement {
  return make("th", {}, make("i", { className: side }), name);
}

function rowOf({ name, unit, digits, less }: Row, a: number | null, b: number | null): HTMLElement {
  const words = (value: number | null) => (value === null ? "–" : `${value.toFixed(digits)}`);
  const cell = make("td");
  if (a !== null && b !== null) {
    const by = b - a;
    const shown = by.toFixed(digits);
    const isSame = Number(shown) === 0;
    const sign = by > 0 ? "+" : "−";
    cell.textContent = isSame ? "=" : `${sign}${shown.replace("-", "")}`;
    const share = a !== 0 && !isSame ? [`${sign}${Number(Math.abs((100 * by) / a).toPrecision(2))} %`] : [];
    const isBetter = by < 0 === less;
    const isJudged = less !== null && !isSame;
    if (isJudged) cell.className = isBetter ? "good" : "bad";
    const notes = [...share, ...(isJudged ? [isBetter ? "better" : "worse"] : [])];
    if (notes.length > 0) cell.append(make("small", { textContent: notes.join(", ") }));
  }
  return make("tr", {}, make("th", { textContent: unit ? `${name}, ${unit}` : name }), make("td", { textContent: words(a) }), make("td", { textContent: words(b) }), cell);
}

/** Time of the second program that belongs to a time of the first. */
export function timeThere(t: number, first: Timeline, second: Timeline, sync: string): number {
  if (sync === "time" || first.end <= 0) return Math.min(t, second.end);
  return sync === "path" ? second.timeAtCut(first.cutAt(t)) : (t / first.end) * second.end;
}

/** Farthest that ends of moves are apart which count as the same, mm: half the last digit of most programs. */
const SAME = 5e-5;

/** Ends of the drawn lines of two paths with feed, where both are the same and where they differ. */
export interface ComparedPaths {
  shared: Float32Array;
  first: Float32Array;
  second: Float32Array;
}

/** Compares two paths move by move; `rows` has the lines that belong together. */
export function comparePaths(first: Timeline, second: Timeline, rows: Int32Array): ComparedPaths {
  const [a, b] = [first.pointsOfLines(), second.pointsOfLines()];
  const [same, there] = [new Set<number>(), new Set<number>()];
  for (let at = 0; at < rows.length; at += 2) {
    const [line, other] = [rows[at]!, rows[at + 1]!];
    const [here, beside] = [a.get(line), b.get(other)];
    if (!here || !beside) continue;
    if ([0, 1].some((end) => distance(first.tipAt(here[end]!), second.tipAt(beside[end]!)) > SAME)) continue;
    same.add(line);
    there.add(other);
  }
  return {
    shared: first.cutLines((line) => same.has(line)),
    first: first.cutLines((line) => !same.has(line)),
    second: second.cutLines((line) => !there.has(line)),
  };
}

const distance = (p: number[], q: number[]) => Math.hypot(...p.map((x, k) => x - q[k]!));

/** What a user chose to compare with. */
export interface Choice {
  /** Program or job among the open files. */
  name: string;
  options: string;
}

/** Dialog that asks for the second program; `open` takes further files and returns the names that can be chosen. */
export class CompareDialog {
  private readonly dialog = find<HTMLDialogElement>("compare-dialog");
  private readonly choice = find<HTMLSelectElement>("second-choice");
  private readonly options = find<HTMLInputElement>("second-options");
  private answer: ((choice: Choice | null) => void) | null = null;

  constructor(open: (files: File[]) => Promise<{ names: string[]; last: string | null }>, private readonly isJob: (name: string) => boolean) {
    const chooser = find<HTMLInputElement>("second-chooser");
    find("second-open").addEventListener("click", () => chooser.click());
    chooser.addEventListener("change", async () => {
      const { names, last } = await open([...(chooser.files ?? [])]);
      chooser.value = "";
      this.offer(names, last);
    });
    this.choice.addEventListener("change", () => this.show());
    find("compare-go").addEventListener("click", () => this.close({ name: this.choice.value, options: this.options.value }));
    find("compare-cancel").addEventListener("click", () => this.close(null));
    this.dialog.addEventListener("cancel", () => this.close(null));
  }

  /** Asks; null if the dialog was closed. */
  ask(names: string[], options: string): Promise<Choice | null> {
    this.options.value = options;
    this.offer(names, null);
    this.dialog.showModal();
    return new Promise((resolve) => (this.answer = resolve));
  }

  private offer(names: string[], chosen: string | null): void {
    this.choice.replaceChildren(...names.map((name) => make("option", { textContent: this.isJob(name) ? `${name} (run)` : name, value: name })));
    if (chosen && names.includes(chosen)) this.choice.value = chosen;
    this.show();
  }

  /** A job has its own options. */
  private show(): void {
    find("second-check").hidden = this.isJob(this.choice.value);
    find<HTMLButtonElement>("compare-go").disabled = this.choice.value === "";
  }

  private close(choice: Choice | null): void {
    this.dialog.close();
    this.answer?.(choice);
    this.answer = null;
  }
}
