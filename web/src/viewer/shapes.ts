// The shapes of bodies as three.js meshes: each a unit geometry, scaled; what stands in another file is not loaded.
import * as THREE from "three";
import type { Model, Shape } from "../recording";

/** A mesh in its body's frame, or null where there is nothing to draw. */
function meshOf(shape: Shape, material: THREE.Material): THREE.Mesh | null {
  const radius = shape.radius ?? 0;
  const length = shape.length ?? 0;
  let geometry: THREE.BufferGeometry;
  switch (shape.kind) {
    case "box":
      geometry = new THREE.BoxGeometry(...(shape.size ?? [0, 0, 0]));
      break;
    case "sphere":
      geometry = new THREE.SphereGeometry(radius, 28, 18);
      break;
    case "cylinder":
      geometry = new THREE.CylinderGeometry(radius, radius, length, 28).rotateX(Math.PI / 2);
      break;
    case "capsule":
      geometry = new THREE.CapsuleGeometry(radius, length, 8, 24).rotateX(Math.PI / 2);
      break;
    case "mesh":
      return null;
  }
  const [w, x, y, z] = shape.at.quat;
  geometry.applyQuaternion(new THREE.Quaternion(x, y, z, w)).translate(...shape.at.xyz);
  return new THREE.Mesh(geometry, material);
}

/** By body: a group with its shapes, or null where it has none that can be drawn. Geometries are shared between copies. */
export class ShapeLibrary {
  private readonly parts: THREE.Mesh[][];

  constructor(model: Model) {
    const nothing = new THREE.MeshBasicMaterial();
    this.parts = model.bodies.map((body) =>
      body.shapes.map((shape) => meshOf(shape, nothing)).filter((mesh): mesh is THREE.Mesh => mesh !== null),
    );
  }

  has(body: number): boolean {
    return this.parts[body].length > 0;
  }

  /** New meshes over the same geometries; `userData.body` tells whose they are. */
  copy(body: number, material: THREE.Material): THREE.Group {
    const group = new THREE.Group();
    for (const part of this.parts[body]) {
      const mesh = new THREE.Mesh(part.geometry, material);
      mesh.userData.body = body;
      group.add(mesh);
    }
    return group;
  }

  /** How far a body's shapes reach from its origin (m). */
  reach(body: number): number {
    let reach = 0;
    for (const part of this.parts[body]) {
      part.geometry.computeBoundingSphere();
      const sphere = part.geometry.boundingSphere;
      if (sphere) reach = Math.max(reach, sphere.center.length() + sphere.radius);
    }
    return reach;
  }

  dispose() {
    for (const body of this.parts) for (const part of body) part.geometry.dispose();
  }
}
