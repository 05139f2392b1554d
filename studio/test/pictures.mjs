// Pictures of the page, kept and compared with the committed ones.

import assert from "node:assert/strict";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { drawn } from "./studio.mjs";

const here = (name) => new URL(name, import.meta.url).pathname;
const kept = here("pictures");
const expected = here("expected");
mkdirSync(kept, { recursive: true });
mkdirSync(expected, { recursive: true });

/** Committed pictures have one pixel for so many by so many: edges of letters differ from browser to browser. */
const COARSE = 4;
/** Colours may differ by so much of 255. */
const NEAR = 24;
/** Share of the coarse pixels that may differ more. */
const SHARE = 0.01;

/** Runs in the page: pictures are decoded there. */
async function reduceAndCompare({ shot, before, coarse, near }) {
  const decode = async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    return createImageBitmap(new Blob([bytes], { type: "image/png" }));
  };
  const draw = (image, width, height) => {
    const canvas = Object.assign(document.createElement("canvas"), { width, height });
    const brush = canvas.getContext("2d", { willReadFrequently: true });
    brush.imageSmoothingQuality = "high";
    brush.drawImage(image, 0, 0, width, height);
    return { canvas, data: brush.getImageData(0, 0, width, height).data };
  };
  const image = await decode(shot);
  const [width, height] = [image.width, image.height].map((size) => Math.round(size / coarse));
  const now = draw(image, width, height);
  const reduced = now.canvas.toDataURL("image/png").split(",")[1];
  if (!before) return { reduced };
  const old = await decode(before);
  if (old.width !== width || old.height !== height) return { reduced, size: `${old.width} x ${old.height}, now ${width} x ${height}` };
  const then = draw(old, width, height);
  const different = [];
  for (let at = 0; at < width * height; at += 1) {
    const by = [0, 1, 2].map((k) => Math.abs(now.data[4 * at + k] - then.data[4 * at + k]));
    if (Math.max(...by) > near) different.push(at);
  }
  const columns = different.map((at) => at % width);
  const rows = different.map((at) => Math.floor(at / width));
  const ends = (list) => [Math.min(...list), Math.max(...list)].map((place) => place * coarse).join(" to ");
  const where = different.length > 0 ? `x ${ends(columns)}, y ${ends(rows)}` : "";
  return { reduced, share: different.length / (width * height), where };
}

/** Keeps a picture, and asserts that it looks as the committed one; UPDATE_EXPECT=1 commits it. */
export async function picture(page, name, options = {}) {
  await drawn(page);
  const shot = await page.screenshot({ path: `${kept}/${name}.png`, ...options });
  const file = `${expected}/${name}.png`;
  const isAccepted = process.env.UPDATE_EXPECT === "1";
  const before = !isAccepted && existsSync(file) ? readFileSync(file).toString("base64") : null;
  const found = await page.evaluate(reduceAndCompare, { shot: shot.toString("base64"), before, coarse: COARSE, near: NEAR });
  if (isAccepted) return writeFileSync(file, Buffer.from(found.reduced, "base64"));
  const help = `look at studio/test/pictures/${name}.png; UPDATE_EXPECT=1 accepts it`;
  assert.ok(before, `there is no committed picture ${name}: ${help}`);
  assert.ok(!found.size, `${name} has another size: ${found.size}; ${help}`);
  assert.ok(found.share <= SHARE, `${name}: ${(100 * found.share).toFixed(1)} % of it differ, at ${found.where}; ${help}`);
}
