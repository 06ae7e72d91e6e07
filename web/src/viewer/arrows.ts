// Arrows for vectors at points of the world, such as momenta and forces: shafts and heads as two sets of instances.
import * as THREE from "three";
import { pixelSize } from "./rods";

export interface Arrow {
  readonly from: THREE.Vector3;
  /** In the quantity's unit. */
  readonly vector: THREE.Vector3;
}

const up = new THREE.Vector3(0, 1, 0);

/** Lengths per unit that suit vectors: the longest so far is as long as `longest` (m). */
export class ArrowScale {
  private largest = 0;

  /** Zero before there was any vector longer than `least`: shorter ones are round-off. */
  for(arrows: readonly Arrow[], longest: number, least = 0): number {
    for (const { vector } of arrows) this.largest = Math.max(this.largest, vector.length());
    return this.largest > least ? longest / this.largest : 0;
  }
  get most() {
    return this.largest;
  }
}

export class Arrows {
  readonly group = new THREE.Group();
  private readonly material = new THREE.MeshBasicMaterial({ transparent: true, depthTest: false });
  private readonly shaft = new THREE.CylinderGeometry(1, 1, 1, 8).translate(0, 0.5, 0);
  private readonly head = new THREE.ConeGeometry(1, 1, 12).translate(0, -0.5, 0);
  private shafts: THREE.InstancedMesh;
  private heads: THREE.InstancedMesh;
  private placed: { from: THREE.Vector3; along: THREE.Vector3 }[] = [];

  constructor() {
    [this.shafts, this.heads] = this.make(32);
  }

  private make(capacity: number): [THREE.InstancedMesh, THREE.InstancedMesh] {
    const meshes = [this.shaft, this.head].map((geometry) => new THREE.InstancedMesh(geometry, this.material, capacity));
    for (const mesh of meshes) {
      mesh.frustumCulled = false;
      mesh.renderOrder = 14;
      this.group.add(mesh);
    }
    return [meshes[0], meshes[1]];
  }

  /** `scale`: metres per unit. */
  set(arrows: readonly Arrow[], scale: number, colour: string) {
    this.material.color.set(colour);
    this.placed = arrows.map(({ from, vector }) => ({ from, along: vector.clone().multiplyScalar(scale) }));
    if (this.placed.length <= this.shafts.instanceMatrix.count) return;
    for (const mesh of [this.shafts, this.heads]) {
      mesh.removeFromParent();
      mesh.dispose();
    }
    [this.shafts, this.heads] = this.make(Math.ceil(1.5 * this.placed.length));
  }

  /** Call before each drawing: sets widths in pixels; arrows of a few pixels are left out. */
  fit(camera: THREE.PerspectiveCamera, height: number) {
    const matrix = new THREE.Matrix4();
    const turn = new THREE.Quaternion();
    const size = new THREE.Vector3();
    const end = new THREE.Vector3();
    let count = 0;
    for (const { from, along } of this.placed) {
      const length = along.length();
      const pixel = pixelSize(camera, height, from);
      if (!(length > 3 * pixel)) continue;
      turn.setFromUnitVectors(up, along.clone().divideScalar(length));
      const tip = Math.min(12 * pixel, 0.6 * length);
      this.shafts.setMatrixAt(count, matrix.compose(from, turn, size.set(1.4 * pixel, length - 0.9 * tip, 1.4 * pixel)));
      this.heads.setMatrixAt(count, matrix.compose(end.addVectors(from, along), turn, size.set(0.4 * tip, tip, 0.4 * tip)));
      count++;
    }
    for (const mesh of [this.shafts, this.heads]) {
      mesh.count = count;
      mesh.instanceMatrix.needsUpdate = true;
    }
  }
}
