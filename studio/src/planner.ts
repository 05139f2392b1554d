// Planning: faces of the part, machine, setup and tolerances. Every control writes the text of the job.

import { find, make } from "./dom";
import { facesOf, valueOf, withFaces, withValue } from "./jobtext";
import { wordsOfFace } from "./faces";
import type { FaceInfo, PartFaces } from "./messages";
import type { Stage } from "./stage";

interface Control {
  label: string;
  section: string;
  key: string;
  /** Numbers in a list; 1 is a plain number, 0 a choice. */
  count: 0 | 1 | 3;
}

const CONTROLS: Control[] = [
  { label: "Machine", section: "machine", key: "file", count: 0 },
  { label: "Origin, mm", section: "setup", key: "origin", count: 3 },
  { label: "Rotation, °", section: "setup", key: "rotation", count: 3 },
  { label: "Excess, mm", section: "tolerance", key: "total", count: 1 },
  { label: "Gouge, mm", section: "tolerance", key: "gouge", count: 1 },
];

export class Planner {
  /** Part whose faces are in the picture. */
  private part: PartFaces | null = null;
  private stage: Stage | null = null;
  private text = "";
  private readonly fields = new Map<Control, (HTMLInputElement | HTMLSelectElement)[]>();
  private readonly label = find("hovered");

  /** `onText` gets the text that a control wrote; `onFaces` the faces that were clicked, and that text. */
  constructor(
    private readonly onText: (text: string) => void,
    private readonly onFaces: (faces: number[], text: string) => void,
  ) {
    for (const control of CONTROLS) find("plan").append(this.row(control));
    const host = find("view");
    host.addEventListener("pointermove", ({ clientX, clientY, buttons }) => buttons === 0 && this.hover(clientX, clientY));
    host.addEventListener("pointerleave", () => this.name(null, 0, 0));
  }

  private row(control: Control): HTMLElement {
    const make1 = () =>
      control.count === 0
        ? make("select", { id: "choose-machine" })
        : make("input", { type: "text", inputMode: "decimal", autocomplete: "off", spellcheck: false });
    const fields = Array.from({ length: Math.max(control.count, 1) }, make1);
    fields.forEach((field, at) => {
      field.setAttribute("aria-label", control.count === 3 ? `${control.label} ${"xyz"[at]}` : control.label);
      field.addEventListener("change", () => this.write(control));
    });
    this.fields.set(control, fields);
    return make("div", { className: "row" }, make("span", { textContent: control.label }), ...fields);
  }

  /** Machines that a job may name. */
  offer(machines: string[]): void {
    const [control] = CONTROLS;
    const choice = this.fields.get(control!)![0] as HTMLSelectElement;
    choice.replaceChildren(...machines.map((name) => make("option", { textContent: name, value: name })));
    this.read(this.text);
  }

  /** Shows the values of a job. */
  read(text: string): void {
    this.text = text;
    find("plan").hidden = text === "";
    for (const [control, fields] of this.fields) {
      const value = valueOf(text, control.section, control.key);
      const words = control.count === 3 ? (value?.match(/[-+.\deE]+/g) ?? []) : [value?.replace(/^"|"$/g, "") ?? ""];
      fields.forEach((field, at) => {
        const word = words[at] ?? "";
        if (field instanceof HTMLSelectElement && word !== "" && ![...field.options].some((option) => option.value === word)) {
          field.prepend(make("option", { textContent: word, value: word }));
        }
        // A field that is typed in keeps what was typed.
        if (field !== document.activeElement || field.value !== word) field.value = word;
      });
    }
    this.paint();
  }

  private write(control: Control): void {
    const words = this.fields.get(control)!.map(({ value }) => value.trim());
    const value = control.count === 0 ? JSON.stringify(words[0]) : control.count === 1 ? words[0]! : `[${words.join(", ")}]`;
    this.onText(withValue(this.text, control.section, control.key, value));
  }

  // Faces.

  /** Shows the faces of a part on a stage of theirs; null where something else is shown. */
  show(part: PartFaces | null, stage: Stage | null): void {
    this.part = part;
    this.stage = stage;
    if (part) {
      stage?.showFaces(part);
      const words = "Click faces: blue ones are cut. Hovering names them.";
      find("legend").replaceChildren(make("p", { className: "hint", textContent: words }));
    }
    this.name(null, 0, 0);
    this.paint();
  }

  get isPicking(): boolean {
    return this.part !== null;
  }

  private picked(): number[] {
    return facesOf(this.text) ?? this.part?.faces.map(({ number }) => number) ?? [];
  }

  private paint(): void {
    if (this.part) this.stage?.pickFaces(this.picked());
  }

  /** Takes the face under a point of the screen into the job, or out of it. */
  click(clientX: number, clientY: number): void {
    const face = this.stage?.faceAt(clientX, clientY);
    if (!face) return;
    const before = this.picked();
    const faces = before.includes(face.number) ? before.filter((number) => number !== face.number) : [...before, face.number];
    faces.sort((a, b) => a - b);
    const text = withFaces(this.text, faces);
    this.read(text);
    this.onFaces(faces, text);
  }

  private hover(clientX: number, clientY: number): void {
    if (!this.part || !this.stage) return;
    const face = this.stage.faceAt(clientX, clientY);
    this.stage.hoverFace(face);
    this.name(face, clientX, clientY);
  }

  private name(face: FaceInfo | null, clientX: number, clientY: number): void {
    this.label.hidden = face === null;
    if (!face) return this.stage?.hoverFace(null);
    const box = find("room").getBoundingClientRect();
    this.label.textContent = `${wordsOfFace(face)} (${this.picked().includes(face.number) ? "is cut" : "is not cut"})`;
    this.label.style.left = `${Math.min(clientX - box.left + 14, box.width - this.label.offsetWidth - 8)}px`;
    this.label.style.top = `${clientY - box.top + 14}px`;
  }
}
