// Values in the text of a job: read and written in place, so that comments and order stay.

/** Text of a section, `""` for that before the first one: where it starts and ends. */
function sectionOf(text: string, name: string): [number, number] | null {
  if (name === "") return [0, /^\s*\[/m.exec(text)?.index ?? text.length];
  const opening = new RegExp(`^[ \\t]*\\[${name.replace(".", "\\.")}\\][^\\n]*\\n?`, "m").exec(text);
  if (!opening) return null;
  const start = opening.index + opening[0].length;
  const next = /^[ \t]*\[/m.exec(text.slice(start));
  return [start, next ? start + next.index : text.length];
}

/** `key = value` in a part of a text: where the value starts and ends. */
function valueIn(text: string, key: string, [from, to]: [number, number]): [number, number] | null {
  const found = new RegExp(`^([ \\t]*${key}[ \\t]*=[ \\t]*)(\\[\\s*(?:\\[[^\\]]*\\]\\s*,?\\s*)+\\]|\\[[^\\]]*\\]|"[^"\\n]*"|[^\\s#]+)`, "m").exec(text.slice(from, to));
  if (!found) return null;
  const start = from + found.index + found[1]!.length;
  return [start, start + found[2]!.length];
}

/** Value of a key as it is written; null if there is none. */
export function valueOf(text: string, section: string, key: string): string | null {
  const room = sectionOf(text, section);
  const place = room && valueIn(text, key, room);
  return place ? text.slice(...place) : null;
}

/** Text with another value; a section or key that is missing is added. */
export function withValue(text: string, section: string, key: string, value: string): string {
  const room = sectionOf(text, section);
  if (!room) return `${text.replace(/\n*$/, "\n")}\n[${section}]\n${key} = ${value}\n`;
  const place = valueIn(text, key, room);
  if (place) return text.slice(0, place[0]) + value + text.slice(place[1]);
  return `${text.slice(0, room[0])}${key} = ${value}\n${text.slice(room[0])}`;
}

/** Text without a key and the comment behind it. */
export function withoutKey(text: string, section: string, key: string): string {
  const room = sectionOf(text, section);
  const place = room && valueIn(text, key, room);
  if (!place) return text;
  const start = text.lastIndexOf("\n", place[0]) + 1;
  const end = text.indexOf("\n", place[1]);
  return text.slice(0, start) + (end < 0 ? "" : text.slice(end + 1));
}

/** Keys of a tool by which its shape is given; a tool of a library brings all of them that it needs. */
const SHAPE = [
  "name", "number", "kind", "major_radius", "minor_radius", "diameter", "corner_radius", "tip_radius", "barrel_radius", "taper_angle",
  "length", "construction", "inner_cutting_radius", "shank",
];

/** Section of the tool of a job: that of its first operation where it has operations of their own. */
export const toolSection = (text: string): string => (sectionOf(text, "tool") || !sectionOf(text, "operation.tool") ? "tool" : "operation.tool");

/** Text with another tool in place of the one it has; its holder goes too, because it is measured from the old tip. */
export function withTool(text: string, keys: [string, string][]): string {
  const section = toolSection(text);
  const kept = keys.map(([key]) => key);
  const stripped = [...SHAPE, "holder"].filter((key) => !kept.includes(key)).reduce((of, key) => withoutKey(of, section, key), text);
  // A key that is new is put first: in this order they read as in the library.
  return [...keys].reverse().reduce((of, [key, value]) => withValue(of, section, key, value), stripped);
}

/** Text with a holder on its tool: heights count from the tip, and the upper end is at the gauge point. */
export function withHolder(text: string, profile: [number, number][] | null): string {
  const section = toolSection(text);
  if (!profile) return withoutKey(text, section, "holder");
  const length = Number(valueOf(text, section, "length"));
  const below = length - profile.at(-1)![0];
  const pairs = profile.map(([height, radius]) => `[${Number((below + height).toFixed(6))}, ${radius}]`);
  return withValue(text, section, "holder", `[${pairs.join(", ")}]`);
}

const numbersOf = (value: string): number[] => [...value.matchAll(/\d+/g)].map(Number);

/** Numbers of the faces that a job cuts; null for all. */
export function facesOf(text: string): number[] | null {
  const value = valueOf(text, "part", "faces");
  return value?.startsWith("[") ? numbersOf(value) : null;
}

/** Text that cuts these faces. Operations lose those that are not cut; the first one takes those that are new. */
export function withFaces(text: string, faces: number[]): string {
  const before = facesOf(text);
  const list = (numbers: number[]) => `[${numbers.join(", ")}]`;
  const written = withValue(text, "part", "faces", list(faces));
  let isFirst = true;
  return written.replace(/^([ \t]*\[\[operation\]\][\s\S]*?^[ \t]*faces[ \t]*=[ \t]*)\[([^\]]*)\]/gm, (_, head: string, own: string) => {
    const kept = numbersOf(own).filter((number) => faces.includes(number));
    const added = isFirst ? faces.filter((number) => !before?.includes(number)) : [];
    isFirst = false;
    return head + list([...kept, ...added].sort((a, b) => a - b));
  });
}

const numbersIn = (value: string | null) => (value?.match(/[-+.\deE]+/g) ?? []).map(Number);

/** Three numbers of a job; those that are missing are 0. */
export function threeOf(text: string, section: string, key: string): [number, number, number] {
  const numbers = numbersIn(valueOf(text, section, key));
  return [numbers[0] ?? 0, numbers[1] ?? 0, numbers[2] ?? 0];
}

/** Rotation of the part of a job about x, y and z, in degrees. */
export const rotationOf = (text: string) => threeOf(text, "part", "rotation");

/** File of the part of a job, as the job names it. */
export const partOf = (text: string): string | null => valueOf(text, "part", "file")?.replace(/^"|"$/g, "") ?? null;

/** Faces that a proposal leaves out, in words. */
export const leftOut = (text: string): string[] => [...text.matchAll(/^# not cut: (faces? .*)$/gm)].map(([, words]) => `not cut: ${words}`);
