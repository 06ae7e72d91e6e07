// A run as the viewer shows it. An implementation may be complete (a report) or grow while it is shown (a running
// simulation). SI units, world axes, quaternions w, x, y, z; bodies are numbered as in `model.bodies`, and −1 is the
// ground.

export type Vec3 = readonly [number, number, number];
export type Quat = readonly [number, number, number, number];

export interface Pose {
  readonly xyz: Vec3;
  readonly quat: Quat;
}

/** The shape of a body; cylinders and capsules extend along z of `at`, the lengths of capsules exclude their caps. */
export interface Shape {
  readonly kind: "box" | "sphere" | "cylinder" | "capsule" | "mesh";
  readonly size?: Vec3;
  readonly radius?: number;
  readonly length?: number;
  readonly file?: string;
  readonly at: Pose;
  readonly colour?: string;
}

export interface Body {
  readonly name: string;
  readonly mass: number;
  readonly com: Vec3;
  /** Lines in the body's axes that represent a body without a shape. */
  readonly extent: readonly (readonly [Vec3, Vec3])[];
  readonly shapes: readonly Shape[];
}

export type JointKind =
  | "revolute"
  | "prismatic"
  | "helical"
  | "cylindrical"
  | "universal"
  | "ball"
  | "planar"
  | "free"
  | "weld";

/** A joint as declared: its frame in the parent (or the world) and in the child. */
export interface Joint {
  readonly name: string;
  readonly kind: JointKind;
  readonly parent: number;
  readonly child: number;
  readonly at: Pose;
  readonly childAt: Pose;
  readonly axis?: Vec3;
  readonly axis2?: Vec3;
  readonly pitch?: number;
}

export interface Model {
  readonly title: string;
  readonly gravity: Vec3;
  readonly bodies: readonly Body[];
  readonly joints: readonly Joint[];
}

/** A joint that exists at some time. `at`: the joint in the parent (or the world); `childAt`: in the child. */
export interface Link {
  readonly joint: string;
  readonly kind: JointKind;
  readonly parent: number;
  readonly child: number;
  readonly at: Vec3;
  readonly childAt: Vec3;
  readonly locked?: boolean;
}

/** The topology from a time on until the next phase. */
export interface Phase {
  readonly from: number;
  /** By body: an index into `Recording.mechanisms`. */
  readonly mechanism: ArrayLike<number>;
  readonly links: readonly Link[];
}

export interface Totals {
  readonly kinetic: number;
  readonly potential: number;
  readonly linear: Vec3;
  readonly angular: Vec3;
}

/** An event with its certificate, as in a line of events.jsonl (docs/results.md). */
export interface RunEvent {
  readonly time: number;
  readonly name: string;
  readonly actions: readonly string[];
  readonly mechanisms: { readonly before: readonly string[]; readonly after: readonly string[] };
  readonly before: Totals | null;
  readonly after: Totals | null;
  readonly released: number;
  readonly lost: number;
  readonly work: number;
  readonly hardest: { readonly joint: string; readonly linear: number; readonly angular: number } | null;
  readonly durationNs: number;
  /** Bodies affected by it: children of joints that broke or changed, bodies that were joined. */
  readonly bodies: readonly number[];
}

/**
 * Values by frame; NaN if there is none at that time. Request it again after frames were added: the array may be
 * replaced.
 */
export interface Column {
  readonly label: string;
  readonly unit: string;
  readonly values: ArrayLike<number>;
}

/** Quantities that can be plotted: of the world, or of a joint. */
export type WorldQuantity = "energy" | "balance" | "linear" | "angular";
export type JointQuantity = "q" | "v" | "p" | "force" | "torque";

/** Wall-clock times of a run (s), before and after its first topology change: Table 2 of Naudet and Lefeber (2005). */
export interface Times {
  readonly evaluations: { readonly before: number; readonly after: number };
  readonly topology: { readonly before: number; readonly after: number };
  readonly total: { readonly before: number; readonly after: number };
}

/** An event that did not happen: the condition that it depended on, and how near the condition came to firing. */
export interface Missed {
  readonly event: string;
  readonly quantity?: string;
  readonly of?: readonly string[];
  readonly exceeds?: number;
  readonly below?: number;
  readonly nearest?: number | null;
  readonly nearest_time?: number | null;
  readonly for?: number;
  readonly held?: number;
  readonly after?: string;
  readonly time?: number;
}

/** The parts of summary.json (docs/results.md) that are shown. */
export interface Summary {
  readonly status: string;
  readonly version: string;
  readonly scenario: string;
  readonly method: string;
  readonly step: number;
  readonly steps: number;
  readonly evaluations: number;
  readonly changes: number;
  readonly realTimeFactor: number | null;
  readonly times: Times | null;
  readonly energy: Readonly<Record<string, number | null>> | null;
  readonly missed: readonly Missed[];
  readonly warnings: readonly string[];
}

export interface Recording {
  readonly model: Model;
  /** Present number of frames. */
  readonly frames: number;
  /** Increases whenever existing data have changed: frames were removed, or another branch was begun. */
  readonly revision: number;
  /** Time of a frame (s); never decreases from frame to frame. */
  time(frame: number): number;
  /** Of a frame: per body x, y, z, qw, qx, qy, qz of its frame in the world. Valid until the recording changes. */
  poses(frame: number): ArrayLike<number>;
  /** Whether the motion between a frame and the next is unknown: the run diverged there. */
  gapAfter?(frame: number): boolean;
  readonly events: readonly RunEvent[];
  /** At least one; the first is valid from the start. */
  readonly phases: readonly Phase[];
  /** Names in the order of appearance; their indices determine their colours. */
  readonly mechanisms: readonly string[];
  /** Joints that have columns, by name. */
  readonly joints: readonly string[];
  /** Empty if the recording does not contain the quantity. */
  world(quantity: WorldQuantity): readonly Column[];
  joint(joint: string, quantity: JointQuantity): readonly Column[];
  readonly summary: Summary | null;
}
