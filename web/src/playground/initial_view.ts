// The initial view, before the motion is known: it includes all bodies and everything that attached mechanisms can
// reach.
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
  // The box around a ball has corners outside the ball: seen obliquely, it is much wider.
  const corners = along.length > 0 ? 1 : 0.65;
  const box = new THREE.Box3();
  const at = new THREE.Vector3();
  const include = (point: readonly number[], radius: number) => {
    at.set(point[0], point[1], point[2]);
    box.expandByPoint(at.clone().addScalar(radius));
    box.expandByPoint(at.addScalar(-radius));
  };
  bodies.forEach((body, b) => {
    include(pointOf(poses, b, body.com), 0);
    for (const line of body.extent) for (const end of line) include(pointOf(poses, b, end), 0);
    // Length of the stretched mechanism from the ground to this body.
    let length = shapes.reach(b);
    for (const line of body.extent) length = Math.max(length, distance(...line));
    let joint = inboard.get(b);
    let count = 1;
    for (; joint && joint.parent >= 0 && count <= bodies.length; count++) {
      const next = inboard.get(joint.parent);
      length += distance(joint.at, next?.childAt ?? [0, 0, 0]);
      joint = next;
    }
    // Long chains are seldom fully stretched: half of the length is enough.
    const share = corners * (0.5 + 0.5 * Math.min(1, 4 / count));
    if (joint && joint.kind !== "free") include(pointOf(poses, joint.child, joint.childAt), share * length);
    else for (const { x, y, z } of cornersOf(shapes.bounds(b))) include(pointOf(poses, b, [x, y, z]), 0);
  });
  // A planar motion that is seen along its normal needs no depth.
  for (const axis of along) {
    box.min[axis] = view.box.min[axis];
    box.max[axis] = view.box.max[axis];
  }
  // The floor is below everything that is in the picture.
  const lowest = [box.min, box.max].reduce((sum, corner) => sum.add(corner), new THREE.Vector3()).dot(view.up) / 2;
  const size = box.getSize(new THREE.Vector3());
  const half = 0.5 * size.toArray().reduce((sum, extent, k) => sum + extent * Math.abs(view.up.getComponent(k)), 0);
  const radius = Math.max(0.5 * size.length(), 1e-3);
  return { ...view, box, radius, lowest: lowest - half, centre: box.getCenter(new THREE.Vector3()) };
}
