// The types of host.mjs. Quantities are in SI units and radians; quaternions are w, x, y, z.
/** Numbers per body in World.motions(), per row in World.joints(), and per point in World.contacts(). */
export const motionSize: 13;
export const jointSize: 29;
export const contactSize: 15;
export const status: {
  readonly ok: 0;
  readonly diverged: 1;
  readonly interrupted: 2;
  readonly refused: 3;
};

/** An unexpected error of the engine. The engine that threw it must not be used again. */
export class EngineFailure extends Error {}

export type Triple = readonly [number, number, number];

export interface Outcome {
  /** One of `status`. */
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
  /** Whether it was loaded with a floor, and that changed it. */
  readonly floor: boolean;
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
  /** Of its first degree of freedom. */
  readonly stiffness: number;
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
  readonly couplings?: readonly {
    readonly joint: string;
    readonly follows: string;
    readonly ended: boolean;
  }[];
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

/** The totals of a world from the numbers in which the module writes them. */
export function totalsOf(numbers: Iterable<number>): WorldTotals;

/** Made by Engine.of. */
export class Engine {
  private constructor();
  /** From the contents of momentree.wasm, or the compiled module. */
  static of(source: BufferSource | WebAssembly.Module, log?: (text: string) => void): Promise<Engine>;
  /** An empty world: load a scenario next. */
  world(): World;
  /** A world that plays in real time, for a page. `post` gets its messages; `bytes`: of the frame in it. */
  session<To, From>(post: (message: From, bytes?: ArrayBuffer) => void): Session<To>;
  /** Size of the memory. */
  readonly bytes: number;
}

/** Made by Engine.session(). web/src/engine/messages.ts has the types of its messages. */
export class Session<To> {
  private constructor();
  send(message: To): void;
  /** `seconds` of wall-clock time have passed. */
  tick(seconds: number): void;
}

/** Arrays of numbers are valid until the next call. Joints and bodies have the names that the scenario gives them; "ground" is the
 * ground. */
export class World {
  private constructor();
  /** Sends a message of the protocol (momentree/pages/README.md), and returns what is posted; `bytes`: of the frame in it. */
  ask(message: object): { type: string; bytes?: ArrayBuffer }[];
  /** Reads a scenario (TOML). If it has errors, `scenario` is null and the world stays as it was. `floor`: all bodies land on a
   * floor below the mechanisms, or on that of the scenario. */
  load(
    scenario: string,
    options?: { readonly floor?: boolean },
  ): {
    scenario: ScenarioInfo | null;
    diagnostics: readonly Diagnostic[];
  };
  /** The document model.json (docs/howto/use-the-results.md). */
  model(): unknown;
  /** By kind of joint, the units of its coordinates, velocities and momenta; "": a component of a quaternion. */
  kinds(): Record<string, Record<"q" | "v" | "p", readonly string[]>>;
  /** The mechanisms and joints at this instant. */
  topology(): Topology;
  /** Lines of events.jsonl (docs/results.md). */
  events(first?: number): unknown[];
  /** Changes whenever the topology may have changed. */
  readonly revision: number;
  /** Number of events that have happened. */
  readonly eventCount: number;
  /** s */
  readonly time: number;
  readonly bodies: number;
  /** Steps to `time` (s) for at most `budget` seconds of wall-clock time; status.interrupted: call again. */
  run(time: number, budget?: number): Outcome;
  /** 13 numbers per body: position and quaternion of its frame, velocity of the origin, angular velocity, in world axes. */
  motions(): Float64Array;
  /** 15 numbers per point at which bodies touch: both bodies (−1: the ground), point, normal from the second to the first body,
   * force on the first one (N), velocity of slip, and 1 if it slips; world axes. */
  contacts(): Float64Array;
  /** Of the loaded scenario at these coordinates of all joints of its tree, in the order of their numbers. Loops are closed by the
   * least change of the joints whose coordinates are as in the last call; if that is impossible, the result is that of the last
   * call. The world does not change. */
  motionsAt(q: readonly number[]): Float64Array;
  /** All coordinates of the last motionsAt(): with closed loops others than it was given. */
  posed(): number[];
  /** The coordinates of the joint in that row. */
  coordinates(row: number): number[];
  /** Number of rows of joints(). */
  readonly jointRows: number;
  /** 29 numbers per row: nq, nv, q (7), v (6), p (6), the reaction on the child about the joint's frame there, in the child's axes
   * (force and torque, 6; zero unless requested), the load, and 0 if closed loops leave the reaction open, else 1. nq is -1 where
   * there is no joint any more. The load is the largest ratio of a reaction to the value at which the joint breaks; NaN if there is none. */
  joints(withReactions?: boolean): Float64Array;
  /** Energies (J), momenta about the origin of the world, and the energy balance since the start. */
  totals(): WorldTotals;
  /** Actions at this instant, as an event of a scenario has them (docs/scenario.md): `{ break: "chain/4" }`,
   * `{ attach: { body: "a", to: "b", kind: "revolute", axis: [0, 0, 1] } }`, `{ set: { joint: "hip", damping: 0.1 } }`. */
  act(action: Readonly<Record<string, unknown>>): Outcome;
  /** m/s² */
  setGravity(gravity: Triple): Outcome;
  /** Holds a point of a body (m, in its frame) by a spring and a damper, of which there is one. */
  grab(body: string, point: Triple, strength?: number): Outcome;
  /** Where the grabbed point is pulled to (m, world). */
  pull(target: Triple): void;
  releaseGrip(): void;
  /** Keeps the complete run until it is dropped or another scenario is loaded. */
  snapshot(): number;
  /** Exact to the last bit, in this world and its branches. */
  restore(snapshot: number): Outcome;
  drop(snapshot: number): void;
  /** Returns to just before an event; its actions happen again only with `again`. */
  undo(event: number, again?: boolean): Outcome;
  /** An independent run from here. */
  branch(): World;
  /** Frees the memory; the world must not be used again. */
  destroy(): void;
}
