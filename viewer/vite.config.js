// One classic script and one style sheet, without hashes: the report crate includes both as text.
import { readFileSync } from "node:fs";
import { defineConfig } from "vite";

// Its licence asks to travel with every copy.
const licence = readFileSync(new URL("node_modules/three/LICENSE", import.meta.url), "utf8");

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
    rolldownOptions: { output: { postBanner: `/*! This file contains three.js:\n${licence.trim()}\n*/` } },
  },
});
