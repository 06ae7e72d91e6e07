// Rods and balls in the world, drawn as two sets of instances. Each is at least some pixels wide, however far the
// camera is: long thin chains stay visible.
import * as THREE from "three";

const up = new THREE.Vector3(0, 1, 0);

/** Width of a pixel at a point of the picture (m). */
export function pixelSize(camera: THREE.PerspectiveCamera, height: number, point: THREE.Vector3): number {
  const depth = point.clone().applyMatrix4(camera.matrixWorldInverse).z;
  return (2 * Math.tan(THREE.MathUtils.degToRad(camera.fov) / 2) * Math.max(-depth, camera.near)) / height;
}

/** Instances of one shape, whose number grows as needed. */
class Instances {
  mesh: THREE.InstancedMesh;
  private count = 0;

  constructor(
    private readonly parent: THREE.Object3D,
    private readonly geometry: THREE.BufferGeometry,
    private readonly material: THREE.Material,
    private readonly order: number,
  ) {
    this.mesh = this.make(64);
  }

  private make(capacity: number): THREE.InstancedMesh {
    const mesh = new THREE.InstancedMesh(this.geometry, this.material, capacity);
    mesh.frustumCulled = false;
    mesh.renderOrder = this.order;
    mesh.castShadow = this.order > 0;
    mesh.count = 0;
    mesh.setColorAt(0, new THREE.Color()); // creates the colour buffer
    this.parent.add(mesh);
    return mesh;
  }

  begin(capacity: number) {
    this.count = 0;
    if (capacity <= this.mesh.instanceMatrix.count) return;
    this.parent.remove(this.mesh);
    this.mesh.dispose();
    this.mesh = this.make(Math.ceil(1.5 * capacity));
  }

  add(matrix: THREE.Matrix4, colour: THREE.Color) {
    this.mesh.setMatrixAt(this.count, matrix);
    this.mesh.setColorAt(this.count, colour);
    this.count++;
  }

  end() {
    this.mesh.count = this.count;
    this.mesh.instanceMatrix.needsUpdate = true;
    if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
  }

  dispose() {
    this.parent.remove(this.mesh);
    this.mesh.dispose();
  }
}

interface Placed {
  readonly from: THREE.Vector3;
  readonly to: THREE.Vector3;
  readonly colour: THREE.Color;
}

interface Ball {
  readonly at: THREE.Vector3;
  readonly colour: THREE.Color;
  readonly factor: number;
  /** Its colour if rods have the minimum visible width: it then only fills the bend between two of them. */
  readonly thin: THREE.Color | null;
  /** Radius above which it would hide rods (m). */
  readonly room: number;
}

/** Set the list when it changes; `fit` sets the widths before each drawing. */
export class Rods {
  readonly group = new THREE.Group();
  private readonly rods: Instances;
  private readonly balls: Instances;
  private placed: Placed[] = [];
  private ballsPlaced: Ball[] = [];

  /** `order`: drawing order among transparent objects. */
  constructor(material: THREE.Material, order: number) {
    this.rods = new Instances(this.group, new THREE.CylinderGeometry(1, 1, 1, 14, 1), material, order);
    this.balls = new Instances(this.group, new THREE.SphereGeometry(1, 14, 10), material, order);
  }

  clear() {
    this.placed = [];
    this.ballsPlaced = [];
  }

  rod(from: THREE.Vector3, to: THREE.Vector3, colour: THREE.Color) {
    this.placed.push({ from, to, colour });
  }

  /** `factor`: ratio of its radius to that of rods. */
  ball(at: THREE.Vector3, colour: THREE.Color, factor: number, thin: THREE.Color | null = null, room = Infinity) {
    this.ballsPlaced.push({ at, colour, factor, thin, room });
  }

  /** Radius: `radius` (m), or half of `pixels` if that is larger. */
  fit(camera: THREE.PerspectiveCamera, height: number, radius: number, pixels: number) {
    const matrix = new THREE.Matrix4();
    const turn = new THREE.Quaternion();
    const middle = new THREE.Vector3();
    const along = new THREE.Vector3();
    const size = new THREE.Vector3();
    this.rods.begin(this.placed.length);
    for (const { from, to, colour } of this.placed) {
      middle.addVectors(from, to).multiplyScalar(0.5);
      along.subVectors(to, from);
      const length = along.length();
      if (length === 0) continue;
      const r = Math.max(radius, 0.5 * pixels * pixelSize(camera, height, middle));
      turn.setFromUnitVectors(up, along.divideScalar(length));
      this.rods.add(matrix.compose(middle, turn, size.set(r, length, r)), colour);
    }
    this.rods.end();
    this.balls.begin(this.ballsPlaced.length);
    turn.identity();
    for (const { at, colour, factor, thin, room } of this.ballsPlaced) {
      const least = 0.5 * pixels * pixelSize(camera, height, at);
      const isThin = thin !== null && radius < least;
      const rod = Math.max(radius, least);
      const r = isThin ? rod : Math.max(Math.min(factor * rod, room), Math.min(factor, 1.15) * rod);
      this.balls.add(matrix.compose(at, turn, size.set(r, r, r)), isThin ? thin : colour);
    }
    this.balls.end();
  }

  dispose() {
    this.rods.dispose();
    this.balls.dispose();
  }
}
