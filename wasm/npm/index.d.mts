import type { Engine } from "./host.mjs";

export * from "./host.mjs";

export interface LoadOptions {
  /** The contents of momentree.wasm, or the compiled module; default: that of this package. */
  readonly module?: BufferSource | WebAssembly.Module;
  /** Gets what the C library writes to its error output; default: console.error. */
  readonly log?: (text: string) => void;
}

/** Loads the engine. Engines share nothing; one engine can have many worlds. Rejects if the module cannot be read or compiled. */
export function load(options?: LoadOptions): Promise<Engine>;
