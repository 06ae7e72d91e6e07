// The engine's module in a page: `import packed from "….wasm?packed"` is its bytes, deflated, in base64.
import { readFileSync } from "node:fs";
import { deflateSync } from "fflate"; // zlib's bytes differ from processor to processor
import type { Plugin } from "vite";

export const packedModule = (): Plugin => ({
  name: "packed-module",
  enforce: "pre",
  load(id) {
    if (!id.endsWith(".wasm?packed")) return null;
    const bytes = readFileSync(id.slice(0, -"?packed".length));
    return `export default ${JSON.stringify(Buffer.from(deflateSync(bytes, { level: 9 })).toString("base64"))}`;
  },
});
