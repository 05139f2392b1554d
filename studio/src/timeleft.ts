// Time that a stage of long work still needs, from the share of it that is done.

/** Share of a stage below which nothing can be said \[-\], and time \[ms\]. */
const ENOUGH = { share: 0.02, time: 1000 };

export class TimeLeft {
  private stage = "";
  private start = 0;

  constructor(private readonly now: () => number = () => performance.now()) {}

  /** Words for the rest of a stage: empty while it is too early, and for a rest of less than a second. */
  words(stage: string, share: number): string {
    if (stage !== this.stage) {
      this.stage = stage;
      this.start = this.now();
    }
    const passed = this.now() - this.start;
    if (share < ENOUGH.share || passed < ENOUGH.time) return "";
    const seconds = (passed * (1 - share)) / share / 1000;
    if (seconds < 1) return "";
    return seconds < 90 ? `, ${seconds.toFixed(0)} s left` : `, ${(seconds / 60).toFixed(0)} min left`;
  }
}
