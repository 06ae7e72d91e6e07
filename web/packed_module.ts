// The engine's module in a page: `import packed from "….wasm?packed"` is its bytes, deflated, in base64.
import { readFileSync } from "node:fs";
import { zlibSync } from "fflate"; // the bytes of the system's zlib differ from processor to processor
import type { Plugin } from "vite";

export const packedModule = (): Plugin => ({
  name: "packed-module",
  enforce: "pre",
  load(id) {
    if (!id.endsWith(".wasm?packed")) return null;
    const bytes = readFileSync(id.slice(0, -"?packed".length));
    return `export default ${JSON.stringify(Buffer.from(zlibSync(bytes, { level: 9 })).toString("base64"))}`;
  },
});
