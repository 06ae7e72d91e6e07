// Poses of a model's bodies from the coordinates of its joints (docs/scenario.md defines the coordinates).
import type { Joint, JointKind, Model, Pose, Vec3 } from "../recording";
import { about, compose, inverse, product, scaled, unit } from "./rotations";

const z: Vec3 = [0, 0, 1];

function direction(axis: Vec3 | undefined): Vec3 {
  const v = axis ?? z;
  return scaled(v, 1 / Math.hypot(...v));
}

/** Pose of the joint's frame on the child's side in its frame on the parent's side. */
export function motion(joint: Pick<Joint, "kind" | "axis" | "axis2" | "pitch">, q: ArrayLike<number>): Pose {
  const axis = direction(joint.axis);
  switch (joint.kind) {
    case "revolute":
      return { xyz: [0, 0, 0], quat: about(axis, q[0]) };
    case "prismatic":
      return { xyz: scaled(axis, q[0]), quat: unit.quat };
    case "helical":
      return { xyz: scaled(axis, ((joint.pitch ?? 0) * q[0]) / (2 * Math.PI)), quat: about(axis, q[0]) };
    case "cylindrical":
      return { xyz: scaled(axis, q[1]), quat: about(axis, q[0]) };
    case "universal":
      return { xyz: [0, 0, 0], quat: product(about(axis, q[0]), about(direction(joint.axis2), q[1])) };
    case "ball":
      return { xyz: [0, 0, 0], quat: [q[0], q[1], q[2], q[3]] };
    case "planar":
      return { xyz: [q[0], q[1], 0], quat: about(z, q[2]) };
    case "free":
      return { xyz: [q[0], q[1], q[2]], quat: [q[3], q[4], q[5], q[6]] };
    case "weld":
      return unit;
  }
}

/** Coordinates at which the joint's displacement is zero. */
export function zero(kind: JointKind): number[] {
  const sizes: Record<JointKind, number> = {
    revolute: 1,
    prismatic: 1,
    helical: 1,
    cylindrical: 2,
    universal: 2,
    ball: 4,
    planar: 3,
    free: 7,
    weld: 0,
  };
  const q = new Array<number>(sizes[kind]).fill(0);
  if (kind === "ball") q[0] = 1;
  if (kind === "free") q[3] = 1;
  return q;
}

/** Per body x, y, z, qw, qx, qy, qz of its frame in the world. `coordinates`: by joint name; absent ones are zero. */
export function posesOf(model: Model, coordinates: ReadonlyMap<string, ArrayLike<number>>): Float64Array {
  const inboard = new Map(model.joints.map((joint) => [joint.child, joint]));
  const placed = new Map<number, Pose>();
  const place = (body: number): Pose => {
    const known = placed.get(body);
    if (known) return known;
    const chain: Joint[] = []; // not recursive, because chains may be long
    let parent = body;
    for (let joint = inboard.get(parent); joint && !placed.has(parent); joint = inboard.get(parent)) {
      chain.push(joint);
      parent = joint.parent;
      if (parent < 0) break;
    }
    let pose: Pose = placed.get(parent) ?? unit;
    for (const joint of chain.reverse()) {
      const moved = motion(joint, coordinates.get(joint.name) ?? zero(joint.kind));
      pose = compose(compose(compose(pose, joint.at), moved), inverse(joint.childAt));
      placed.set(joint.child, pose);
    }
    return pose;
  };
  const poses = new Float64Array(7 * model.bodies.length);
  model.bodies.forEach((_body, b) => {
    const { xyz, quat } = place(b);
    poses.set([...xyz, ...quat], 7 * b);
  });
  return poses;
}
