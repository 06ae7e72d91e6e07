// Marks of impacts: a ring around the point and a stroke along the normal, larger for larger impulses, which fade.
import * as THREE from "three";
import { impulseOf, marksAt, type Mark } from "../contacts";
import type { Motion } from "../recording";
import { pixelSize } from "./rods";
import type { Stage } from "./stage";

const most = 64;
const z = new THREE.Vector3(0, 0, 1);

export class Impacts {
  readonly group = new THREE.Group();
  private readonly ring = new THREE.RingGeometry(0.82, 1, 40);
  private readonly stroke = new THREE.CylinderGeometry(1, 1, 1, 8).rotateX(Math.PI / 2).translate(0, 0, 0.5);
  private readonly drawn: { ring: THREE.Mesh; stroke: THREE.Mesh; material: THREE.MeshBasicMaterial }[] = [];
  private marks: readonly Mark[] = [];
  private largest = { events: null as readonly unknown[] | null, count: 0, impulse: 0 };
  private radius = 0;

  /** `lasts`: for how long an impact is marked (s). */
  constructor(
    private readonly stage: Stage,
    private readonly lasts = 0.3,
  ) {
    stage.scene.add(this.group);
    stage.onDraw((camera, height) => this.fit(camera, height));
  }

  show(run: Motion, time: number) {
    const { events } = run;
    if (this.largest.events !== events || this.largest.count > events.length) this.largest = { events, count: 0, impulse: 0 };
    for (; this.largest.count < events.length; this.largest.count++)
      this.largest.impulse = Math.max(this.largest.impulse, impulseOf(events[this.largest.count]));
    this.marks = marksAt(events, time, this.lasts, 1e-6 * this.largest.impulse, most);
    this.radius = 0.05 * this.stage.size;
    while (this.drawn.length < this.marks.length) this.drawn.push(this.make());
    this.drawn.forEach(({ ring, stroke, material }, i) => {
      ring.visible = stroke.visible = i < this.marks.length;
      if (!ring.visible) return;
      material.color.set(this.stage.theme.ink);
      material.opacity = 1 - this.marks[i].age;
    });
  }

  private make() {
    const material = new THREE.MeshBasicMaterial({ transparent: true, depthTest: false, side: THREE.DoubleSide });
    const [ring, stroke] = [this.ring, this.stroke].map((geometry) => new THREE.Mesh(geometry, material));
    ring.renderOrder = stroke.renderOrder = 13;
    this.group.add(ring, stroke);
    return { ring, stroke, material };
  }

  /** Small marks have a size in pixels. */
  private fit(camera: THREE.PerspectiveCamera, height: number) {
    const direction = new THREE.Vector3();
    this.marks.forEach(({ point, normal, impulse, age }, i) => {
      const { ring, stroke } = this.drawn[i];
      ring.position.set(...point);
      stroke.position.set(...point);
      const pixel = pixelSize(camera, height, ring.position);
      const full = Math.max(this.radius * Math.sqrt(impulse / this.largest.impulse), 5 * pixel);
      ring.quaternion.setFromUnitVectors(z, direction.set(...normal).normalize());
      stroke.quaternion.copy(ring.quaternion);
      ring.scale.setScalar(full * (0.5 + 0.5 * age));
      stroke.scale.set(1.2 * pixel, 1.2 * pixel, full);
    });
  }
}
