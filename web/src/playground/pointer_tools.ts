// The pointer in the picture: it grabs and throws bodies; a click with another tool selects a joint or a body.
import * as THREE from "three";
import type { Triple } from "../../../wasm/host.mjs";
import { Arrows } from "../viewer/arrows";
import { inboardJoints, pointOf } from "../viewer/frames";
import { shownJoint } from "../viewer/joints";
import type { Joint, Phase } from "../recording";
import type { Stage } from "../viewer/stage";

export type Tool = "grab" | "break" | "lock" | "weld";

export interface PointerScene {
  poses(): ArrayLike<number>;
  phase(): Phase;
}

export interface PointerActions {
  grab(body: number, point: Triple, target: Triple): void;
  pull(target: Triple): void;
  release(): void;
  joint(name: string): void;
  body(body: number): void;
}

const triple = (v: THREE.Vector3): Triple => [v.x, v.y, v.z];

/** Tolerances (pixels): a finger is less exact than a mouse. */
const tolerance = (event: PointerEvent) =>
  event.pointerType === "touch" ? { body: 26, joint: 34, still: 16 } : { body: 12, joint: 24, still: 8 };

export class PointerTools {
  tool: Tool = "grab";
  /** Otherwise, the pointer only rotates the picture. */
  enabled = true;
  private drag: { pointer: number; plane: THREE.Plane } | null = null;
  private pressed: { pointer: number; x: number; y: number } | null = null;
  private readonly arrow = new Arrows();
  private grip: { body: number; point: Triple; target: Triple } | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly scene: PointerScene,
    private readonly actions: PointerActions,
  ) {
    stage.scene.add(this.arrow.group);
    stage.onDraw((camera, height) => this.arrow.fit(camera, height));
    const { canvas } = stage;
    // Runs before the camera controls: a press on a body must not rotate the picture.
    canvas.addEventListener("pointerdown", (event) => this.press(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel"] as const) canvas.addEventListener(end, (event) => this.release(event));
  }

  /** The joint nearest to a point of the page, or null; joints to the ground count, free joints do not. */
  jointAt(x: number, y: number, tolerance: number): Joint | null {
    const box = this.stage.canvas.getBoundingClientRect();
    let best: Joint | null = null;
    let least = tolerance;
    for (const joint of this.scene.phase().joints) {
      if (joint.kind === "free") continue;
      const at = this.placeOf(joint, box);
      const distance = Math.hypot(at.x - x, at.y - y);
      if (distance < least) {
        least = distance;
        best = joint;
      }
    }
    return best;
  }

  /** Position of a joint in the page. */
  placeOf(joint: Joint, box = this.stage.canvas.getBoundingClientRect()) {
    const { at } = shownJoint(this.stage.model, joint, this.scene.poses());
    const p = new THREE.Vector3(...at).project(this.stage.camera);
    return { x: box.left + 0.5 * (p.x + 1) * box.width, y: box.top + 0.5 * (1 - p.y) * box.height };
  }

  /** Draws an arrow from the grabbed point to the pointer. */
  show() {
    if (!this.grip) return this.arrow.set([], 1, this.stage.theme.ink);
    const from = new THREE.Vector3(...pointOf(this.scene.poses(), this.grip.body, this.grip.point));
    this.arrow.set([{ from, vector: new THREE.Vector3(...this.grip.target).sub(from) }], 1, this.stage.theme.ink);
  }

  private press(event: PointerEvent) {
    if (!this.enabled || event.button !== 0 || !event.isPrimary) return;
    const within = tolerance(event);
    const hit = this.stage.pick(event.clientX, event.clientY, within.body);
    if (this.tool !== "grab") {
      const joint = this.jointAt(event.clientX, event.clientY, within.joint);
      if (hit || joint) {
        this.pressed = { pointer: event.pointerId, x: event.clientX, y: event.clientY };
        event.stopImmediatePropagation();
      }
      return;
    }
    if (!hit) return;
    event.stopImmediatePropagation();
    this.stage.canvas.setPointerCapture(event.pointerId);
    const normal = this.stage.camera.getWorldDirection(new THREE.Vector3());
    this.drag = { pointer: event.pointerId, plane: new THREE.Plane().setFromNormalAndCoplanarPoint(normal, hit.point) };
    this.grip = { body: hit.body, point: this.inBody(hit.body, hit.point), target: triple(hit.point) };
    this.actions.grab(hit.body, this.grip.point, this.grip.target);
    this.show();
  }

  private inBody(body: number, point: THREE.Vector3): Triple {
    const poses = this.scene.poses();
    const i = 7 * body;
    const turn = new THREE.Quaternion(poses[i + 4], poses[i + 5], poses[i + 6], poses[i + 3]).conjugate();
    return triple(
      point
        .clone()
        .sub(new THREE.Vector3(poses[i], poses[i + 1], poses[i + 2]))
        .applyQuaternion(turn),
    );
  }

  private move(event: PointerEvent) {
    if (event.pointerId !== this.drag?.pointer || !this.grip) return;
    const box = this.stage.canvas.getBoundingClientRect();
    const pointer = new THREE.Vector2(
      (2 * (event.clientX - box.left)) / box.width - 1,
      1 - (2 * (event.clientY - box.top)) / box.height,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(pointer, this.stage.camera);
    const target = ray.ray.intersectPlane(this.drag.plane, new THREE.Vector3());
    if (!target) return;
    this.grip.target = triple(target);
    this.actions.pull(this.grip.target);
    this.show();
    this.stage.draw();
  }

  private release(event: PointerEvent) {
    if (event.pointerId === this.drag?.pointer) {
      this.drag = null;
      this.grip = null;
      this.show();
      this.stage.draw();
      this.actions.release();
    }
    if (event.pointerId !== this.pressed?.pointer) return;
    const { x, y } = this.pressed;
    this.pressed = null;
    const within = tolerance(event);
    if (event.type === "pointercancel" || Math.hypot(event.clientX - x, event.clientY - y) > within.still) return;
    const joint = this.jointAt(x, y, within.joint);
    const hit = this.stage.pick(x, y, within.body);
    if (this.tool === "weld") {
      if (hit) this.actions.body(hit.body);
    } else if (joint) this.actions.joint(joint.name);
    else if (hit) this.actions.joint(inboardJoints(this.scene.phase().joints).get(hit.body)?.name ?? "");
  }
}
