import { readFile } from "node:fs/promises";

export const readModule = () => readFile(new URL("./momentree.wasm", import.meta.url));
