// Stock in the picture: an engine of its own that cuts it, its switch, and the words about both.

import { find, make } from "./dom";
import { EngineClient, type Files, Refused } from "./engine";
import type { StockInfo } from "./messages";
import type { Stage } from "./stage";
import { StockFollower, StockSurface } from "./stock";

/** Distance of the rays where the size of the stock allows it, mm. */
const CELL = 0.5;

export class StockView {
  /** Switch among those of the other layers, and the words about what it switches. */
  readonly elements: HTMLElement[];
  private readonly box = make("input", { type: "checkbox", checked: true });
  private readonly words = make("small", { hidden: true });
  private readonly behind = find("behind");
  private follower: StockFollower | null = null;
  private engine: EngineClient | null = null;
  private isEnded = false;

  /** `time` tells the time of the slider, s. Nothing is done before a time is sought. */
  constructor(
    private readonly stage: Stage,
    private readonly files: Files,
    private readonly options: string[],
    private readonly time: () => number,
  ) {
    const title = "The material as it is cut until the time of the slider";
    this.elements = [make("label", { className: "stock", title }, this.box, " Stock"), this.words];
    this.box.addEventListener("change", () => this.apply());
  }

  /** Shows the stock of a time, s, where it is switched on. */
  seek(time: number): void {
    if (this.isEnded || !this.box.checked) return;
    if (this.follower) this.follower.seek(time);
    else if (!this.engine) void this.begin();
  }

  show(shown: boolean): void {
    this.box.checked = shown;
    this.apply();
  }

  /** Frees the memory of the stock. */
  end(): void {
    this.isEnded = true;
    this.behind.hidden = true;
    this.follower?.end();
    this.engine?.end();
  }

  private apply(): void {
    this.stage.showStock(this.box.checked);
    if (!this.box.checked) this.behind.hidden = true;
    else this.seek(this.time());
  }

  /** Starts an engine: that of the page stays free, and what this one takes is free again with it. */
  private async begin(): Promise<void> {
    const engine = (this.engine = new EngineClient());
    this.say("the stock is being prepared");
    for (const [name, bytes] of this.files) engine.insert(name, bytes);
    try {
      const stock = await engine.stock(this.options, CELL);
      if (this.isEnded) return;
      if (!stock) return this.give("nothing names it");
      this.describe(describe(stock));
      this.stage.setStock(new StockSurface(stock.cell));
      this.stage.showStock(this.box.checked);
      this.follower = new StockFollower({
        cut: (time) => engine.cut(time),
        draw: (bricks) => this.stage.changeStock(bricks),
        onBehind: (isBehind) => this.say(isBehind && this.box.checked ? "the stock is being cut" : ""),
        onRefused: (error) => this.refuse(error),
      });
      this.follower.seek(this.time());
    } catch (error) {
      if (!this.isEnded) this.refuse(error);
    }
  }

  private refuse(error: unknown): void {
    this.give(error instanceof Refused ? error.messages[0]!.split("\n")[0]! : String(error));
  }

  /** Takes the stock away for good, and says why. */
  private give(why: string): void {
    this.end();
    this.stage.setStock(null);
    this.box.checked = false;
    this.box.disabled = true;
    this.describe(`no stock: ${why}`);
  }

  private describe(words: string): void {
    this.words.textContent = words;
    this.words.hidden = false;
  }

  private say(words: string): void {
    this.behind.textContent = words;
    this.behind.hidden = words === "";
  }
}

/** Origin of the stock and the distance of its rays, in one line. */
function describe({ cell, is_stated }: StockInfo): string {
  const size = `${cell.toFixed(2)} mm${cell > 1.01 * CELL ? ", coarse" : ""}`;
  return is_stated ? `stock: cells of ${size}` : `stock: box of the part, cells of ${size}`;
}
