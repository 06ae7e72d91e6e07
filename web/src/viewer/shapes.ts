// The shapes of bodies as three.js meshes; shapes in separate files are not loaded.
import * as THREE from "three";
import type { Body, Model, Shape } from "../recording";
import { hexOf } from "./colours";
import { ellipsoidOf } from "./inertia";
import { addOutward } from "./outline";

/** A mesh in its body's frame, or null if there is nothing to draw. */
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
  const mesh = new THREE.Mesh(geometry, material);
  const colour = hexOf(shape.colour ?? "");
  if (colour) mesh.userData.colour = colour;
  if (colour) addOutward(geometry);
  return mesh;
}

/** A body without shapes, by its inertia; null if there is nothing to draw. */
function inertiaOf(body: Body, material: THREE.Material): THREE.Mesh | null {
  const ellipsoid = ellipsoidOf(body);
  if (!ellipsoid) return null;
  const geometry = new THREE.SphereGeometry(1, 20, 14).scale(...ellipsoid.semi);
  geometry.applyQuaternion(ellipsoid.turn).translate(...body.com);
  return new THREE.Mesh(geometry, material);
}

/** Data of a view of body shapes: `own`: their own colours, if any; `outlines`: of the shapes that have one. */
export interface ShapeMeshes {
  readonly group: THREE.Group;
  readonly meshes: readonly { readonly mesh: THREE.Mesh; readonly own: string | null }[];
  readonly outlines: readonly THREE.Mesh[];
}

/** By body: its shapes, or the ellipsoid of its inertia if it has none. Geometries are shared between copies. */
export class ShapeLibrary {
  private readonly parts: THREE.Mesh[][];
  private readonly shaped: boolean[];

  constructor(model: Model) {
    const nothing = new THREE.MeshBasicMaterial();
    const drawn = (mesh: THREE.Mesh | null): mesh is THREE.Mesh => mesh !== null;
    this.parts = model.bodies.map((body) => body.shapes.map((shape) => meshOf(shape, nothing)).filter(drawn));
    this.shaped = this.parts.map((parts) => parts.length > 0);
    this.parts.forEach((parts, b) => {
      if (parts.length === 0) parts.push(...[inertiaOf(model.bodies[b], nothing)].filter(drawn));
    });
  }

  has(body: number): boolean {
    return this.parts[body].length > 0;
  }

  /** Whether the body has shapes of its own, not only the ellipsoid of its inertia. */
  hasShapes(body: number): boolean {
    return this.shaped[body];
  }

  /** Whether any shape has its own colour. */
  get coloured(): boolean {
    return this.parts.some((parts) => parts.some((part) => part.userData.colour !== undefined));
  }

  /** New meshes that share the geometries; `userData.body` of pickable meshes is the body's number. */
  copy(body: number, material: THREE.Material, outlined: boolean): ShapeMeshes {
    const group = new THREE.Group();
    const outlines: THREE.Mesh[] = [];
    const meshes = this.parts[body].map((part) => {
      const mesh = new THREE.Mesh(part.geometry, material);
      mesh.castShadow = outlined;
      mesh.userData.body = body;
      const own = (part.userData.colour as string | undefined) ?? null;
      if (own && outlined) outlines.push(new THREE.Mesh(part.geometry, material));
      return { mesh, own };
    });
    for (const outline of outlines) outline.visible = false;
    group.add(...meshes.map(({ mesh }) => mesh), ...outlines);
    return { group, meshes, outlines };
  }

  /** Distance that a body's shapes reach from its origin (m). */
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
