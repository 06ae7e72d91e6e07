// Builds web/dist/playground.html: a single file that contains the engine. Its policy also allows it to compile the
// engine, to run its own worker, and to load the scenario at an address that is in the page's own.
import { defineConfig } from "vite";
import { viteSingleFile } from "vite-plugin-singlefile";
import { contentPolicy } from "./content_policy";
import { packedModule } from "./packed_module";

export default defineConfig({
  plugins: [
    packedModule(),
    viteSingleFile({ removeViteModuleLoader: true }),
    contentPolicy({ script: " 'wasm-unsafe-eval' blob:", connect: "'self' https:" }),
  ],
  server: { fs: { allow: [".."] } },
  build: {
    target: "es2021",
    outDir: "dist",
    emptyOutDir: false, // each page is a separate build
    reportCompressedSize: false,
    rollupOptions: { input: "playground.html" },
  },
});
