// The package `momentree` of npm: host.mjs, and load(), which finds the module of the package.
import { readModule } from "#module";
import { Engine } from "./host.mjs";

export { Engine, EngineFailure, World, jointSize, motionSize, status } from "./host.mjs";

export async function load({ module, log } = {}) {
  return Engine.of(module ?? (await readModule()), log);
}
