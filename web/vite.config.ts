// Builds web/dist/report.html: a single self-contained file, with a content policy that names its script by hash.
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
    rollupOptions: { input: "report.html" },
  },
});
