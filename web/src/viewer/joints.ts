// Where joints are in the picture, and the lines to those that were made in the run.
import type { Joint, Model, Vec3 } from "../recording";
import { pointOf } from "./frames";
import { along, areApart, linesOf, minus, nearestOn } from "./gap";

interface Shown {
  readonly at: Vec3;
  /** Lines from a body to the joint. */
  readonly lines: readonly { readonly body: number; readonly from: Vec3; readonly to: Vec3 }[];
}

/** Whether a weld was made in the run, between bodies that do not touch, or to close a loop. */
function isStrut(model: Model, joint: Joint, poses: ArrayLike<number>): boolean {
  if (joint.kind !== "weld" || joint.parent < 0) return false;
  const ofModel = ({ name, kind, parent, child }: Joint) =>
    name === joint.name &&
    kind === "weld" &&
    ((parent === joint.parent && child === joint.child) || (parent === joint.child && child === joint.parent));
  if (model.joints.some(ofModel)) return false;
  return (joint.loop || joint.wasLoop) === true || areApart(model, joint.parent, joint.child, poses);
}

/**
 * Joints of the model are at their places, to which the lines of their bodies reach. Loop joints that were made in the run
 * have lines of their own. The place of a weld says nothing, and often is that of another joint: if it was made in the run,
 * and its bodies do not touch, it is shown as a strut between the centres of mass, with its mark in the middle.
 */
export function shownJoint(model: Model, joint: Joint, poses: ArrayLike<number>): Shown {
  const at = pointOf(poses, joint.child, joint.childAt);
  if (isStrut(model, joint, poses)) {
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
  const made = (joint.loop || joint.wasLoop) && !model.joints.some(({ name, loop }) => loop && name === joint.name);
  if (!made) return { at, lines: [] };
  const reach = (body: number, point: Vec3) => {
    const to = pointOf(poses, body, point);
    return { body, from: nearestOn(linesOf(model, body, poses), to), to };
  };
  const lines = [reach(joint.child, joint.childAt), ...(joint.parent >= 0 ? [reach(joint.parent, joint.at)] : [])];
  return { at, lines: lines.filter(({ from, to }) => Math.hypot(...minus(from, to)) > 1e-9) };
}

/** The joints of a phase, after those of the phase before it. */
export function withHistory(joints: readonly Joint[], before: readonly Joint[]): Joint[] {
  const loops = new Set(before.filter(({ loop, wasLoop }) => loop || wasLoop).map(({ name }) => name));
  return joints.map((joint) => (!joint.loop && loops.has(joint.name) ? { ...joint, wasLoop: true } : joint));
}
