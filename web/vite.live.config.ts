// Builds web/dist/live.html: the page of a live view, which may talk to the program that serves it.
import { defineConfig } from "vite";
import { viteSingleFile } from "vite-plugin-singlefile";
import { contentPolicy } from "./content_policy";

export default defineConfig({
  plugins: [viteSingleFile({ removeViteModuleLoader: true }), contentPolicy({ connect: "'self'" })],
  server: { fs: { allow: [".."] } },
  build: {
    target: "es2021",
    outDir: "dist",
    emptyOutDir: false, // each page is a separate build
    reportCompressedSize: false,
    rollupOptions: { input: "live.html" },
  },
});
