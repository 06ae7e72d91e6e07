// Makes a Recording from the data of a report, as momentree writes them into the page.
import type {
  Body,
  Column,
  Joint,
  JointKind,
  JointQuantity,
  Link,
  Model,
  Phase,
  Pose,
  Recording,
  RunEvent,
  Shape,
  Summary,
  Vec3,
  WorldQuantity,
} from "../recording";
import { coordinatesOf, jointUnit, worldUnit } from "./units";
import { column, doubles, floats } from "./tables";

interface ModelFile {
  title: string;
  gravity: Vec3;
  bodies: Record<string, { mass: number; com: Vec3; extent: [Vec3, Vec3][]; shape: Shape | null; more_shapes?: Shape[] }>;
  joints: Record<
    string,
    {
      kind: JointKind;
      parent: string | null;
      child: string;
      at: Pose;
      child_at: Pose;
      axis?: Vec3;
      axis2?: Vec3;
      pitch?: number;
    }
  >;
}

/**
 * A phase: joints that no longer exist, joints that were made or changed; mechanisms by body as run lengths of equal
 * numbers.
 */
interface PhaseData {
  from: number;
  mechanism: [count: number, mechanism: number][];
  gone?: string[];
  joints?: Link[];
}

interface EventFile extends Omit<RunEvent, "name" | "durationNs" | "bodies"> {
  event: string;
  duration_ns: number;
}

interface SummaryFile {
  status: string;
  version?: string;
  scenario?: { name: string; title: string };
  method?: string;
  step?: number;
  steps?: number;
  evaluations?: number;
  topology_changes?: number;
  real_time_factor?: number | null;
  wall_clock?: Summary["times"];
  energy?: Summary["energy"];
  missed?: Summary["missed"];
  warnings?: Summary["warnings"];
}

export interface ReportData {
  format: 1;
  /** A model to be posed by hand: its joints get sliders. */
  pose: boolean;
  thinned: boolean;
  joints_left_out: boolean;
  bodies: string[];
  model: ModelFile;
  events: EventFile[];
  /** By event, the bodies affected by it. */
  about: number[][];
  summary: SummaryFile | null;
  mechanisms: string[];
  phases: PhaseData[];
  frames: number;
  time: string;
  poses: string;
  /** Rows of these columns (docs/results.md), f32. */
  joints?: { columns: string[]; rows: string };
  /** Rows of energy.csv without their time, f64. */
  energy?: { columns: string[]; rows: string };
}

export function modelOf(file: ModelFile, names: readonly string[]): Model {
  const number = new Map(names.map((name, b) => [name, b]));
  const bodies: Body[] = names.map((name) => {
    const body = file.bodies[name];
    const shapes = [body?.shape, ...(body?.more_shapes ?? [])].filter((shape): shape is Shape => Boolean(shape));
    return { name, mass: body?.mass ?? 0, com: body?.com ?? [0, 0, 0], extent: body?.extent ?? [], shapes };
  });
  const joints: Joint[] = Object.entries(file.joints).map(([name, joint]) => ({
    ...joint,
    name,
    parent: joint.parent === null ? -1 : (number.get(joint.parent) ?? -1),
    child: number.get(joint.child) ?? -1,
    childAt: joint.child_at,
  }));
  return { title: file.title, gravity: file.gravity, bodies, joints: joints.filter((joint) => joint.child >= 0) };
}

export const linkOf = (joint: Joint): Link => ({
  joint: joint.name,
  kind: joint.kind,
  parent: joint.parent,
  child: joint.child,
  at: joint.at.xyz,
  childAt: joint.childAt.xyz,
});

function phasesOf(data: readonly PhaseData[], model: Model): Phase[] {
  let links = model.joints.map(linkOf);
  return data.map((phase) => {
    const mechanism = new Int32Array(model.bodies.length);
    let body = 0;
    for (const [count, number] of phase.mechanism) mechanism.fill(number, body, (body += count));
    const replaced = new Set([...(phase.gone ?? []), ...(phase.joints ?? []).map((link) => link.joint)]);
    if (replaced.size > 0) links = [...links.filter((link) => !replaced.has(link.joint)), ...(phase.joints ?? [])];
    return { from: phase.from, mechanism, links };
  });
}

const summaryOf = (file: SummaryFile): Summary => ({
  status: file.status,
  version: file.version ?? "",
  scenario: file.scenario?.name ?? "",
  method: file.method ?? "",
  step: file.step ?? 0,
  steps: file.steps ?? 0,
  evaluations: file.evaluations ?? 0,
  changes: file.topology_changes ?? 0,
  realTimeFactor: file.real_time_factor ?? null,
  times: file.wall_clock ?? null,
  energy: file.energy ?? null,
  missed: file.missed ?? [],
  warnings: file.warnings ?? [],
});

const energyColumns: Record<WorldQuantity, readonly string[]> = {
  energy: ["kinetic", "gravity", "elastic", "dissipated", "lost", "released", "work"],
  balance: ["error"],
  linear: ["linear.x", "linear.y", "linear.z"],
  angular: ["angular.x", "angular.y", "angular.z"],
};
const jointColumns: Record<JointQuantity, RegExp> = {
  q: /^q\d+$/,
  v: /^v\d+$/,
  p: /^p\d+$/,
  force: /^f[xyz]$/,
  torque: /^m[xyz]$/,
};

export function recordingOf(data: ReportData): Recording {
  const model = modelOf(data.model, data.bodies);
  const time = doubles(data.time);
  const poses = floats(data.poses);
  const width = 7 * model.bodies.length;
  const energy = data.energy && { ...data.energy, values: doubles(data.energy.rows) };
  const table = data.joints && { ...data.joints, values: floats(data.joints.rows) };
  const kindOf = new Map(model.joints.map((joint) => [joint.name, joint.kind]));
  // Columns that exceed the joint's initial number of coordinates may contain several kinds: they have no unit.
  const kindOfColumns = (joint: string): JointKind | undefined => {
    const wide = (places.get(joint) ?? []).filter(({ label }) => jointColumns.q.test(label)).length;
    const kind = kindOf.get(joint) ?? (wide === 7 ? "free" : undefined);
    return kind && coordinatesOf(kind) === wide ? kind : undefined;
  };
  const places = new Map<string, { label: string; place: number }[]>();
  table?.columns.forEach((name, place) => {
    const dot = name.lastIndexOf(".");
    const joint = name.slice(0, dot);
    if (!places.has(joint)) places.set(joint, []);
    places.get(joint)!.push({ label: name.slice(dot + 1), place });
  });
  const columnsOf = (
    source: { columns: string[]; values: Float64Array } | undefined,
    names: readonly string[],
    unit: string,
  ): Column[] =>
    !source
      ? []
      : names
          .filter((name) => source.columns.includes(name))
          .map((name) => ({
            label: name,
            unit,
            values: column(source.values, source.columns.length, source.columns.indexOf(name)),
          }));

  const diverged = data.summary?.status.startsWith("diverged") ?? false;
  return {
    model,
    frames: data.frames,
    revision: 0,
    time: (frame) => time[frame],
    poses: (frame) => poses.subarray(frame * width, (frame + 1) * width),
    gapAfter: (frame) => diverged && frame >= data.frames - 2,
    events: data.events.map((event, i) => ({
      ...event,
      name: event.event,
      durationNs: event.duration_ns,
      bodies: data.about[i] ?? [],
    })),
    phases: phasesOf(data.phases, model),
    mechanisms: data.mechanisms,
    joints: [...places.keys()],
    world: (quantity) => columnsOf(energy, energyColumns[quantity], worldUnit(quantity)),
    joint: (joint, quantity) =>
      (places.get(joint) ?? [])
        .filter(({ label }) => jointColumns[quantity].test(label))
        .map(({ label, place }) => ({
          label,
          unit: jointUnit(kindOfColumns(joint), quantity, Number(label.slice(1))),
          values: column(table!.values, table!.columns.length, place),
        })),
    summary: data.summary && summaryOf(data.summary),
  };
}
