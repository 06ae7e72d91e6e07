// What is under the pointer: the body's name, mass and joint, and its frame (x red, y green, z blue).
import * as THREE from "three";
import type { Phase } from "../recording";
import { inboardJoints } from "../viewer/frames";
import { typicalLength } from "../viewer/mechanisms";
import type { Stage } from "../viewer/stage";
import { h } from "./dom";
import { digits } from "./numbers";

/** Name, mass, mechanism, and how it is joined. */
export function describeBody(
  model: Stage["model"],
  phase: Phase,
  mechanisms: readonly string[],
  body: number,
): readonly string[] {
  const { name, mass } = model.bodies[body];
  const joint = inboardJoints(phase.joints).get(body);
  const loops = phase.joints.filter(({ loop, parent, child }) => loop && (parent === body || child === body));
  const of = (parent: number) => (parent < 0 ? "the ground" : model.bodies[parent].name);
  return [
    name,
    `${digits(mass)} kg, in ${mechanisms[phase.mechanism[body]]}`,
    joint && joint.kind !== "free"
      ? `${joint.kind} joint ${joint.name}${joint.locked ? " (locked)" : ""} to ${of(joint.parent)}`
      : "moves freely",
    ...loops.map(({ name, kind }) => `${kind} joint ${name} closes a loop`),
  ];
}

export class Hover {
  readonly element = h("div", { class: "hover", role: "tooltip", hidden: true });
  private readonly axes: THREE.AxesHelper;
  private pointer: { x: number; y: number } | null = null;
  private waiting = false;
  private body = -1;
  private phase: Phase | null = null;
  private timer = 0;

  /** `present`: the instant shown; null: there is none. */
  constructor(
    private readonly stage: Stage,
    private readonly present: () => { poses: ArrayLike<number>; phase: Phase; names: readonly string[] } | null,
  ) {
    this.axes = new THREE.AxesHelper(0.6 * typicalLength(stage.model));
    this.axes.visible = false;
    this.axes.renderOrder = 15;
    for (const material of [this.axes.material].flat()) {
      material.depthTest = false;
      material.transparent = true;
    }
    stage.scene.add(this.axes);
    const { canvas } = stage;
    canvas.addEventListener("pointermove", (event) => {
      this.pointer = event.pointerType === "mouse" && event.buttons === 0 ? { x: event.clientX, y: event.clientY } : null;
      this.later();
    });
    canvas.addEventListener("pointerleave", () => {
      this.pointer = null;
      this.later();
    });
    stage.onDraw(() => {
      this.placeAxes();
      this.afterMotion();
    });
  }

  /** Bodies move away from under a pointer that rests, and others come there. */
  private afterMotion() {
    if (!this.pointer || this.timer !== 0) return;
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      this.look();
    }, 120);
  }

  private later() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.look();
    });
  }

  private look() {
    const now = this.present();
    const body = this.pointer && now ? (this.stage.pick(this.pointer.x, this.pointer.y)?.body ?? -1) : -1;
    const changed = body !== this.body;
    this.body = body;
    this.element.hidden = body < 0;
    if (changed) this.stage.draw();
    if (body < 0 || !now || !this.pointer) return;
    if (changed || now.phase !== this.phase) {
      this.phase = now.phase;
      const [name, ...rest] = describeBody(this.stage.model, now.phase, now.names, body);
      this.element.replaceChildren(h("strong", {}, name), ...rest.map((line) => h("span", {}, line)));
    }
    const box = this.stage.canvas.getBoundingClientRect();
    const left = Math.min(this.pointer.x - box.left + 14, box.width - this.element.offsetWidth - 6);
    const above = this.pointer.y - box.top - this.element.offsetHeight - 10;
    this.element.style.left = `${Math.max(left, 6)}px`;
    this.element.style.top = `${above > 0 ? above : this.pointer.y - box.top + 18}px`;
  }

  private placeAxes() {
    const now = this.body >= 0 ? this.present() : null;
    this.axes.visible = now !== null;
    if (!now) return;
    const i = 7 * this.body;
    this.axes.position.set(now.poses[i], now.poses[i + 1], now.poses[i + 2]);
    this.axes.quaternion.set(now.poses[i + 4], now.poses[i + 5], now.poses[i + 6], now.poses[i + 3]);
  }
}
