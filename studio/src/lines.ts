// Lines of a text as its bytes have them: a long program is never one string, and only the lines in sight are decoded.

const [NEWLINE, RETURN] = [10, 13];

export class Lines {
  /** Number of lines; an end of line at the end begins no further one. */
  readonly count: number;
  /** First byte of every line, and one after the last line and its end. */
  private readonly starts: Uint32Array;
  private readonly decoder = new TextDecoder();

  constructor(private readonly bytes: Uint8Array) {
    let count = 1;
    for (let at = bytes.indexOf(NEWLINE); at >= 0; at = bytes.indexOf(NEWLINE, at + 1)) count += 1;
    const starts = new Uint32Array(count + 1);
    for (let line = 1; line < count; line += 1) starts[line] = bytes.indexOf(NEWLINE, starts[line - 1]) + 1;
    starts[count] = bytes.length + 1;
    // What follows the last end of line is a line of its own only if it has letters.
    const isEnded = count > 1 && starts[count - 1] === bytes.length;
    this.count = isEnded ? count - 1 : count;
    this.starts = starts;
  }

  /** Text of a line, counted from 0, without its end. */
  at(line: number): string {
    const [from, next] = [this.starts[line]!, this.starts[line + 1]!];
    const end = next - 1 > from && next - 1 < this.bytes.length && this.bytes[next - 2] === RETURN ? next - 2 : next - 1;
    return this.decoder.decode(this.bytes.subarray(from, end));
  }
}
