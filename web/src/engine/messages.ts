// Messages between the page and the engine: a worker of the page, or a program that shows its simulation in it.
import type { Diagnostic, ScenarioInfo, Topology, Triple, WorldTotals } from "../../../wasm/host.mjs";
import type { RunEvent } from "../recording";
import type { ModelFile } from "../result_files";

/** An action on joints and bodies, which have the numbers that the engine gives them. */
export type UserAction =
  | { action: "break" | "free" | "lock" | "unlock"; joint: number }
  | { action: "weld"; body: number; to: number };

/** A number of the program, on the page of a live view. */
export interface SliderInfo {
  readonly name: string;
  readonly least: number;
  readonly most: number;
  readonly value: number;
  readonly unit: string;
}

export type ToWorker =
  | { type: "module"; bytes: ArrayBuffer }
  /** `floor`: with a floor below the mechanisms, on which all bodies land. */
  | { type: "load"; text: string; floor?: boolean }
  /** Checks a text for errors without loading it. */
  | { type: "check"; text: string }
  | { type: "play"; on: boolean }
  | { type: "speed"; factor: number }
  | { type: "act"; action: UserAction }
  /** Parameters of all degrees of freedom of a joint. */
  | { type: "set"; joint: number; damping?: number; stiffness?: number }
  | { type: "gravity"; value: Triple }
  | { type: "damping"; factor: number; offset: number }
  /** The force at which every joint breaks at the latest (N). */
  | { type: "strength"; force: number }
  | { type: "grab"; body: number; point: Triple; target: Triple }
  | { type: "pull"; target: Triple }
  | { type: "release" }
  /** Goes back to an instant; continuing from there makes another branch. */
  | { type: "rewind"; time: number }
  /** Goes back to just before an event of this branch, which is not scheduled again. */
  | { type: "undo"; event: number }
  /** Continues a branch at its end. */
  | { type: "branch"; branch: number }
  // Only to programs:
  | { type: "slider"; name: string; value: number }
  | { type: "stop" };

/** Numbers per joint in `Frame.loads`. */
export const loadSize = 6;
/** Numbers per contact in `Frame.contacts`. */
export const contactForceSize = 6;

export interface Frame {
  readonly time: number;
  /** Per body x, y, z, qw, qx, qy, qz. */
  readonly poses: Float32Array;
  /**
   * By the joints' rows: load as a fraction of the load at which it breaks (NaN: unlimited), reaction force (N), whether the
   * reaction is determined (0: closed loops leave it open), and the reaction force on the child in its axes (N).
   */
  readonly loads: Float32Array;
  readonly totals: WorldTotals;
  /** Per closed contact its point (m) and the force on its first body (N); absent: unknown. */
  readonly contacts?: Float32Array;
}

export interface LoadedWorld {
  readonly scenario: ScenarioInfo;
  readonly model: ModelFile;
  readonly topology: Topology;
  readonly frame: Frame;
}

export type FromWorker =
  | { type: "ready" }
  /** `world`: null if the scenario has errors; the previous world then continues. */
  | { type: "loaded"; diagnostics: readonly Diagnostic[]; world: LoadedWorld | null }
  | { type: "checked"; diagnostics: readonly Diagnostic[] }
  | { type: "frame"; frame: Frame; seconds: number }
  | { type: "topology"; time: number; topology: Topology }
  | { type: "events"; events: readonly RunEvent[] }
  /** Frames, events and phases after `time` are removed; `savedAs` is the number of the branch that they belong to. */
  | { type: "rewound"; time: number; events: number; savedAs: number }
  /** That branch continues; `savedAs` is the number of the previous one. */
  | { type: "resumed"; branch: number; savedAs: number }
  | { type: "sliders"; sliders: readonly SliderInfo[] }
  | { type: "gravity"; value: Triple }
  | { type: "playing"; on: boolean }
  | { type: "refused"; message: string }
  | { type: "stopped"; message: string }
  | { type: "failed"; message: string };

/** Where the engine runs: a Worker is one. */
export interface EnginePort {
  postMessage(message: ToWorker): void;
  onmessage: ((event: MessageEvent<FromWorker>) => void) | null;
}
