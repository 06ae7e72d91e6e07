// The initial view, before the motion is known: it includes all bodies, and some room around the joints that attach mechanisms
// to the ground. The camera follows what leaves it.
import * as THREE from "three";
import type { LiveRecording } from "../engine/live";
import type { Vec3 } from "../recording";
import { cornersOf, viewOf, type View } from "../viewer/camera";
import { inboardJoints, phaseAt, pointOf } from "../viewer/frames";
import type { ShapeLibrary } from "../viewer/shapes";

const distance = (a: Vec3, b: Vec3) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

export function initialView(run: LiveRecording, frame: number, shapes: Pick<ShapeLibrary, "bounds" | "reach">): View {
  const poses = run.poses(frame);
  const { bodies } = run.model;
  const { joints } = phaseAt(run, run.time(frame));
  const inboard = inboardJoints(joints);
  const view = viewOf(run, (body) => shapes.bounds(body));
  const along = (["x", "y", "z"] as const).filter((axis) => Math.abs(view.direction[axis]) > 0.99);
  /** The room around the joint at the ground, as a share of the length of the stretched mechanism. */
  const room = along.length > 0 ? 0.5 : 0.25;
  const box = new THREE.Box3();
  const at = new THREE.Vector3();
  const include = (point: readonly number[], radius: number) => {
    at.set(point[0], point[1], point[2]);
    box.expandByPoint(at.clone().addScalar(radius));
    box.expandByPoint(at.addScalar(-radius));
  };
  const anchors: { at: Vec3; length: number }[] = [];
  bodies.forEach((body, b) => {
    include(pointOf(poses, b, body.com), 0);
    for (const line of body.extent) for (const end of line) include(pointOf(poses, b, end), 0);
    // Length of the stretched mechanism from the ground to this body.
    let length = shapes.reach(b);
    for (const line of body.extent) length = Math.max(length, distance(...line));
    let joint = inboard.get(b);
    for (let count = 1; joint && joint.parent >= 0 && count <= bodies.length; count++) {
      const next = inboard.get(joint.parent);
      length += distance(joint.at, next?.childAt ?? [0, 0, 0]);
      joint = next;
    }
    for (const { x, y, z } of cornersOf(shapes.bounds(b))) include(pointOf(poses, b, [x, y, z]), 0);
    if (joint && joint.kind !== "free") anchors.push({ at: pointOf(poses, joint.child, joint.childAt), length });
  });
  const heights = cornersOf(box).map((corner) => corner.dot(view.up));
  const [bottom, top] = [Math.min(...heights), Math.max(...heights)];
  const stands = anchors.some(({ at: [x, y, z] }) => at.set(x, y, z).dot(view.up) < bottom + 0.25 * (top - bottom));
  for (const anchor of anchors) include(anchor.at, room * anchor.length);
  // A planar motion that is seen along its normal needs no depth.
  for (const axis of along) {
    box.min[axis] = view.box.min[axis];
    box.max[axis] = view.box.max[axis];
  }
  // The floor is where mechanisms stand on it, or else below everything that is in the picture.
  const lowest = stands ? bottom : Math.min(...cornersOf(box).map((corner) => corner.dot(view.up)));
  const radius = Math.max(0.5 * box.getSize(new THREE.Vector3()).length(), 1e-3);
  return { ...view, box, radius, lowest, centre: box.getCenter(new THREE.Vector3()) };
}
