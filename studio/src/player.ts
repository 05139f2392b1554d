// The shared time: slider, play, steps by block, readout.

import { find, make } from "./dom";
import { linksOf, type Timeline, type ToolPlace } from "./timeline";

/** Milliseconds between two readings while it plays. Nobody reads faster, and drawing text anew costs more than the picture. */
const READING = 200;

export class Player {
  t = 0;
  private timeline: Timeline | null = null;
  private isPlaying = false;
  private readonly slider = find<HTMLInputElement>("time");
  private readonly pace = find<HTMLSelectElement>("pace");
  private values: HTMLElement[] = [];

  /** `onMotion` gets every place of the tool, `onReading` those at which numbers and text are drawn anew. */
  constructor(
    private readonly onMotion: (tool: ToolPlace, axes: number[] | null) => void,
    private readonly onReading: (tool: ToolPlace) => void,
  ) {
    this.slider.addEventListener("input", () => this.set(Number(this.slider.value)));
    find("play").addEventListener("click", () => this.play(!this.isPlaying));
    find("back").addEventListener("click", () => this.step(-1));
    find("forward").addEventListener("click", () => this.step(1));
    addEventListener("keydown", (event) => this.key(event));
  }

  open(timeline: Timeline | null): void {
    this.play(false);
    this.timeline = timeline && timeline.count > 0 ? timeline : null;
    find("transport").hidden = find("readout").hidden = this.timeline === null;
    if (!this.timeline) return;
    this.slider.max = String(this.timeline.end);
    const machine = this.timeline.moves.machine;
    this.values = (machine ? linksOf(machine).map(({ name, rotary }) => [name, rotary ? "°" : "mm"]) : []).map(([name, unit]) => {
      const value = make("b");
      find("readout").append(make("span", {}, `${name} `, value, ` ${unit}`));
      return value;
    });
    find("readout").replaceChildren(...this.values.map((value) => value.parentElement!));
  }

  set(t: number): void {
    this.move(t);
    this.read();
  }

  private move(t: number): void {
    const { timeline } = this;
    if (!timeline) return;
    this.t = Math.min(Math.max(t, 0), timeline.end);
    this.onMotion(timeline.toolAt(this.t), timeline.axesAt(this.t));
  }

  private read(): void {
    const { timeline } = this;
    if (!timeline) return;
    this.slider.value = String(this.t);
    find("clock").textContent = `${this.t.toFixed(2)} / ${timeline.end.toFixed(2)} s`;
    const axes = timeline.axesAt(this.t);
    const links = timeline.moves.machine ? linksOf(timeline.moves.machine) : [];
    this.values.forEach((value, k) => {
      const unit = links[k]!.rotary ? 180 / Math.PI : 1;
      value.textContent = (axes![k]! * unit).toFixed(3);
    });
    this.onReading(timeline.toolAt(this.t));
  }

  step(by: 1 | -1): void {
    this.play(false);
    if (this.timeline) this.set(this.timeline.step(this.t, by));
  }

  play(on: boolean): void {
    this.isPlaying = on && this.timeline !== null;
    find("play").textContent = this.isPlaying ? "❚❚" : "▶";
    if (!this.isPlaying) return this.read();
    if (this.t >= this.timeline!.end) this.set(0);
    let before = performance.now();
    let reading = before;
    const frame = (now: number) => {
      if (!this.isPlaying || !this.timeline) return;
      this.move(this.t + (Number(this.pace.value) * (now - before)) / 1000);
      before = now;
      if (now - reading >= READING) {
        reading = now;
        this.read();
      }
      if (this.t >= this.timeline.end) this.play(false);
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  /** Space plays, comma and full stop go block by block: not while text is typed. */
  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || target.closest("textarea, input[type=text], select")) return;
    if (event.key === " " && !target.closest("button, input, summary")) this.play(!this.isPlaying);
    else if (event.key === ",") this.step(-1);
    else if (event.key === ".") this.step(1);
    else return;
    event.preventDefault();
  }
}
