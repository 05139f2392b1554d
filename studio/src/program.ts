// The text of a program, of which only the lines in sight are elements; with a second program, the lines of both.

import { Lines } from "./lines";

const ROW = 18;
/** Lines above and below those in sight. */
const MARGIN = 12;

/** Lines of two programs: which line of each a row shows, 0 for none. */
interface Both {
  rows: Int32Array;
  others: Lines;
  /** Rows of the lines of each program. */
  places: [Int32Array, Int32Array];
  /** First rows of the differences. */
  differences: number[];
}

/** Line that was clicked: of the first program, or of the second alone. */
export interface ClickedLine {
  line: number;
  isOther: boolean;
}

export class ProgramText {
  private lines = new Lines(new Uint8Array());
  private both: Both | null = null;
  private current = 0;
  private other = 0;
  private marks = new Map<number, string>();
  /** Part in sight, px. Asking the page in every frame would lay it out each time. */
  private top = 0;
  private height = 0;
  private readonly room = document.createElement("div");
  /** Elements of the rows in sight. One that stays in sight stays the same element: a click begins and ends on it. */
  private readonly shown = new Map<number, HTMLElement>();
  private waiting = false;
  /** The text was opened in this frame, and the page has not got its place in sight yet. */
  private isNew = false;

  constructor(
    private readonly host: HTMLElement,
    onLine: (clicked: ClickedLine) => void,
  ) {
    this.room.className = "room";
    host.append(this.room);
    host.addEventListener("scroll", () => {
      if (!this.isNew) this.top = host.scrollTop;
      this.draw();
    });
    new ResizeObserver(() => {
      this.height = host.clientHeight;
      this.draw();
    }).observe(host);
    host.addEventListener("click", (event) => {
      const row = (event.target as HTMLElement).closest<HTMLElement>(".line");
      const { line, other } = row?.dataset ?? {};
      if (line) onLine({ line: Number(line), isOther: false });
      else if (other) onLine({ line: Number(other), isOther: true });
    });
    host.addEventListener("keydown", (event) => {
      const by = { ArrowDown: 1, ArrowUp: -1, PageDown: 20, PageUp: -20 }[event.key];
      if (!by) return;
      event.preventDefault();
      onLine({ line: Math.min(Math.max(this.current + by, 1), this.lines.count), isOther: false });
    });
  }

  /** Shows the text of a program; returns the number of its lines. */
  show(text: Uint8Array): number {
    this.lines = new Lines(text);
    this.both = null;
    this.marks.clear();
    this.current = 0;
    // With the next frame: to scroll now would lay out the page before that.
    this.isNew = true;
    this.scrollTo(0);
    this.resize();
    return this.lines.count;
  }

  /** Shows the lines of a second program among those of the first; returns the number of lines that one of them has alone. */
  compare(text: Uint8Array, rows: Int32Array): number {
    const others = new Lines(text);
    const places: Both["places"] = [new Int32Array(this.lines.count + 1), new Int32Array(others.count + 1)];
    const differences: number[] = [];
    let [count, wasSame] = [0, true];
    for (let row = 0; 2 * row < rows.length; row += 1) {
      const [line, other] = [rows[2 * row]!, rows[2 * row + 1]!];
      if (line) places[0][line] = row;
      if (other) places[1][other] = row;
      const isSame = line !== 0 && other !== 0;
      if (!isSame) count += 1;
      if (!isSame && wasSame) differences.push(row);
      wasSame = isSame;
    }
    this.both = { rows, others, places, differences };
    this.resize();
    return count;
  }

  /** Shows the first program alone again. */
  alone(): void {
    this.both = null;
    this.resize();
  }

  private resize(): void {
    this.forget();
    this.room.style.height = `${ROW * this.count}px`;
    // The current line stays in sight where others come between.
    if (this.current > 0) this.look(this.rowOf(this.current));
    this.draw();
  }

  private rowOf(line: number): number {
    return this.both ? this.both.places[0][line]! : line - 1;
  }

  private get count(): number {
    return this.both ? this.both.rows.length / 2 : this.lines.count;
  }

  /** Lines with a problem, and its words. */
  mark(marks: Map<number, string>): void {
    this.marks = marks;
    this.forget();
    this.draw();
  }

  get line(): number {
    return this.current;
  }

  /** Makes a line the current one, and brings it into sight. */
  go(line: number): void {
    if (line === this.current) return;
    this.current = line;
    this.look(this.rowOf(line));
    this.draw();
  }

  /** Makes a line of the second program the current one of it. */
  goOther(line: number): void {
    if (line === this.other) return;
    this.other = line;
    this.draw();
  }

  /** Brings the next difference into sight; after the last one the first. Returns what it shows, null without any. */
  nextDifference(): ClickedLine | null {
    if (!this.both || this.both.differences.length === 0) return null;
    const { differences, rows } = this.both;
    // The first one below the upper third, where the last one was put.
    const here = Math.round((this.top + 0.4 * this.height) / ROW);
    const next = differences.find((row) => row > here) ?? differences[0]!;
    this.scrollTo(ROW * next - 0.4 * this.height);
    this.draw();
    const [line, other] = [rows[2 * next]!, rows[2 * next + 1]!];
    return line ? { line, isOther: false } : { line: other, isOther: true };
  }

  private look(row: number): void {
    const top = ROW * row;
    if (top < this.top + ROW || top > this.top + this.height - 2 * ROW) this.scrollTo(top - 0.4 * this.height);
  }

  private scrollTo(top: number): void {
    this.top = Math.min(Math.max(top, 0), Math.max(ROW * this.count - this.height, 0));
    if (!this.isNew) this.host.scrollTop = this.top;
  }

  private draw(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.render();
    });
  }

  private render(): void {
    if (this.isNew) this.host.scrollTop = this.top;
    this.isNew = false;
    const first = Math.max(Math.floor(this.top / ROW) - MARGIN, 0);
    const last = Math.min(Math.ceil((this.top + this.height) / ROW) + MARGIN, this.count);
    for (const [at, row] of this.shown) {
      if (at >= first && at < last) continue;
      row.remove();
      this.shown.delete(at);
    }
    for (let at = first; at < last; at += 1) {
      const row = this.shown.get(at) ?? this.row(at);
      if (!this.shown.has(at)) this.room.insertBefore(row, this.room.children[at - first] ?? null);
      this.shown.set(at, row);
      this.markCurrent(row, at);
    }
  }

  /** What was shown before is no longer what the rows have. */
  private forget(): void {
    this.shown.clear();
    this.room.replaceChildren();
  }

  /** Lines of both programs in a row, 0 for none. */
  private linesIn(at: number): [number, number] {
    const { both } = this;
    return both ? [both.rows[2 * at]!, both.rows[2 * at + 1]!] : [at + 1, 0];
  }

  private markCurrent(row: HTMLElement, at: number): void {
    const [line, other] = this.linesIn(at);
    if (line && line === this.current) row.setAttribute("aria-current", "true");
    else row.removeAttribute("aria-current");
    row.classList.toggle("there", other !== 0 && other === this.other);
  }

  private row(at: number): HTMLElement {
    const { both } = this;
    const [line, other] = this.linesIn(at);
    const row = document.createElement("div");
    row.className = "line";
    row.style.top = `${ROW * at}px`;
    if (line) row.dataset.line = `${line}`;
    else row.dataset.other = `${other}`;
    if (both && !other) row.classList.add("first");
    if (both && !line) row.classList.add("second");
    const mark = line && this.marks.get(line);
    if (mark) {
      row.classList.add("bad");
      row.title = mark;
    }
    const number = document.createElement("span");
    number.textContent = both && !other ? `− ${line}` : both && !line ? `+ ${other}` : `${line}`;
    row.append(number, line ? this.lines.at(line - 1) : both!.others.at(other - 1));
    return row;
  }
}
