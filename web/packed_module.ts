// Embeds the engine's module in a page: `import packed from "….wasm?packed"` yields its bytes, deflated, in base64.
import { readFileSync } from "node:fs";
import { zlibSync } from "fflate"; // the output of the system's zlib differs from processor to processor
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
