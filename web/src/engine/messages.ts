// Messages between the page and the engine: a worker of the page, or a program that shows its simulation in it. The engine reads
// and writes them in momentree/pages.
import {
  totalsOf,
  type Diagnostic,
  type ScenarioInfo,
  type Topology,
  type Triple,
  type World,
  type WorldTotals,
} from "../../../wasm/host.mjs";
import type { RunEvent } from "../recording";
import { bytesOf } from "../report/tables";
import type { ModelFile } from "../result_files";

/** An action as events of scenarios have it: `{ break: "chain/4" }`. */
export type UserAction = Readonly<Record<string, unknown>>;

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
  | { type: "gravity"; value: Triple }
  | { type: "damping"; factor: number; offset: number }
  /** The force at which every joint breaks at the latest (N). */
  | { type: "strength"; force: number }
  | { type: "grab"; body: string; point: Triple; target: Triple }
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
  /** Per closed contact its point (m) and the force on its first body (N). */
  readonly contacts: Float32Array;
}

/** A frame as it arrives: how many numbers it has, and their bytes, which are in base64 if the message has no others. */
interface FrameSizes {
  readonly poses: number;
  readonly loads: number;
  readonly contacts: number;
  readonly numbers?: string;
}

function frameFrom({ poses, loads, contacts, numbers = "" }: FrameSizes, given?: ArrayBuffer): Frame {
  const bytes = given ?? bytesOf(numbers, 1);
  const ofTotals = 8 * 17;
  const all = new Float32Array(bytes, ofTotals);
  const totals = totalsOf(new Float64Array(bytes, 0, 17));
  return {
    time: totals.time,
    poses: all.subarray(0, poses),
    loads: all.subarray(poses, poses + loads),
    totals,
    contacts: all.subarray(poses + loads, poses + loads + contacts),
  };
}

/** A message as the engine writes it: its frame is given by numbers. */
export type PostedMessage = { type: string; frame?: FrameSizes; world?: { frame: FrameSizes } | null };

export function messageFrom(message: PostedMessage, bytes?: ArrayBuffer): FromWorker {
  const { frame, world } = message;
  return {
    ...message,
    ...(frame && { frame: frameFrom(frame, bytes) }),
    ...(world && { world: { ...world, frame: frameFrom(world.frame, bytes) } }),
  } as FromWorker;
}

/** The present frame of a world. */
export function frameOf(world: World): Frame {
  const [{ bytes, ...answer }] = world.ask({ type: "frame" });
  const message = messageFrom(answer, bytes);
  if (message.type !== "frame") throw new Error(`the engine answered ${message.type}`);
  return message.frame;
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
