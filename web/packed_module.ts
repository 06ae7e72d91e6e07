// Embeds a file in a page: `import packed from "….wasm?packed"` yields its bytes, deflated, in base64.
import { readFileSync } from "node:fs";
import { dirname, resolve } from "node:path";
import { zlibSync } from "fflate"; // the output of the system's zlib differs from processor to processor
import type { Plugin } from "vite";

/** Begins the names of such modules. */
const mark = "\0packed:";

/** Ends them: other plugins, which look at endings such as .json, leave them alone. */
const hidden = "#";

export const packedModule = (): Plugin => ({
  name: "packed-module",
  enforce: "pre",
  resolveId(source, importer) {
    const file = /^(.*)\?packed$/.exec(source)?.[1];
    return file && importer ? mark + resolve(dirname(importer), file) + hidden : null;
  },
  load(id) {
    if (!id.startsWith(mark)) return null;
    const bytes = readFileSync(id.slice(mark.length, -hidden.length));
    return `export default ${JSON.stringify(Buffer.from(zlibSync(bytes, { level: 9 })).toString("base64"))}`;
  },
});
