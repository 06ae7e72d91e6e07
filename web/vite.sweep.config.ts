// Builds web/dist/sweep.html: the page of a sweep, a single self-contained file with a content policy.
import { defineConfig } from "vite";
import { viteSingleFile } from "vite-plugin-singlefile";
import { contentPolicy } from "./content_policy";

export default defineConfig({
  plugins: [viteSingleFile({ removeViteModuleLoader: true }), contentPolicy()],
  build: {
    target: "es2021",
    outDir: "dist",
    emptyOutDir: false, // each page is a separate build
    reportCompressedSize: false,
    rollupOptions: { input: "sweep.html" },
  },
});
