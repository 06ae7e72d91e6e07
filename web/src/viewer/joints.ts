// Where joints are in the picture, and the lines to those that were made as loop joints in the run.
import type { Joint, Model, Vec3 } from "../recording";
import { pointOf } from "./frames";

interface Shown {
  readonly at: Vec3;
  /** Lines from a body to the joint. */
  readonly lines: readonly { readonly body: number; readonly from: Vec3; readonly to: Vec3 }[];
}

const minus = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const along = (a: Vec3, b: Vec3, share: number): Vec3 => [
  a[0] + share * (b[0] - a[0]),
  a[1] + share * (b[1] - a[1]),
  a[2] + share * (b[2] - a[2]),
];
const dot = (a: Vec3, b: Vec3) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** The point of a body's lines that is nearest to a point, in its axes; its centre of mass if it has none. */
function nearestDrawn(model: Model, body: number, point: Vec3): Vec3 {
  const { extent, com } = model.bodies[body];
  let best = com;
  let least = Infinity;
  for (const [from, to] of extent) {
    const line = minus(to, from);
    const length = dot(line, line);
    const near = along(from, to, length > 0 ? Math.min(Math.max(dot(minus(point, from), line) / length, 0), 1) : 0);
    const distance = Math.hypot(...minus(point, near));
    if (distance < least) [best, least] = [near, distance];
  }
  return best;
}

/**
 * Joints of the model are at their places, to which the lines of their bodies reach. Loop joints that were made in the run
 * have lines of their own. The place of a weld says nothing, and often is that of another joint: it is shown as a strut
 * between the centres of mass, with its mark in the middle.
 */
export function shownJoint(model: Model, joint: Joint, poses: ArrayLike<number>): Shown {
  const at = pointOf(poses, joint.child, joint.childAt);
  const made = (joint.loop || joint.wasLoop) && !model.joints.some(({ name, loop }) => loop && name === joint.name);
  if (!made) return { at, lines: [] };
  if (joint.kind === "weld" && joint.parent >= 0) {
    const from = pointOf(poses, joint.parent, model.bodies[joint.parent].com);
    const to = pointOf(poses, joint.child, model.bodies[joint.child].com);
    const middle = along(from, to, 0.5);
    return {
      at: middle,
      lines: [
        { body: joint.parent, from, to: middle },
        { body: joint.child, from: to, to: middle },
      ],
    };
  }
  const reach = (body: number, point: Vec3) => ({
    body,
    from: pointOf(poses, body, nearestDrawn(model, body, point)),
    to: pointOf(poses, body, point),
  });
  const lines = [reach(joint.child, joint.childAt), ...(joint.parent >= 0 ? [reach(joint.parent, joint.at)] : [])];
  return { at, lines: lines.filter(({ from, to }) => Math.hypot(...minus(from, to)) > 1e-9) };
}

/** The joints of a phase, after those of the phase before it. */
export function withHistory(joints: readonly Joint[], before: readonly Joint[]): Joint[] {
  const loops = new Set(before.filter(({ loop, wasLoop }) => loop || wasLoop).map(({ name }) => name));
  return joints.map((joint) => (!joint.loop && loops.has(joint.name) ? { ...joint, wasLoop: true } : joint));
}
