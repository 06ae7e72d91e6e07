// Where to look from: the whole motion in the picture, gravity down; a motion in a plane is seen along the plane's normal.
import * as THREE from "three";
import type { Model, Recording } from "../recording";

export interface View {
  readonly centre: THREE.Vector3;
  readonly radius: number;
  /** From the centre towards the camera. */
  readonly direction: THREE.Vector3;
  readonly up: THREE.Vector3;
  /** Where the floor is, along `up` (m). */
  readonly lowest: number;
}

export function upOf(model: Model): THREE.Vector3 {
  const gravity = new THREE.Vector3(...model.gravity);
  return gravity.lengthSq() > 0 ? gravity.normalize().negate() : new THREE.Vector3(0, 0, 1);
}

/** Points that the picture should hold: bodies' origins and the ends of what is drawn of them, over some frames. */
function points(run: Recording, reach: (body: number) => number, most = 40): THREE.Box3 {
  const box = new THREE.Box3();
  const step = Math.max(1, Math.floor(run.frames / most));
  const at = new THREE.Vector3();
  const turn = new THREE.Quaternion();
  for (let frame = 0; frame < run.frames; frame += step) {
    const poses = run.poses(frame);
    run.model.bodies.forEach((body, b) => {
      const i = 7 * b;
      turn.set(poses[i + 4], poses[i + 5], poses[i + 6], poses[i + 3]);
      const origin = new THREE.Vector3(poses[i], poses[i + 1], poses[i + 2]);
      const r = reach(b);
      box.expandByPoint(at.copy(origin).addScalar(r));
      box.expandByPoint(at.copy(origin).addScalar(-r));
      for (const line of body.extent)
        for (const end of line)
          box.expandByPoint(
            at
              .set(...end)
              .applyQuaternion(turn)
              .add(origin),
          );
    });
  }
  return box;
}

/** All of the run, or of the frames that there are by now. */
export function viewOf(run: Recording, reach: (body: number) => number): View {
  const up = upOf(run.model);
  const box = points(run, reach);
  if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
  const size = box.getSize(new THREE.Vector3());
  const centre = box.getCenter(new THREE.Vector3());
  const radius = Math.max(0.5 * size.length(), 1e-3);
  const flat = [size.x, size.y, size.z].findIndex((extent) => extent < 0.02 * radius);
  const direction = new THREE.Vector3();
  if (flat >= 0 && Math.abs(up.getComponent(flat)) < 0.5) {
    direction.setComponent(flat, flat === 1 ? -1 : 1);
  } else {
    // From the front, a little from above and from the right.
    const side = Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    const front = new THREE.Vector3().crossVectors(side, up).normalize();
    direction.copy(front).addScaledVector(new THREE.Vector3().crossVectors(up, front), 0.75).addScaledVector(up, 0.4);
  }
  const low = new THREE.Vector3(...(["x", "y", "z"] as const).map((k) => (up[k] > 0 ? box.min[k] : box.max[k])));
  return { centre, radius, direction: direction.normalize(), up, lowest: low.dot(up) };
}
