// Planning: faces of the part, machine, cutter, holder, setup and tolerances. Every control writes the text of the job.

import { find, make } from "./dom";
import { facesOf, rotationOf, threeOf, toolSection, valueOf, withFaces, withHolder, withTool, withValue } from "./jobtext";
import { wordsOfFace } from "./faces";
import type { Placement } from "./frame";
import type { FaceInfo, Library, Machine, PartFaces } from "./messages";
import type { Stage } from "./stage";

interface Control {
  label: string;
  section: string;
  key: string;
  /** Numbers in a list; 1 is a plain number. */
  count: 1 | 3;
}

const CONTROLS: Control[] = [
  { label: "Part rotation, °", section: "part", key: "rotation", count: 3 },
  { label: "Origin, mm", section: "setup", key: "origin", count: 3 },
  { label: "Setup rotation, °", section: "setup", key: "rotation", count: 3 },
  { label: "Excess, mm", section: "tolerance", key: "total", count: 1 },
  { label: "Gouge, mm", section: "tolerance", key: "gouge", count: 1 },
];

/** Choice of a cutter or holder that no library has: the job keeps its own. */
const OWN = "as in the job";
const NO_HOLDER = "none";

const unquoted = (value: string | null) => value?.replace(/^"|"$/g, "") ?? "";

export interface PlannerActions {
  /** Takes the text that a control wrote. */
  onText: (text: string) => void;
  /** Takes the faces that were clicked, and the text with them. */
  onFaces: (faces: number[], text: string) => void;
  /** Shows the faces anew: the job turns the part. */
  onTurned: () => void;
  /** Returns the chain of the machine of the job. */
  machine: (name: string) => Promise<Machine>;
  onRefused: (error: unknown) => void;
}

export class Planner {
  /** Part whose faces are in the picture. */
  private part: PartFaces | null = null;
  /** Rotation in which they are. */
  private turned = [0, 0, 0];
  private stage: Stage | null = null;
  private text = "";
  private readonly fields = new Map<Control, HTMLInputElement[]>();
  private readonly machine = make("select", { id: "choose-machine" });
  private readonly cutter = make("select", { id: "choose-cutter" });
  private readonly holder = make("select", { id: "choose-holder" });
  private readonly drag = make("select", { id: "drag", title: "Show the part on the machine, with a frame to drag" });
  private readonly label = find("hovered");
  private builtIn: string[] = [];
  private libraries: Library[] = [];
  private isPlacing = false;

  constructor(private readonly actions: PlannerActions) {
    const choice = (label: string, field: HTMLSelectElement, onChange: () => void) => {
      field.setAttribute("aria-label", label);
      field.addEventListener("change", onChange);
      find("plan").append(make("div", { className: "row" }, make("span", { textContent: label }), field));
    };
    choice("Machine", this.machine, () => this.write("machine", "file", JSON.stringify(this.machine.value)));
    choice("Cutter", this.cutter, () => this.chooseCutter());
    choice("Holder", this.holder, () => this.chooseHolder());
    for (const control of CONTROLS) find("plan").append(this.row(control));
    this.drag.append(...[["", "not shown"], ["translate", "drag to move"], ["rotate", "drag to turn"]].map(([value, words]) => make("option", { value, textContent: words })));
    choice("On machine", this.drag, () => void this.place());
    const host = find("view");
    host.addEventListener("pointermove", ({ clientX, clientY, buttons }) => buttons === 0 && this.hover(clientX, clientY));
    host.addEventListener("pointerleave", () => this.name(null, 0, 0));
  }

  private row(control: Control): HTMLElement {
    const fields = Array.from({ length: control.count }, (_, at) => {
      const field = make("input", { type: "text", inputMode: "decimal", autocomplete: "off", spellcheck: false });
      field.setAttribute("aria-label", control.count === 3 ? `${control.label} ${"xyz"[at]}` : control.label);
      field.addEventListener("change", () => this.writeFields(control));
      return field;
    });
    this.fields.set(control, fields);
    return make("div", { className: "row" }, make("span", { textContent: control.label }), ...fields);
  }

  // Machine, cutter, holder.

  /** Machines that a job may name without a file. */
  offerMachines(names: string[]): void {
    this.builtIn = names;
    this.offer();
  }

  /** Libraries to choose from: the standard one, and those that are open. */
  offerLibraries(libraries: Library[]): void {
    this.libraries = libraries;
    this.offer();
  }

  private offer(): void {
    const group = (label: string, names: string[], values = names) => {
      const made = make("optgroup", { label });
      made.append(...names.map((name, at) => make("option", { textContent: name, value: values[at] })));
      return names.length > 0 ? [made] : [];
    };
    const own = this.libraries.flatMap(({ name, machines }) => group(name, machines.map((one) => one.name), machines.map(({ file }) => file)));
    this.machine.replaceChildren(...own, ...group("built in", this.builtIn));
    const first = (words: string) => make("option", { textContent: words, value: "" });
    this.cutter.replaceChildren(first(OWN), ...this.libraries.flatMap(({ name, cutters }) => group(name, cutters.map((one) => one.name))));
    const none = make("option", { textContent: NO_HOLDER, value: NO_HOLDER });
    this.holder.replaceChildren(first(OWN), none, ...this.libraries.flatMap(({ name, holders }) => group(name, holders.map((one) => one.name))));
    this.read(this.text);
  }

  private chooseCutter(): void {
    const found = this.libraries.flatMap(({ cutters }) => cutters).find(({ name }) => name === this.cutter.value);
    if (found) this.actions.onText(withTool(this.text, found.keys));
  }

  private chooseHolder(): void {
    const { value } = this.holder;
    const found = this.libraries.flatMap(({ holders }) => holders).find(({ name }) => name === value);
    if (found || value === NO_HOLDER) this.actions.onText(withHolder(this.text, found?.profile ?? null));
  }

  // Fields.

  /** Shows the values of a job. */
  read(text: string): void {
    this.text = text;
    find("plan").hidden = text === "";
    for (const [control, fields] of this.fields) {
      const value = valueOf(text, control.section, control.key);
      const words = control.count === 3 ? (value?.match(/[-+.\deE]+/g) ?? []) : [value ?? ""];
      // A field that is typed in keeps what was typed.
      fields.forEach((field, at) => (field !== document.activeElement || field.value !== words[at]) && (field.value = words[at] ?? ""));
    }
    const machine = unquoted(valueOf(text, "machine", "file"));
    if (machine !== "" && ![...this.machine.options].some(({ value }) => value === machine)) {
      this.machine.prepend(make("option", { textContent: machine, value: machine }));
    }
    this.machine.value = machine;
    this.showTool(text);
    if (this.isPlacing) this.stage?.setPlacement(this.placement());
    this.paint();
    if (this.part && `${rotationOf(text)}` !== `${this.turned}`) this.actions.onTurned();
  }

  /** Names cutter and holder where a library has them as the job does. */
  private showTool(text: string): void {
    const section = toolSection(text);
    const isThere = ([key, value]: [string, string]) => valueOf(text, section, key) === value;
    const cutter = this.libraries.flatMap(({ cutters }) => cutters).find(({ keys }) => keys.every(isThere));
    this.cutter.value = cutter?.name ?? "";
    const written = valueOf(text, section, "holder");
    const holder = this.libraries.flatMap(({ holders }) => holders).find(({ profile }) => valueOf(withHolder(text, profile), section, "holder") === written);
    this.holder.value = written === null ? NO_HOLDER : (holder?.name ?? "");
  }

  private writeFields(control: Control): void {
    // What a job leaves out is 0.
    const words = this.fields.get(control)!.map(({ value }) => value.trim() || (control.count === 3 ? "0" : ""));
    this.write(control.section, control.key, control.count === 1 ? words[0]! : `[${words.join(", ")}]`);
  }

  private write(section: string, key: string, value: string): void {
    this.actions.onText(withValue(this.text, section, key, value));
  }

  // Place on the machine.

  private placement(): Placement {
    const three = (key: string) => threeOf(this.text, "setup", key);
    return { origin: three("origin"), rotation: three("rotation") };
  }

  private async place(): Promise<void> {
    const mode = this.drag.value as "" | "translate" | "rotate";
    if (mode === "") {
      this.isPlacing = false;
      return this.stage?.endPlacing();
    }
    try {
      if (!this.isPlacing) {
        const machine = await this.actions.machine(unquoted(valueOf(this.text, "machine", "file")));
        this.isPlacing = true;
        this.stage?.startPlacing(machine, this.placement(), (at) => this.showPlacement(at), (at) => this.writePlacement(at));
      }
      this.stage?.dragBy(mode);
    } catch (error) {
      this.drag.value = "";
      this.actions.onRefused(error);
    }
  }

  /** Shows a place in the fields while it is dragged. */
  private showPlacement({ origin, rotation }: Placement): void {
    for (const [key, values] of [["origin", origin], ["rotation", rotation]] as const) {
      const [control] = CONTROLS.filter((one) => one.section === "setup" && one.key === key);
      this.fields.get(control!)!.forEach((field, at) => (field.value = String(values[at])));
    }
  }

  private writePlacement(at: Placement): void {
    const before = this.placement();
    let text = this.text;
    for (const key of ["origin", "rotation"] as const) {
      // What did not move stays as it is written.
      if (`${at[key]}` !== `${before[key]}`) text = withValue(text, "setup", key, `[${at[key].join(", ")}]`);
    }
    if (text !== this.text) this.actions.onText(text);
  }

  // Faces.

  /** Shows the faces of a part on a stage of theirs; null where something else is shown. */
  show(part: PartFaces | null, stage: Stage | null): void {
    this.part = part;
    this.turned = rotationOf(this.text);
    this.stage = stage;
    this.isPlacing = false;
    this.drag.value = "";
    this.drag.disabled = stage === null;
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
    this.actions.onFaces(faces, text);
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
