// Makes a Recording from the data of a report, as momentree writes them into the page.
import type { Meshes } from "../meshes";
import type { Column, ContactForce, JointQuantity, Recording, Summary, WorldQuantity } from "../recording";
import { modelOf, phasesOf, type EventFile, type ModelFile } from "../result_files";
import { column, doubles, floats } from "./tables";

export interface ContactRows {
  counts: number[];
  rows: string;
}

export interface ReportData {
  format: 1;
  thinned: boolean;
  joints_left_out: boolean;
  /** In the order of `poses`. */
  bodies: string[];
  /** By kind of joint, the units of its coordinates, velocities and momenta. */
  kinds: Record<string, Record<"q" | "v" | "p", string[]>>;
  model: ModelFile;
  meshes?: Meshes;
  events: EventFile[];
  summary: Summary | null;
  frames: number;
  time: string;
  poses: string;
  /** Rows of these columns (docs/results.md), f32. */
  joints?: { columns: string[]; rows: string };
  /** How many contacts are closed at each frame, and of each contactWidth numbers, f32. */
  contacts?: ContactRows;
  /** Rows of energy.csv without their time, f64. */
  energy?: { columns: string[]; rows: string };
}

/** Per contact: point, normal, force on the first body, speed of slip. */
const contactWidth = 10;

/** By frame, the forces of the contacts that are closed. */
function contactsOf({ counts, rows }: ContactRows): (frame: number) => ContactForce[] {
  const numbers = floats(rows);
  const ends: number[] = [];
  for (const count of counts) ends.push((ends[ends.length - 1] ?? 0) + count);
  return (frame) => {
    const count = counts[frame] ?? 0;
    return Array.from({ length: count }, (_, k) => {
      const [x, y, z, , , , fx, fy, fz] = numbers.subarray(contactWidth * (ends[frame] - count + k));
      return { point: [x, y, z], force: [fx, fy, fz] };
    });
  };
}

const energyColumns: Record<WorldQuantity, { unit: string; names: readonly string[] }> = {
  energy: { unit: "J", names: ["kinetic", "gravity", "elastic", "dissipated", "lost", "released", "work"] },
  balance: { unit: "J", names: ["error"] },
  linear: { unit: "N s", names: ["linear.x", "linear.y", "linear.z"] },
  angular: { unit: "N m s", names: ["angular.x", "angular.y", "angular.z"] },
};
const jointColumns: Record<JointQuantity, RegExp> = {
  q: /^q\d+$/,
  v: /^v\d+$/,
  p: /^p\d+$/,
  force: /^f[xyz]$/,
  torque: /^m[xyz]$/,
};

export function recordingOf(data: ReportData): Recording {
  const model = modelOf(data.model, data.bodies, data.meshes);
  const { phases, mechanisms } = phasesOf(data.model, model, data.events);
  const time = doubles(data.time);
  const poses = floats(data.poses);
  const width = 7 * model.bodies.length;
  const energy = data.energy && { columns: data.energy.columns, values: doubles(data.energy.rows) };
  const table = data.joints && { columns: data.joints.columns, values: floats(data.joints.rows) };
  const columnsOf = new Map<string, { label: string; place: number }[]>();
  table?.columns.forEach((name, place) => {
    const dot = name.lastIndexOf(".");
    const joint = name.slice(0, dot);
    if (!columnsOf.has(joint)) columnsOf.set(joint, []);
    columnsOf.get(joint)!.push({ label: name.slice(dot + 1), place });
  });
  const kindsOf = new Map<string, Set<string>>();
  for (const { name, kind } of phases.flatMap(({ joints }) => joints))
    kindsOf.set(name, (kindsOf.get(name) ?? new Set()).add(kind));
  /** Empty if the column has different units for different kinds of the joint. */
  const unitOf = (joint: string, quantity: JointQuantity, index: number): string => {
    if (quantity === "force") return "N";
    if (quantity === "torque") return "N m";
    const units = new Set([...(kindsOf.get(joint) ?? [])].flatMap((kind) => data.kinds[kind]?.[quantity][index] ?? []));
    return units.size === 1 ? [...units][0] : "";
  };

  const diverged = data.summary?.status.startsWith("diverged") ?? false;
  return {
    model,
    frames: data.frames,
    time: (frame) => time[frame],
    poses: (frame) => poses.subarray(frame * width, (frame + 1) * width),
    gapAfter: (frame) => diverged && frame >= data.frames - 2,
    events: data.events,
    phases,
    mechanisms,
    joints: [...columnsOf.keys()],
    world: (quantity): Column[] => {
      const { unit, names } = energyColumns[quantity];
      return names.flatMap((label) => {
        const place = energy?.columns.indexOf(label) ?? -1;
        return place < 0 ? [] : [{ label, unit, values: column(energy!.values, energy!.columns.length, place) }];
      });
    },
    joint: (joint, quantity) =>
      (columnsOf.get(joint) ?? [])
        .filter(({ label }) => jointColumns[quantity].test(label))
        .map(({ label, place }) => ({
          label,
          unit: unitOf(joint, quantity, Number(label.slice(1))),
          values: column(table!.values, table!.columns.length, place),
        })),
    summary: data.summary,
    ...(data.contacts && { contacts: contactsOf(data.contacts) }),
  };
}
