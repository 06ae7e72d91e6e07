// Messages between the page and the worker that runs the engine.
import type { Diagnostic, ScenarioInfo, Topology, Triple, WorldTotals } from "../../../wasm/host.mjs";

/** The effect of a click on a joint or a body; numbers as the engine gives them. */
export type Act =
  | { do: "cut" | "free" | "lock" | "unlock"; joint: number }
  | { do: "weld"; body: number; to: number }
  | { do: "change"; joint: number; kind: string };

export type ToWorker =
  | { say: "module"; bytes: ArrayBuffer }
  | { say: "load"; text: string }
  /** Checks a text for errors; the world stays. */
  | { say: "check"; text: string }
  | { say: "play"; on: boolean }
  | { say: "speed"; factor: number }
  | { say: "act"; act: Act }
  | { say: "gravity"; value: Triple }
  | { say: "damping"; factor: number; offset: number }
  | { say: "grab"; body: number; point: Triple; target: Triple }
  | { say: "pull"; target: Triple }
  | { say: "let go" }
  /** Back to an instant; continuing from there makes another branch. */
  | { say: "rewind"; time: number }
  /** Back to just before an event of this branch; the event does not happen again by itself. */
  | { say: "undo"; event: number }
  /** Continues a branch at its end. */
  | { say: "branch"; branch: number };

export interface Frame {
  readonly time: number;
  /** Per body x, y, z, qw, qx, qy, qz. */
  readonly poses: Float32Array;
  /**
   * Per joint number: its load as a fraction of the load at which it breaks (NaN: unlimited), and its reaction force
   * (N).
   */
  readonly loads: Float32Array;
  readonly totals: WorldTotals;
}

export type FromWorker =
  | { say: "ready" }
  | {
      say: "loaded";
      diagnostics: readonly Diagnostic[];
      scenario: ScenarioInfo | null;
      model: unknown;
      topology: Topology | null;
      frame: Frame | null;
    }
  | { say: "checked"; diagnostics: readonly Diagnostic[] }
  | { say: "frame"; frame: Frame; seconds: number }
  | { say: "topology"; time: number; topology: Topology }
  | { say: "events"; events: Record<string, unknown>[] }
  /** Frames, events and phases after `time` are removed; `left` keeps the branch that ended there. */
  | { say: "went back"; time: number; events: number; left: number }
  /** That branch continues; the previous one is kept as `left`. */
  | { say: "branched"; branch: number; left: number }
  | { say: "playing"; on: boolean }
  | { say: "refused"; message: string }
  | { say: "stopped"; message: string }
  | { say: "failed"; message: string };
