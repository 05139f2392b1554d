// A text field with line numbers, and faults at their lines.

export interface Fault {
  line: number;
  column: number;
  message: string;
}

const ROW = 18;

export class Editor {
  private readonly area: HTMLTextAreaElement;
  private readonly gutter: HTMLElement;
  private faults: Fault[] = [];

  constructor(host: HTMLElement, onEdit: (text: string) => void) {
    this.area = host.querySelector("textarea")!;
    this.gutter = host.querySelector(".gutter")!;
    this.area.addEventListener("input", () => {
      this.number();
      onEdit(this.area.value);
    });
    this.area.addEventListener("scroll", () => {
      this.gutter.style.transform = `translateY(${-this.area.scrollTop}px)`;
    });
  }

  get text(): string {
    return this.area.value;
  }

  show(text: string): void {
    this.area.value = text;
    this.area.scrollTop = 0;
    this.faults = [];
    this.number();
  }

  mark(faults: Fault[]): void {
    this.faults = faults;
    this.number();
  }

  /** Puts the cursor where a fault is. */
  go({ line, column }: Fault): void {
    const before = this.area.value.split("\n").slice(0, line - 1);
    const at = before.reduce((sum, text) => sum + text.length + 1, 0) + column - 1;
    this.area.focus();
    this.area.setSelectionRange(at, at);
    this.area.scrollTop = ROW * (line - 1) - 0.4 * this.area.clientHeight;
  }

  private number(): void {
    const count = this.area.value.split("\n").length;
    const rows = Array.from({ length: count }, (_, at) => {
      const row = document.createElement("div");
      row.textContent = `${at + 1}`;
      const here = this.faults.filter(({ line }) => line === at + 1);
      if (here.length > 0) {
        row.className = "bad";
        row.title = here.map(({ message }) => message).join("\n");
      }
      return row;
    });
    this.gutter.replaceChildren(...rows);
  }
}

/** Reads `name:line:column: message`; null for a message about something else. */
export function faultOf(message: string, name: string): Fault | null {
  if (!message.startsWith(`${name}:`)) return null;
  const found = /^(\d+):(\d+): ([\s\S]*)$/.exec(message.slice(name.length + 1));
  return found && { line: Number(found[1]), column: Number(found[2]), message: found[3]! };
}
