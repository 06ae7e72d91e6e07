// A run, as the viewer shows it. What implements this may be whole (a report) or grow while it is shown (a simulation that runs).
// SI units, world axes, quaternions w, x, y, z; bodies are numbered as in `model.bodies`, and −1 is the ground.

export type Vec3 = readonly [number, number, number];
export type Quat = readonly [number, number, number, number];

export interface Pose {
  readonly xyz: Vec3;
  readonly quat: Quat;
}

/** What a body looks like; lengths of cylinders and capsules lie along z of `at`, those of capsules without their caps. */
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
  /** Lines in the body's axes that stand for it where it has no shape. */
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

/** A joint as it was declared: its frame in the parent (or the world) and in the child. */
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

/** A joint that holds at some time. `at`: the joint in the parent (or the world); `childAt`: in the child. */
export interface Link {
  readonly joint: string;
  readonly kind: JointKind;
  readonly parent: number;
  readonly child: number;
  readonly at: Vec3;
  readonly childAt: Vec3;
  readonly locked?: boolean;
}

/** Who belongs together, and by what, from a time on until the next phase. */
export interface Phase {
  readonly from: number;
  /** By body: a number in `Recording.mechanisms`. */
  readonly mechanism: ArrayLike<number>;
  readonly links: readonly Link[];
}

export interface Totals {
  readonly kinetic: number;
  readonly potential: number;
  readonly linear: Vec3;
  readonly angular: Vec3;
}

/** What happened, with its certificate, as a line of events.jsonl says it (docs/results.md). */
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
  /** Bodies that it was about: children of joints that broke or changed, bodies that were joined. */
  readonly bodies: readonly number[];
}

/** Numbers by frame; NaN where there is none at that time. Ask for it anew after frames have come: it may be another array. */
export interface Column {
  readonly label: string;
  readonly unit: string;
  readonly values: ArrayLike<number>;
}

/** What can be plotted: of the world, or of a joint. */
export type WorldQuantity = "energy" | "balance" | "linear" | "angular";
export type JointQuantity = "q" | "v" | "p" | "force" | "torque";

/** Wall-clock times of a run (s), before and after its first topology change: Table 2 of Naudet and Lefeber (2005). */
export interface Times {
  readonly evaluations: { readonly before: number; readonly after: number };
  readonly topology: { readonly before: number; readonly after: number };
  readonly total: { readonly before: number; readonly after: number };
}

/** What summary.json says (docs/results.md), as far as it is shown. */
/** An event that did not happen: what it waited for, and how near that came. */
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
  /** How many frames there are by now. */
  readonly frames: number;
  /** Grows whenever something that was already there has changed: frames were taken back, another branch was begun. */
  readonly revision: number;
  /** Of a frame (s); never falls from frame to frame. */
  time(frame: number): number;
  /** Of a frame: per body x, y, z, qw, qx, qy, qz of its frame in the world. Valid until the recording changes. */
  poses(frame: number): ArrayLike<number>;
  /** Whether nothing can be said of the motion between a frame and the next: the run diverged there. */
  gapAfter?(frame: number): boolean;
  readonly events: readonly RunEvent[];
  /** At least one; the first holds from the start. */
  readonly phases: readonly Phase[];
  /** Names, in the order of appearance; their places choose their colours. */
  readonly mechanisms: readonly string[];
  /** Joints that have columns, by name. */
  readonly joints: readonly string[];
  /** Empty where the recording has no such numbers. */
  world(quantity: WorldQuantity): readonly Column[];
  joint(joint: string, quantity: JointQuantity): readonly Column[];
  readonly summary: Summary | null;
}
