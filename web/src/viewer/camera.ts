// The initial view: the whole motion in the picture, gravity down; planar motion is seen along the plane's normal.
import * as THREE from "three";
import { massOf, type Model, type Motion } from "../recording";
import { phaseAt } from "./frames";
import { endsOf } from "./springs";

export interface View {
  readonly box: THREE.Box3;
  readonly centre: THREE.Vector3;
  readonly radius: number;
  /** From the centre towards the camera. */
  readonly direction: THREE.Vector3;
  readonly up: THREE.Vector3;
  /** Height of the floor along `up` (m). */
  readonly lowest: number;
}

export function upOf(model: Model): THREE.Vector3 {
  const gravity = new THREE.Vector3(...model.gravity);
  return gravity.lengthSq() > 0 ? gravity.normalize().negate() : new THREE.Vector3(0, 0, 1);
}

/** Bodies of mechanisms that are attached to the ground at a time. */
function attachedBodies(run: Motion, time: number): Set<number> {
  const phase = phaseAt(run, time);
  const grounded = phase.joints.filter(({ parent, kind }) => parent < 0 && kind !== "free");
  const mechanisms = new Set(grounded.map(({ child }) => phase.mechanism[child]));
  return new Set(run.model.bodies.map((_body, b) => b).filter((b) => mechanisms.has(phase.mechanism[b])));
}

/** Light bodies that go so far that all others would be tiny, such as the finger of a gripper that slides out of it: their mass
 * is at most 2 % of all, and without them the box around all is at most a third as large. */
function lightAndFar(run: Motion, boxes: readonly THREE.Box3[]): Set<number> {
  const around = (bodies: readonly number[]) => bodies.reduce((all, b) => all.union(boxes[b]), new THREE.Box3());
  const diagonal = (box: THREE.Box3) => (box.isEmpty() ? 0 : box.getSize(new THREE.Vector3()).length());
  const present = run.model.bodies.map((_body, b) => b).filter((b) => !boxes[b].isEmpty());
  const heaviest = present.reduce((a, b) => (run.model.bodies[b].mass > run.model.bodies[a].mass ? b : a), present[0]);
  if (heaviest === undefined) return new Set();
  const centre = boxes[heaviest].getCenter(new THREE.Vector3());
  const distance = (b: number) => Math.max(boxes[b].min.distanceTo(centre), boxes[b].max.distanceTo(centre));
  const farthestFirst = [...present].sort((a, b) => distance(b) - distance(a));
  let spare = 0.02 * massOf(run.model.bodies);
  let left = 0;
  while (left < farthestFirst.length && run.model.bodies[farthestFirst[left]].mass <= spare)
    spare -= run.model.bodies[farthestFirst[left++]].mass;
  const rest = diagonal(around(farthestFirst.slice(left)));
  return new Set(rest > 0 && diagonal(around(present)) > 3 * rest ? farthestFirst.slice(0, left) : []);
}

/** The corners of a box; none if it is empty. */
export function cornersOf({ min, max }: THREE.Box3): THREE.Vector3[] {
  if (min.x > max.x) return [];
  return [0, 1, 2, 3, 4, 5, 6, 7].map(
    (i) => new THREE.Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z),
  );
}

/** The box around the origins of bodies and the corners of their shapes, over some frames; `corners`: by body, in its axes. */
function boxOf(run: Motion, corners: readonly THREE.Vector3[][], most = 40): THREE.Box3 {
  const boxes = run.model.bodies.map(() => new THREE.Box3());
  const points = run.model.bodies.map((body, b) => [
    new THREE.Vector3(),
    ...body.extent.flatMap((line) => line.map((end) => new THREE.Vector3(...end))),
    ...corners[b],
  ]);
  const placed = new THREE.Vector3();
  const detached: THREE.Vector3[] = [];
  const step = Math.max(1, Math.floor(run.frames / most));
  const turn = new THREE.Quaternion();
  const anchored = run.frames > 0 && attachedBodies(run, run.time(0)).size > 0;
  for (let frame = 0; frame < run.frames; frame += step) {
    const poses = run.poses(frame);
    const attached = anchored ? attachedBodies(run, run.time(frame)) : null;
    run.model.bodies.forEach((_body, b) => {
      const i = 7 * b;
      if (Number.isNaN(poses[i])) return;
      turn.set(poses[i + 4], poses[i + 5], poses[i + 6], poses[i + 3]);
      const origin = new THREE.Vector3(poses[i], poses[i + 1], poses[i + 2]);
      for (const point of points[b]) {
        placed.copy(point).applyQuaternion(turn).add(origin);
        if (attached && !attached.has(b)) detached.push(placed.clone());
        else boxes[b].expandByPoint(placed);
      }
    });
  }
  const box = new THREE.Box3();
  const light = lightAndFar(run, boxes);
  boxes.forEach((own, b) => {
    if (light.has(b)) detached.push(own.min, own.max);
    else box.union(own);
  });
  if (run.frames > 0)
    for (const spring of run.model.springs ?? [])
      for (const end of endsOf(spring, run.poses(0))) if (!Number.isNaN(end.x)) box.expandByPoint(end);
  // Parts that fly off are followed for some distance, but not so far that the remaining bodies become tiny.
  const centre = box.getCenter(new THREE.Vector3());
  const far = 2.5 * box.getSize(new THREE.Vector3()).length();
  for (const point of detached) if (point.distanceTo(centre) < far) box.expandByPoint(point);
  return box;
}

/** The whole run, or the frames available so far; `bounds`: of a body's shapes, in its axes. */
export function viewOf(run: Motion, bounds: (body: number) => THREE.Box3): View {
  const up = upOf(run.model);
  const corners = run.model.bodies.map((_body, b) => cornersOf(bounds(b)));
  const box = boxOf(run, corners);
  if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
  const size = box.getSize(new THREE.Vector3());
  const centre = box.getCenter(new THREE.Vector3());
  const radius = Math.max(0.5 * size.length(), 1e-3);
  // A planar motion is seen along its normal, unless its bodies are thick.
  const reach = corners.flat().reduce((most, corner) => Math.max(most, corner.length()), 0);
  const flat = [size.x, size.y, size.z].findIndex((extent) => extent + reach < 0.02 * radius);
  const direction = new THREE.Vector3();
  if (flat >= 0 && Math.abs(up.getComponent(flat)) < 0.5) {
    direction.setComponent(flat, flat === 1 ? -1 : 1);
  } else {
    // From the front, slightly from above and from the right.
    const side = Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    const front = new THREE.Vector3().crossVectors(side, up).normalize();
    direction.copy(front).addScaledVector(new THREE.Vector3().crossVectors(up, front), 0.75).addScaledVector(up, 0.4);
  }
  const low = new THREE.Vector3(...(["x", "y", "z"] as const).map((k) => (up[k] > 0 ? box.min[k] : box.max[k])));
  return { box, centre, radius, direction: direction.normalize(), up, lowest: low.dot(up) };
}

/**
 * Distance of the camera from the centre of a box at which the box's corners are in the picture, or in a part of it that has the
 * share `height` of its height.
 */
export function distanceFor(
  box: THREE.Box3,
  direction: THREE.Vector3,
  up: THREE.Vector3,
  fov: number,
  aspect: number,
  height = 1,
): number {
  const half = Math.tan(THREE.MathUtils.degToRad(fov) / 2);
  const [wide, tall] = [half * aspect, half * height];
  const right = new THREE.Vector3().crossVectors(up, direction).normalize();
  const top = new THREE.Vector3().crossVectors(direction, right);
  const centre = box.getCenter(new THREE.Vector3());
  let distance = 1e-6;
  for (const corner of cornersOf(box)) {
    corner.sub(centre);
    const away = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(top)) / tall);
    distance = Math.max(distance, away + corner.dot(direction));
  }
  return 1.1 * distance;
}
