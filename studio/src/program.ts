// The text of a program, of which only the lines in sight are elements.

const ROW = 18;
/** Lines above and below those in sight. */
const MARGIN = 12;

export class ProgramText {
  private lines: string[] = [];
  private current = 0;
  private marks = new Map<number, string>();
  private readonly room = document.createElement("div");
  private waiting = false;

  constructor(
    private readonly host: HTMLElement,
    onLine: (line: number) => void,
  ) {
    this.room.className = "room";
    host.append(this.room);
    host.addEventListener("scroll", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(host);
    host.addEventListener("click", (event) => {
      const row = (event.target as HTMLElement).closest<HTMLElement>("[data-line]");
      if (row) onLine(Number(row.dataset.line));
    });
    host.addEventListener("keydown", (event) => {
      const by = { ArrowDown: 1, ArrowUp: -1, PageDown: 20, PageUp: -20 }[event.key];
      if (!by) return;
      event.preventDefault();
      onLine(Math.min(Math.max(this.current + by, 1), this.lines.length));
    });
  }

  show(text: string): void {
    this.lines = text.replace(/\r?\n$/, "").split(/\r?\n/);
    this.marks.clear();
    this.current = 0;
    this.room.style.height = `${ROW * this.lines.length}px`;
    this.host.scrollTop = 0;
    this.draw();
  }

  /** Lines with a problem, and its words. */
  mark(marks: Map<number, string>): void {
    this.marks = marks;
    this.draw();
  }

  get line(): number {
    return this.current;
  }

  /** Makes a line the current one, and brings it into sight. */
  go(line: number): void {
    if (line === this.current) return;
    this.current = line;
    const [top, height] = [ROW * (line - 1), this.host.clientHeight];
    if (top < this.host.scrollTop + ROW || top > this.host.scrollTop + height - 2 * ROW) {
      this.host.scrollTop = top - 0.4 * height;
    }
    this.draw();
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
    const first = Math.max(Math.floor(this.host.scrollTop / ROW) - MARGIN, 0);
    const last = Math.min(Math.ceil((this.host.scrollTop + this.host.clientHeight) / ROW) + MARGIN, this.lines.length);
    const rows = [];
    for (let at = first; at < last; at += 1) {
      const row = document.createElement("div");
      row.className = "line";
      row.dataset.line = `${at + 1}`;
      row.style.top = `${ROW * at}px`;
      if (at + 1 === this.current) row.setAttribute("aria-current", "true");
      const mark = this.marks.get(at + 1);
      if (mark) {
        row.classList.add("bad");
        row.title = mark;
      }
      const number = document.createElement("span");
      number.textContent = `${at + 1}`;
      row.append(number, this.lines[at] ?? "");
      rows.push(row);
    }
    this.room.replaceChildren(...rows);
  }
}
