// Files that a user opens: what they are, and where a job looks for them.

import { sizeOf } from "./dom";
import type { Files } from "./engine";
import { textOf } from "./report";

export type Kind = "job" | "machine" | "library" | "part" | "program" | "other";

/** Largest file that is opened \[bytes\], as on the command line. */
const LARGEST = 2 ** 30;

/** Memory that an engine in a page can have \[bytes\]. */
const ROOM = 2 ** 32;
/** Memory from which a file is opened only when it was said before \[bytes\]. */
const LARGE = 5e8;

const PARTS = /\.(step|stp|stl|json)$/i;
const OTHERS = /\.(tbl|ini)$/i;

export function kindOf(name: string, bytes: Uint8Array): Kind {
  if (/\.toml$/i.test(name)) {
    const [, kind] = /schema\s*=\s*"trunnion-(\w+)\//.exec(textOf(bytes.subarray(0, 65536))) ?? [];
    return kind === "machine" || kind === "library" ? kind : "job";
  }
  if (PARTS.test(name)) return "part";
  return OTHERS.test(name) ? "other" : "program";
}

/**
 * Memory that opening a file takes, in sizes of the file: a file is asked for by it, never refused. `npm run memory` measured
 * the engine with generated files: programs of 2, 8 and 32 MB took 8.6 times their size, STEP files of 2 and 9 MB 11.6 and
 * 10.8 times. Added are the copies in the page and what the engine hands over, up to 3 times. STL and JSON are estimates
 * without a measurement. A check or run takes more, by the part and not by the file.
 */
const NEED: Record<"step" | "stl" | "json" | "program", number> = { step: 15, stl: 12, json: 12, program: 12 };

/** Memory that opening a file of that name and size takes \[bytes\]. */
function needOf(name: string, size: number): number {
  const ending = name.split(".").at(-1)!.toLowerCase();
  const kind = ending === "stp" ? "step" : ending in NEED ? (ending as keyof typeof NEED) : "program";
  return NEED[kind] * size;
}

/** Says why a file is not even read; null for one that can be tried. */
export function refusalOf(name: string, size: number): string | null {
  return size > LARGEST ? `${name}: has ${size} bytes; at most ${LARGEST} are read` : null;
}

/** Says what a large file will take; null for one of a usual size. */
export function warningOf(name: string, size: number): string | null {
  const need = needOf(name, size);
  if (need < LARGE) return null;
  const rest = need > ROOM ? "It will probably end for want of memory: use the command line." : "It may take minutes.";
  return `${name}: has ${sizeOf(size)}; opening it takes about ${sizeOf(need)} of memory, and a page can have ${sizeOf(ROOM)}. ${rest} Everything else stays open.`;
}

const baseOf = (name: string) => name.split("/").at(-1)!;

/** Path without `.` and `..`. */
export function plain(path: string): string {
  const parts: string[] = [];
  for (const part of path.split("/")) {
    if (part === "..") parts.pop();
    else if (part !== "." && part !== "") parts.push(part);
  }
  return parts.join("/");
}

/**
 * Files that a job names in folders which were not opened, found by their names alone: where the job looks for
 * them, and the name under which they are open.
 */
export function found(files: Files, job: string): Map<string, string> {
  const bytes = files.get(job);
  const folder = job.includes("/") ? job.slice(0, job.lastIndexOf("/")) : "";
  const where = new Map<string, string>();
  for (const [, name] of textOf(bytes ?? new Uint8Array()).matchAll(/^\s*file\s*=\s*"([^"]+)"/gm)) {
    const path = plain(`${folder}/${name}`);
    const open = [...files.keys()].find((other) => baseOf(other) === baseOf(path));
    if (!files.has(path) && open) where.set(path, open);
  }
  return where;
}

/** Divides options at spaces; quotes keep spaces together. */
export const words = (text: string): string[] =>
  [...text.matchAll(/"([^"]*)"|(\S+)/g)].map(([, quoted, plain]) => quoted ?? plain!);
