// Builds the engine for the page: cargo, then wasm-bindgen of the same version as the crate.

import { execFileSync } from "node:child_process";
import { readFileSync, rmSync } from "node:fs";
import { join } from "node:path";

const root = new URL("..", import.meta.url).pathname;
const target = process.env.CARGO_TARGET_DIR ?? join(root, "target");

const run = (program, args) => execFileSync(program, args, { cwd: root, stdio: "inherit" });

const lock = readFileSync(join(root, "Cargo.lock"), "utf8");
const version = /name = "wasm-bindgen"\nversion = "([^"]+)"/.exec(lock)[1];
try {
  const found = execFileSync("wasm-bindgen", ["--version"], { encoding: "utf8" }).trim();
  if (!found.endsWith(version)) throw new Error(`it is ${found}`);
} catch (error) {
  console.error(`wasm-bindgen ${version} is needed (${error.message}): cargo install wasm-bindgen-cli --version ${version}`);
  process.exit(1);
}

run("cargo", ["build", "--locked", "-p", "trunnion-web", "--profile", "web", "--target", "wasm32-unknown-unknown"]);
const out = join(root, "studio/src/engine");
rmSync(out, { recursive: true, force: true });
run("wasm-bindgen", [join(target, "wasm32-unknown-unknown/web/trunnion_web.wasm"), "--target", "web", "--out-dir", out]);
