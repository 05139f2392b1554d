// One classic script and one style sheet, without hashes: the report crate includes both as text.
import { readFileSync, readdirSync } from "node:fs";
import { defineConfig } from "vite";

// Its licence asks to travel with every copy.
const licence = readFileSync(new URL("node_modules/three/LICENSE", import.meta.url), "utf8");

/** FNV-1a over the sources, so that a test without Node can tell a stale build. */
function fingerprint() {
  const folder = new URL("src/", import.meta.url);
  const files = readdirSync(folder).sort().map((name) => new URL(name, folder));
  let hash = 0xcbf29ce484222325n;
  for (const file of [...files, new URL("package-lock.json", import.meta.url)]) {
    for (const byte of readFileSync(file)) {
      hash = BigInt.asUintN(64, (hash ^ BigInt(byte)) * 0x100000001b3n);
    }
  }
  return hash.toString(16).padStart(16, "0");
}

export default defineConfig({
  build: {
    outDir: "../crates/trunnion-report/assets",
    emptyOutDir: false,
    target: "es2020",
    lib: {
      entry: "src/main.js",
      name: "trunnionViewer",
      formats: ["iife"],
      fileName: () => "viewer.js",
      cssFileName: "viewer",
    },
    rolldownOptions: {
      output: {
        postBanner:
          `/*! Built from viewer/, sources ${fingerprint()}. It contains three.js:\n` +
          `${licence.trim()}\n*/`,
      },
    },
  },
});
