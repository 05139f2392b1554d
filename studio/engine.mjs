// Builds the engine for the page: the crate, then the JavaScript beside it, which `bindgen/` writes.

import { execFileSync } from "node:child_process";
import { rmSync } from "node:fs";
import { join } from "node:path";

const root = new URL("..", import.meta.url).pathname;
const target = process.env.CARGO_TARGET_DIR ?? join(root, "target");

const run = (program, args) => execFileSync(program, args, { cwd: root, stdio: "inherit" });

run("cargo", ["build", "--locked", "-p", "trunnion-web", "--profile", "web", "--target", "wasm32-unknown-unknown"]);
const out = join(root, "studio/src/engine");
rmSync(out, { recursive: true, force: true });
const tool = ["run", "--quiet", "--locked", "--manifest-path", join(root, "studio/bindgen/Cargo.toml"), "--target-dir", join(target, "bindgen")];
run("cargo", [...tool, "--", join(target, "wasm32-unknown-unknown/web/trunnion_web.wasm"), out]);
