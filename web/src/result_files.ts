// The documents of a result that pages read: model.json, and the topology records of events.jsonl (docs/results.md).
import { partsFrom, type Meshes } from "./meshes";
import { withHistory } from "./viewer/joints";
import type { Joint, Model, Phase, Plane, Pose, RunEvent, Shape, Spring, Vec3 } from "./recording";

interface JointFile {
  kind: string;
  parent: string | null;
  child: string;
  at: Pose;
  child_at: Pose;
  locked?: boolean | boolean[];
  loop?: boolean;
}

interface SpringFile {
  from: { body: string; point: Vec3 };
  to: { body: string; point: Vec3 };
  stiffness: number;
  rest: number;
  tension_only: boolean;
  inextensible?: boolean;
  strength: number | null;
  broken: boolean;
}

export interface ModelFile {
  title: string;
  gravity: Vec3;
  mechanisms: { name: string; bodies: string[] }[];
  bodies: Record<
    string,
    {
      mass: number;
      com: Vec3;
      inertia?: number[];
      extent: [Vec3, Vec3][];
      shape: ShapeFile | null;
      more_shapes?: ShapeFile[];
      /** Meshes that the engine could not read, which this page may have: shapes that touch are drawn in their place. */
      missing_shapes?: Shape[];
    }
  >;
  joints: Record<string, JointFile>;
  springs?: Record<string, SpringFile>;
  planes?: Plane[];
  ground?: ShapeFile[];
}

/** Meshes of the ground, and shapes of bodies that pages have no other way to draw, have their points and triangles here. */
type ShapeFile = Shape & { points?: Vec3[]; triangles?: Vec3[] };

function shapeOf({ points, triangles, ...shape }: ShapeFile): Shape {
  if (!points) return shape;
  const positions = Float32Array.from(points.flat());
  return { ...shape, parts: [{ positions, triangles: Uint16Array.from((triangles ?? []).flat()) }] };
}

export interface EventFile extends RunEvent {
  topology?: {
    gone: string[];
    joints: Record<string, JointFile>;
    moved: Record<string, [first: number, count: number][]>;
    broken_springs?: string[];
  };
}

/** Joints of which the child is among the bodies. */
function jointsOf(file: Record<string, JointFile>, bodies: ReadonlyMap<string, number>): Joint[] {
  const joints = Object.entries(file).map(([name, joint]) => ({
    name,
    kind: joint.kind,
    parent: joint.parent === null ? -1 : (bodies.get(joint.parent) ?? -1),
    child: bodies.get(joint.child) ?? -1,
    at: joint.at.xyz,
    childAt: joint.child_at.xyz,
    locked: joint.locked === true,
    ...(joint.loop && { loop: true }),
  }));
  return joints.filter(({ child }) => child >= 0);
}

/** Springs that act, of which both ends are on the ground or among the bodies. */
function springsOf(file: Record<string, SpringFile>, bodies: ReadonlyMap<string, number>): Spring[] {
  const known = (body: string) => body === "ground" || bodies.has(body);
  return Object.entries(file)
    .filter(([, { from, to, broken }]) => !broken && known(from.body) && known(to.body))
    .map(([name, { from, to, stiffness, rest, tension_only, inextensible, strength }]) => ({
      name,
      from: bodies.get(from.body) ?? -1,
      to: bodies.get(to.body) ?? -1,
      fromPoint: from.point,
      toPoint: to.point,
      stiffness,
      rest,
      tensionOnly: tension_only,
      ...(inextensible && { inextensible }),
      strength,
    }));
}

const numbered = (names: readonly string[]) => new Map(names.map((name, b) => [name, b]));

/** `names`: of the bodies, in the order in which they are numbered. `meshes`: those that shapes refer to. */
export function modelOf(file: ModelFile, names: readonly string[] = Object.keys(file.bodies), meshes?: Meshes): Model {
  const partsOf = partsFrom(meshes);
  const bodies = names.map((name) => {
    const body = file.bodies[name];
    const missing = body?.missing_shapes?.filter((shape) => partsOf(shape).length > 0) ?? [];
    const given = missing.length > 0 ? missing : [body?.shape, ...(body?.more_shapes ?? [])];
    const shapes = given.filter((shape): shape is ShapeFile => Boolean(shape));
    const drawn = shapes.map((shape) => (shape.kind === "mesh" ? { ...shape, parts: partsOf(shape) } : shapeOf(shape)));
    const { mass, com, inertia, extent } = body ?? {};
    return { name, mass: mass ?? 0, com: com ?? [0, 0, 0], ...(inertia && { inertia }), extent: extent ?? [], shapes: drawn };
  });
  const numbers = numbered(names);
  const [joints, springs] = [jointsOf(file.joints, numbers), springsOf(file.springs ?? {}, numbers)];
  const planes = file.planes && { planes: file.planes };
  const ground = file.ground && { ground: file.ground.map(shapeOf) };
  return { title: file.title, gravity: file.gravity, bodies, joints, springs, ...planes, ...ground };
}

/** The phases of a run, and its mechanisms in the order of appearance. */
export function phasesOf(file: ModelFile, model: Model, events: readonly EventFile[]) {
  const bodies = numbered(model.bodies.map(({ name }) => name));
  const mechanisms = new Map<string, number>();
  const numberOf = (name: string) => {
    if (!mechanisms.has(name)) mechanisms.set(name, mechanisms.size);
    return mechanisms.get(name)!;
  };
  const atStart = new Map(file.mechanisms.flatMap(({ name, bodies: members }) => members.map((body) => [body, name])));
  let mechanism = Int32Array.from(model.bodies, ({ name }) => numberOf(atStart.get(name) ?? name));
  let joints = model.joints;
  let springs = model.springs ?? [];
  const phases: Phase[] = [{ from: 0, mechanism, joints, springs }];
  for (const { time, topology } of events) {
    if (!topology) continue;
    const replaced = new Set([...topology.gone, ...Object.keys(topology.joints)]);
    const changed = withHistory(jointsOf(topology.joints, bodies), joints);
    joints = [...joints.filter(({ name }) => !replaced.has(name)), ...changed];
    mechanism = mechanism.slice();
    for (const [name, ranges] of Object.entries(topology.moved))
      for (const [first, count] of ranges) mechanism.fill(numberOf(name), first, first + count);
    const broken = topology.broken_springs;
    if (broken) springs = springs.filter(({ name }) => !broken.includes(name));
    phases.push({ from: time, mechanism, joints, springs });
  }
  return { phases, mechanisms: [...mechanisms.keys()] };
}
