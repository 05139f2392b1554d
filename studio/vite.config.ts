// A static site with plain names, and the samples of its gallery beside it.

import { cpSync, mkdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { type Plugin, defineConfig } from "vite";
import { SAMPLES } from "./src/samples.ts";

const here = new URL(".", import.meta.url).pathname;
const three = join(here, "node_modules/three");

/** Samples are files of the repository, copied when the site is built. */
const samples: Plugin = {
  name: "samples",
  apply: "build",
  closeBundle() {
    for (const name of new Set(SAMPLES.flatMap(({ files }) => files))) {
      const to = join(here, "dist/samples", name);
      mkdirSync(dirname(to), { recursive: true });
      cpSync(name.includes("/") ? join(here, "..", name) : join(here, "samples", name), to);
    }
  },
};

export default defineConfig({
  base: "./",
  plugins: [samples],
  // The modules of the report stand outside this folder, and find three.js here.
  resolve: {
    alias: [
      { find: /^three$/, replacement: `${three}/build/three.module.js` },
      { find: /^three\/addons\//, replacement: `${three}/examples/jsm/` },
    ],
  },
  worker: {
    format: "es",
    rolldownOptions: { output: { entryFileNames: "worker.js", assetFileNames: "[name][extname]" } },
  },
  build: {
    target: "es2022",
    assetsDir: "",
    chunkSizeWarningLimit: 1000,
    rolldownOptions: {
      output: { entryFileNames: "studio.js", chunkFileNames: "[name].js", assetFileNames: "[name][extname]" },
    },
  },
});
