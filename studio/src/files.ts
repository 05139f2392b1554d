// Files that a user opens: what they are, and where a job looks for them.

import type { Files } from "./engine";
import { textOf } from "./report";

export type Kind = "job" | "machine" | "part" | "program" | "other";

/** Largest file that is opened \[bytes\], as on the command line. */
export const LARGEST = 2 ** 30;

const PARTS = /\.(step|stp|stl|json)$/i;
const OTHERS = /\.(tbl|ini)$/i;

export function kindOf(name: string, bytes: Uint8Array): Kind {
  if (/\.toml$/i.test(name)) {
    return /schema\s*=\s*"trunnion-machine\//.test(textOf(bytes.subarray(0, 65536))) ? "machine" : "job";
  }
  if (PARTS.test(name)) return "part";
  return OTHERS.test(name) ? "other" : "program";
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
