// Vectors of a motion as arrows: momenta of bodies by the difference of two frames, and forces of joints.
import * as THREE from "three";
import type { Joint, Motion } from "../recording";
import type { Arrow } from "./arrows";
import { frameAt, isGap, phaseAt, pointOf } from "./frames";
import { shownJoint } from "./joints";

/** Between the frames around a time (or the last two before it), of each body at its centre of mass: mass times mean velocity. */
export function momentaAt(run: Motion, time: number, poses: ArrayLike<number>): Arrow[] {
  let frame = frameAt(run, time);
  if (frame + 1 >= run.frames) frame = run.frames - 2;
  if (frame < 0 || isGap(run, frame)) return [];
  const [a, b] = [run.poses(frame), run.poses(frame + 1)];
  const span = run.time(frame + 1) - run.time(frame);
  if (!(span > 0)) return [];
  return run.model.bodies.flatMap(({ mass, com }, body) => {
    const [from, to] = [pointOf(a, body, com), pointOf(b, body, com)];
    const vector = new THREE.Vector3(...to).sub(new THREE.Vector3(...from)).multiplyScalar(mass / span);
    return Number.isFinite(vector.lengthSq()) ? [{ from: new THREE.Vector3(...pointOf(poses, body, com)), vector }] : [];
  });
}

/** Of each joint for which `of` knows it: the force on its child, given in the child's axes. */
export function forcesAt(
  run: Motion,
  time: number,
  poses: ArrayLike<number>,
  of: (joint: Joint) => readonly number[] | null,
): Arrow[] {
  return phaseAt(run, time).joints.flatMap((joint) => {
    const force = joint.kind === "free" ? null : of(joint);
    if (!force || !force.every(Number.isFinite)) return [];
    const i = 7 * joint.child;
    const turn = new THREE.Quaternion(poses[i + 4], poses[i + 5], poses[i + 6], poses[i + 3]);
    const vector = new THREE.Vector3(force[0], force[1], force[2]).applyQuaternion(turn);
    return [{ from: new THREE.Vector3(...shownJoint(run.model, joint, poses).at), vector }];
  });
}
