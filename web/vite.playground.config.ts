// Builds web/dist/playground.html: one file with the engine in it. Its policy also lets it compile that, and run its own worker.
import { defineConfig } from "vite";
import { viteSingleFile } from "vite-plugin-singlefile";
import { contentPolicy } from "./content_policy";
import { packedModule } from "./packed_module";

export default defineConfig({
  plugins: [packedModule(), viteSingleFile({ removeViteModuleLoader: true }), contentPolicy(" 'wasm-unsafe-eval' blob:")],
  server: { fs: { allow: [".."] } },
  build: {
    target: "es2021",
    outDir: "dist",
    emptyOutDir: false, // each page is a build of its own
    reportCompressedSize: false,
    rollupOptions: { input: "playground.html" },
  },
});
