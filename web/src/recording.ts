// A run as pages show it: complete (a report), or growing while it is shown (a running simulation). SI units, world
// axes, quaternions w, x, y, z; bodies are numbered as in `model.bodies`, and −1 is the ground.

export type Vec3 = readonly [number, number, number];
export type Quat = readonly [number, number, number, number];

export interface Pose {
  readonly xyz: Vec3;
  readonly quat: Quat;
}

/**
 * The shape of a body; cylinders and capsules extend along z of `at`, the lengths of capsules exclude their caps. Shapes of other
 * kinds have triangles.
 */
export interface Shape {
  readonly kind: string;
  readonly size?: Vec3;
  readonly radius?: number;
  readonly length?: number;
  readonly file?: string;
  /** The number of a mesh in the page's meshes. */
  readonly mesh?: number;
  /** Of a mesh. */
  readonly scale?: Vec3;
  /** The triangles of other shapes, by colour; absent or empty: a mesh that could not be read. */
  readonly parts?: readonly MeshPart[];
  readonly at: Pose;
  readonly colour?: string;
}

/** Triangles of one colour: points x, y, z (m, before the shape's scale), and three points per triangle. */
export interface MeshPart {
  readonly colour?: string;
  readonly positions: Float32Array;
  readonly triangles: Uint16Array;
}

export interface Body {
  readonly name: string;
  readonly mass: number;
  readonly com: Vec3;
  /** xx, yy, zz, xy, xz, yz about the centre of mass; absent: unknown. */
  readonly inertia?: readonly number[];
  /** Lines in the body's axes that represent a body without a shape. */
  readonly extent: readonly (readonly [Vec3, Vec3])[];
  readonly shapes: readonly Shape[];
}

/** Of the bodies (kg). */
export const massOf = (bodies: readonly Body[]) => bodies.reduce((sum, body) => sum + body.mass, 0);

/** A joint at some time. `at`: its position in the parent (or the world); `childAt`: in the child. */
export interface Joint {
  readonly name: string;
  readonly kind: string;
  readonly parent: number;
  readonly child: number;
  readonly at: Vec3;
  readonly childAt: Vec3;
  readonly locked?: boolean;
  /** It closes a loop: it joins its bodies in addition to their inboard joints. */
  readonly loop?: boolean;
  /** It closed a loop until it took the place of a broken inboard joint. */
  readonly wasLoop?: boolean;
}

/** A spring between points of two bodies, in their frames (of the ground in the world). */
export interface Spring {
  readonly name: string;
  readonly from: number;
  readonly to: number;
  readonly fromPoint: Vec3;
  readonly toPoint: Vec3;
  readonly stiffness: number;
  readonly rest: number;
  readonly tensionOnly: boolean;
  /** A cable, which is never longer than `rest`; absent: no. */
  readonly inextensible?: boolean;
  /** The force at which it breaks; null: it never breaks. */
  readonly strength: number | null;
}

/** A plane that bodies can lie on, such as the floor. */
export interface Plane {
  readonly point: Vec3;
  readonly normal: Vec3;
}

/** A model at the start of a run. */
export interface Model {
  readonly title: string;
  readonly gravity: Vec3;
  readonly bodies: readonly Body[];
  readonly joints: readonly Joint[];
  readonly springs?: readonly Spring[];
  readonly planes?: readonly Plane[];
  /** What the ground has besides planes, in the world. */
  readonly ground?: readonly Shape[];
}

/** The topology from a time on until the next phase. */
export interface Phase {
  readonly from: number;
  /** By body: an index into `Recording.mechanisms`. */
  readonly mechanism: ArrayLike<number>;
  readonly joints: readonly Joint[];
  /** Springs that act; absent: those of the model. */
  readonly springs?: readonly Spring[];
}

export interface Totals {
  readonly kinetic: number;
  readonly potential: number;
  readonly linear: Vec3;
  readonly angular: Vec3;
  /** The equations of closed loops: their number, how many are independent, and how far open the loops are. */
  readonly loops?: { readonly rows: number; readonly rank: number; readonly residual: number };
}

/** An event with its certificate: the members that are used of a line of events.jsonl (docs/results.md). */
export interface RunEvent {
  readonly time: number;
  readonly event: string;
  readonly actions: readonly string[];
  readonly changes: readonly {
    readonly kind: string;
    readonly joint?: string;
    readonly spring?: string;
    readonly body?: string;
    readonly skipped?: string;
  }[];
  readonly mechanisms: { readonly before: readonly string[]; readonly after: readonly string[] };
  readonly before: Totals | null;
  readonly after: Totals | null;
  readonly released: number;
  readonly lost: number;
  readonly work: number;
  readonly hardest: { readonly joint: string; readonly linear: number; readonly angular: number } | null;
  readonly duration_ns: number;
  /** Of a contact that closes, opens, slips or sticks: its bodies, its point (m), and its normal to the first body. */
  readonly bodies?: readonly string[];
  readonly point?: Vec3;
  readonly normal?: Vec3;
  /** On the first body (N s). */
  readonly impulse?: Vec3;
  /** Why contacts are stepped through from now on. */
  readonly reason?: string;
  /** The mechanisms of which that is true. */
  readonly stepped?: readonly string[];
  /** The share of its restitution that the impact has; absent: all of it. */
  readonly scaled?: number;
}

/** Values by frame; NaN if there is none at that time. */
export interface Column {
  readonly label: string;
  readonly unit: string;
  readonly values: ArrayLike<number>;
}

/** Quantities of the world and of joints that can be plotted. */
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

/** The members of summary.json (docs/results.md) that are shown; a run that was killed left only some of them. */
export interface Summary {
  readonly status: string;
  readonly version?: string;
  readonly scenario?: { readonly name: string };
  readonly method?: string;
  readonly step?: number;
  readonly steps?: number;
  readonly evaluations?: number;
  readonly topology_changes?: number;
  readonly real_time_factor?: number | null;
  readonly wall_clock?: Times;
  readonly energy?: Readonly<Record<string, number | null>> | null;
  readonly missed?: readonly Missed[];
  readonly warnings?: readonly string[];
}

/** A contact that is closed: its place (m), and the force on its first body (N). */
export interface ContactForce {
  readonly point: Vec3;
  readonly force: Vec3;
}

/** The motion of a run; it may grow while it is shown. */
export interface Motion {
  readonly model: Model;
  /** Present number of frames. */
  readonly frames: number;
  /** Time of a frame (s); never decreases from frame to frame. */
  time(frame: number): number;
  /** Of a frame: per body x, y, z, qw, qx, qy, qz of its frame in the world. Valid until the motion changes. */
  poses(frame: number): ArrayLike<number>;
  /** Whether the motion between a frame and the next is unknown: the run diverged there. */
  gapAfter?(frame: number): boolean;
  /** Of a frame; absent: contact forces are unknown. */
  contacts?(frame: number): readonly ContactForce[];
  readonly events: readonly RunEvent[];
  /** At least one; the first is valid from the start. */
  readonly phases: readonly Phase[];
  /** Names in the order of appearance; their indices determine their colours. */
  readonly mechanisms: readonly string[];
}

/** A complete run with its tables. */
export interface Recording extends Motion {
  /** Joints that have columns, by name. */
  readonly joints: readonly string[];
  /** Empty if the recording does not contain the quantity. */
  world(quantity: WorldQuantity): readonly Column[];
  joint(joint: string, quantity: JointQuantity): readonly Column[];
  readonly summary: Summary | null;
}
