// The types of host.mjs.
export const motionSize: 13;
export const jointSize: 29;
export const status: {
  readonly ok: 0;
  readonly diverged: 1;
  readonly interrupted: 2;
  readonly refused: 3;
};

export class EngineFailure extends Error {}

export type Triple = readonly [number, number, number];

export interface Outcome {
  readonly status: number;
  /** Why the action was refused or the run diverged. */
  readonly message: string;
}

export interface Diagnostic {
  readonly severity: "error" | "warning" | "note";
  readonly line: number;
  readonly column: number;
  readonly what: string;
  readonly hint: string;
}

export interface ScenarioInfo {
  readonly title: string;
  readonly until: number;
  readonly every: number;
  readonly step: number;
  readonly method: string;
  readonly gravity: Triple;
  readonly events: readonly {
    name: string;
    time: number | null;
    line: number;
    actions: readonly string[];
  }[];
}

export interface PlacedPose {
  readonly xyz: Triple;
  readonly quat: readonly [number, number, number, number];
}

export interface TopologyJoint {
  readonly number: number;
  /** Its place in the rows of World.joints(). */
  readonly row: number;
  readonly name: string;
  readonly kind: string;
  readonly parent: number;
  readonly child: number;
  readonly locked: number;
  readonly at: PlacedPose;
  readonly child_at: PlacedPose;
  readonly axis: Triple;
  readonly damping: number;
  readonly force: number | null;
  readonly torque: number | null;
  /** It closes a loop: it is not the inboard joint of its child. */
  readonly loop?: boolean;
}

export interface Topology {
  readonly mechanisms: readonly {
    name: string;
    root: number;
    grounded: boolean;
    bodies: readonly number[];
  }[];
  readonly joints: readonly TopologyJoint[];
  /** Absent if the model has no springs. */
  readonly broken_springs?: readonly string[];
  /** Exact couplings of joints by name, "": no joint is followed; absent if the model has none. */
  readonly couplings?: readonly { readonly joint: string; readonly follows: string; readonly ended: boolean }[];
}

export interface WorldTotals {
  readonly time: number;
  readonly kinetic: number;
  readonly potential: number;
  readonly linear: Triple;
  readonly angular: Triple;
  readonly balance: {
    readonly initial: number;
    readonly final: number;
    readonly dissipated: number;
    readonly work: number;
    readonly lost: number;
    readonly released: number;
    readonly error: number;
    /** Energy that keeping loops closed brought in. */
    readonly projection: number;
  };
}

export class Engine {
  static of(source: BufferSource | WebAssembly.Module, log?: (text: string) => void): Promise<Engine>;
  world(): World;
  readonly bytes: number;
}

/** Arrays of numbers are valid until the next call. */
export class World {
  load(scenario: string): {
    scenario: ScenarioInfo | null;
    diagnostics: readonly Diagnostic[];
  };
  /** The document model.json (docs/howto/use-the-results.md). */
  model(): unknown;
  /** By kind of joint, the units of its coordinates, velocities and momenta; "": a component of a quaternion. */
  kinds(): Record<string, Record<"q" | "v" | "p", readonly string[]>>;
  topology(): Topology;
  /** Lines of events.jsonl (docs/results.md). */
  events(first?: number): unknown[];
  readonly revision: number;
  readonly eventCount: number;
  readonly time: number;
  readonly bodies: number;
  run(time: number, budget?: number): Outcome;
  motions(): Float64Array;
  /** Of the loaded scenario at these coordinates of all joints of its tree, in the order of their numbers. */
  motionsAt(q: readonly number[]): Float64Array;
  /** All `count` coordinates of the last motionsAt(): with closed loops others than it was given. */
  posed(count: number): number[];
  /** The coordinates of the joint in that row. */
  coordinates(row: number): number[];
  /** Number of rows of joints(). */
  readonly jointRows: number;
  joints(withReactions?: boolean): Float64Array;
  totals(): WorldTotals;
  cut(joint: number): Outcome;
  free(joint: number): Outcome;
  lock(joint: number): Outcome;
  unlock(joint: number): Outcome;
  weld(body: number, to: number): Outcome;
  attach(body: number, to: number, kind: string, axis: Triple): Outcome;
  change(joint: number, kind: string): Outcome;
  impulse(body: number, force: Triple, point: Triple): Outcome;
  set(
    joint: number,
    parameters: {
      damping?: number;
      stiffness?: number;
      force?: number;
      torque?: number;
    },
  ): Outcome;
  setDamping(factor: number, offset: number): Outcome;
  setGravity(gravity: Triple): Outcome;
  grab(body: number, point: Triple, strength?: number): Outcome;
  pull(target: Triple): void;
  releaseGrip(): void;
  snapshot(): number;
  restore(snapshot: number): Outcome;
  drop(snapshot: number): void;
  undo(event: number, again?: boolean): Outcome;
  branch(): World;
  destroy(): void;
}
