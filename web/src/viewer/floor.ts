// The floor: a grid with squares of a round size, which receives shadows. It lies on the plane of the world, which is a slab
// then, or below all motion if there is none. Planar motion is seen along the floor; then the grid stands behind the motion.
// Solids of the ground are drawn where they are.
import * as THREE from "three";
import type { View } from "./camera";
import type { Plane, Shape } from "../recording";
import { mixed, type Theme } from "./colours";
import { meshesOf } from "./shapes";

/** A round length, at least eight of which fit into `size`. */
export function roundLength(size: number): number {
  const unit = 10 ** Math.floor(Math.log10(size / 8));
  return [5, 2, 1].map((step) => step * unit).find((side) => side <= size / 8) ?? unit;
}

/** A length as text, in a unit that suits it. */
export function lengthText(length: number): string {
  const units: readonly [number, string][] = [
    [1000, "km"],
    [1, "m"],
    [1e-2, "cm"],
    [1e-3, "mm"],
    [1e-6, "µm"],
  ];
  const [size, unit] = units.find(([size]) => length >= 0.999 * size) ?? units[units.length - 1];
  return `${Number((length / size).toPrecision(3))} ${unit}`;
}

/** The point of a plane that is nearest to a point. */
export function onPlane(point: THREE.Vector3, { point: at, normal }: Plane): THREE.Vector3 {
  const n = new THREE.Vector3(...normal).normalize();
  return point.clone().addScaledVector(n, n.dot(new THREE.Vector3(...at)) - n.dot(point));
}

export class Floor {
  readonly group = new THREE.Group();
  /** Side of a square (m). */
  square = 0;
  private readonly shadow = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), new THREE.ShadowMaterial({ depthWrite: false }));
  private grid: THREE.GridHelper | null = null;
  private readonly slab = new THREE.Mesh(
    new THREE.BoxGeometry(1, 1, 1).translate(0, 0, -0.5),
    new THREE.MeshBasicMaterial({ depthWrite: false }),
  );
  private readonly slabs: THREE.Mesh[] = [];

  private readonly solid = new THREE.MeshLambertMaterial({ side: THREE.DoubleSide, forceSinglePass: true });
  private readonly solids: readonly THREE.Mesh[];

  /** `planes`: of the world; the grid lies on the first. `ground`: what it has besides. */
  constructor(
    private readonly planes: readonly Plane[] = [],
    ground: readonly Shape[] = [],
  ) {
    this.solids = ground.flatMap((shape) => meshesOf(shape, this.solid));
    for (const solid of this.solids) solid.receiveShadow = solid.castShadow = true;
    for (const solid of this.solids) this.group.add(solid);
    for (const { normal } of planes) {
      const slab = this.slab.clone();
      slab.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...normal).normalize());
      slab.renderOrder = -3;
      this.slabs.push(slab);
      this.group.add(slab);
    }
    this.shadow.receiveShadow = true;
    this.shadow.renderOrder = -2;
    this.group.add(this.shadow);
  }

  lay(view: View, theme: Theme) {
    this.grid?.removeFromParent();
    this.grid?.dispose();
    const size = 3 * view.radius;
    this.square = roundLength(size);
    const upright = Math.abs(view.direction.dot(view.up)) < 0.05;
    const count = 2 * Math.ceil(((upright ? 2 : 1) * size) / this.square / 2);
    this.grid = new THREE.GridHelper(count * this.square, count, theme.grid, theme.grid);
    this.grid.renderOrder = -1;
    this.grid.material.depthWrite = false;
    const plane = this.planes[0];
    const level = plane ? new THREE.Vector3(...plane.normal).normalize() : view.up;
    const normal = upright ? view.direction : level;
    const side = count * this.square;
    this.solid.color.set(mixed(theme.grid, theme.ground, 0.2));
    this.slab.material.color.set(mixed(theme.grid, theme.ground, 0.45));
    this.slabs.forEach((slab, i) => {
      slab.position.copy(onPlane(view.centre, this.planes[i]));
      slab.scale.set(side, side, 0.04 * view.radius);
    });
    this.grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), normal);
    const centre = view.centre.clone();
    if (upright) {
      const half = view.box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
      const depth = Math.abs(half.dot(new THREE.Vector3(...view.direction.toArray().map(Math.abs))));
      centre.addScaledVector(view.direction, -depth - 0.02 * view.radius);
      this.grid.material.transparent = true;
      this.grid.material.opacity = 0.55;
    } else if (plane) centre.copy(onPlane(view.centre, plane));
    else centre.addScaledVector(view.up, view.lowest - centre.dot(view.up) - 1e-3 * view.radius);
    this.grid.position.copy(centre);
    this.shadow.visible = !upright;
    this.shadow.material.opacity = theme.dark ? 0.5 : 0.2;
    this.shadow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal);
    this.shadow.position.copy(centre);
    this.shadow.scale.setScalar(count * this.square);
    this.group.add(this.grid);
  }

  get receivesShadows() {
    return this.shadow.visible;
  }

  dispose() {
    this.grid?.dispose();
    this.shadow.geometry.dispose();
    this.shadow.material.dispose();
    for (const { geometry } of this.solids) geometry.dispose();
    this.solid.dispose();
    this.slab.geometry.dispose();
    this.slab.material.dispose();
    this.group.removeFromParent();
  }
}

/** The lamp that casts shadows on the floor: high, a little aside, where it is whatever the reader looks at. */
export class Sun {
  readonly light = new THREE.DirectionalLight(0xffffff, 1.1);

  constructor() {
    this.light.castShadow = true;
    this.light.shadow.mapSize.set(1024, 1024);
    this.light.shadow.radius = 3;
  }

  stand(view: View) {
    const aside = new THREE.Vector3().crossVectors(view.up, view.direction).normalize();
    const towards = view.direction.clone().addScaledVector(view.up, -view.direction.dot(view.up));
    const from = view.up.clone().addScaledVector(aside, -0.35).addScaledVector(towards, 0.3).normalize();
    this.light.position.copy(view.centre).addScaledVector(from, 4 * view.radius);
    this.light.target.position.copy(view.centre);
    this.light.target.updateMatrixWorld();
    const { camera } = this.light.shadow;
    camera.left = camera.bottom = -1.8 * view.radius;
    camera.right = camera.top = 1.8 * view.radius;
    camera.near = 0.5 * view.radius;
    camera.far = 9 * view.radius;
    camera.updateProjectionMatrix();
    this.light.shadow.needsUpdate = true;
  }
}
