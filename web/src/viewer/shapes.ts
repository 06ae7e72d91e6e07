// The shapes of bodies as three.js meshes.
import * as THREE from "three";
import type { Model, Shape } from "../recording";
import { hexOf } from "./colours";
import { ellipsoidOf, roomAround } from "./inertia";
import { meshGeometry } from "./mesh_geometry";
import { addOutward } from "./outline";

/** The geometry in the shape's own axes, or of a mesh those of its parts, with the colours that they have of their own. */
function geometriesOf(shape: Shape): { geometry: THREE.BufferGeometry; colour?: string | undefined }[] {
  const radius = shape.radius ?? 0;
  const length = shape.length ?? 0;
  switch (shape.kind) {
    case "box":
      return [{ geometry: new THREE.BoxGeometry(...(shape.size ?? [0, 0, 0])) }];
    case "sphere":
      return [{ geometry: new THREE.SphereGeometry(radius, 28, 18) }];
    case "ellipsoid":
      return [{ geometry: new THREE.SphereGeometry(1, 28, 18).scale(...(shape.size ?? [0, 0, 0])) }];
    case "cylinder":
      return [{ geometry: new THREE.CylinderGeometry(radius, radius, length, 28).rotateX(Math.PI / 2) }];
    case "capsule":
      return [{ geometry: new THREE.CapsuleGeometry(radius, length, 8, 24).rotateX(Math.PI / 2) }];
    default:
      return (shape.parts ?? []).map((part) => ({
        geometry: meshGeometry(part, shape.scale ?? [1, 1, 1]),
        colour: part.colour,
      }));
  }
}

/** Meshes in their body's frame. */
export function meshesOf(shape: Shape, material: THREE.Material): THREE.Mesh[] {
  const [w, x, y, z] = shape.at.quat;
  const place = new THREE.Matrix4().makeRotationFromQuaternion(new THREE.Quaternion(x, y, z, w)).setPosition(...shape.at.xyz);
  return geometriesOf(shape).map(({ geometry, colour: own }) => {
    geometry.applyMatrix4(place);
    const outward = geometry.getAttribute("outward");
    if (outward) outward.applyNormalMatrix(new THREE.Matrix3().getNormalMatrix(place));
    const mesh = new THREE.Mesh(geometry, material);
    mesh.userData.open = shape.kind === "mesh";
    const colour = hexOf(shape.colour ?? own ?? "");
    if (colour) mesh.userData.colour = colour;
    if (colour && !outward) addOutward(geometry);
    return mesh;
  });
}

/** A body without shapes, by its inertia; null if there is nothing to draw. */
function inertiaOf(model: Model, b: number, material: THREE.Material): THREE.Mesh | null {
  const body = model.bodies[b];
  const ellipsoid = ellipsoidOf(body, roomAround(model, b));
  if (!ellipsoid) return null;
  const geometry = new THREE.SphereGeometry(1, 20, 14).scale(...ellipsoid.semi);
  geometry.applyQuaternion(ellipsoid.turn).translate(...body.com);
  return new THREE.Mesh(geometry, material);
}

/**
 * Data of a view of body shapes: `own`: their own colours, if any; `open`: their triangles are seen from both sides;
 * `outlines`: of the shapes that have one.
 */
export interface ShapeMeshes {
  readonly group: THREE.Group;
  readonly meshes: readonly { readonly mesh: THREE.Mesh; readonly own: string | null; readonly open: boolean }[];
  readonly outlines: readonly THREE.Mesh[];
}

/** By body: its shapes, or the ellipsoid of its inertia if it has none. Geometries are shared between copies. */
export class ShapeLibrary {
  private readonly parts: THREE.Mesh[][];
  private readonly shaped: boolean[];
  private readonly spheres: (THREE.Sphere | null)[] = [];

  constructor(model: Model) {
    const nothing = new THREE.MeshBasicMaterial();
    const drawn = (mesh: THREE.Mesh | null): mesh is THREE.Mesh => mesh !== null;
    this.parts = model.bodies.map((body) => body.shapes.flatMap((shape) => meshesOf(shape, nothing)));
    this.shaped = this.parts.map((parts) => parts.length > 0);
    this.parts.forEach((parts, b) => {
      if (parts.length === 0) parts.push(...[inertiaOf(model, b, nothing)].filter(drawn));
    });
  }

  has(body: number): boolean {
    return this.parts[body].length > 0;
  }

  /** Whether the body has shapes of its own, not only the ellipsoid of its inertia. */
  hasShapes(body: number): boolean {
    return this.shaped[body];
  }

  hasMesh(body: number): boolean {
    return this.parts[body].some((part) => part.userData.open === true);
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
      return { mesh, own, open: part.userData.open === true };
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

  /** The box around a body's shapes, in the body's axes (m). */
  bounds(body: number): THREE.Box3 {
    const box = new THREE.Box3();
    for (const part of this.parts[body]) {
      part.geometry.computeBoundingBox();
      if (part.geometry.boundingBox) box.union(part.geometry.boundingBox);
    }
    return box;
  }

  /** A sphere around a body's shapes, in the body's axes (m); null if it has none. */
  sphere(body: number): THREE.Sphere | null {
    const known = this.spheres[body];
    if (known !== undefined) return known;
    const box = this.bounds(body);
    if (box.isEmpty()) return (this.spheres[body] = null);
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    let radius = 0;
    for (const { geometry } of this.parts[body]) {
      geometry.computeBoundingSphere();
      const own = geometry.boundingSphere;
      if (own) radius = Math.max(radius, own.center.distanceTo(sphere.center) + own.radius);
    }
    sphere.radius = Math.min(sphere.radius, radius);
    return (this.spheres[body] = sphere);
  }

  dispose() {
    for (const body of this.parts) for (const part of body) part.geometry.dispose();
  }
}
