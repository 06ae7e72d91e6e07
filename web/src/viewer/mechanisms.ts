// All bodies at one instant: shapes, rods for bodies without shapes, joints, and small disks where mechanisms are
// attached to the ground and, for tools that take joints, at all joints.
import * as THREE from "three";
import type { Body, Model, Phase, Vec3 } from "../recording";
import { mechanismColour, mixed, shapeColour, type Theme } from "./colours";
import { pointOf } from "./frames";
import { shownJoint } from "./joints";
import { outlineMaterial, type Resolution } from "./outline";
import { pixelSize, Rods } from "./rods";
import { SpringLines } from "./springs";
import type { ShapeLibrary, ShapeMeshes } from "./shapes";

/** The object under the pointer, at a point of the world. */
export interface Hit {
  readonly body: number;
  readonly point: THREE.Vector3;
}

export interface DrawingStyle {
  /** 0: unchanged; towards 1 it fades into the background, like past or future poses. */
  readonly faded: number;
  /** Minimum width of rods (pixels). */
  readonly pixels: number;
  readonly joints: boolean;
}

const vector = (at: readonly number[]) => new THREE.Vector3(at[0], at[1], at[2]);

/** A length compared with which rods are thin (m). */
export function typicalLength(model: Model): number {
  const lengths = model.bodies
    .flatMap((body) => body.extent.map(([a, b]) => Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2])))
    .filter((length) => length > 0)
    .sort((a, b) => a - b);
  return lengths.length > 0 ? lengths[lengths.length >> 1] : 0.2;
}

/** The lines of a body that neither its shapes nor, if there are `meshes`, those of its neighbours show. */
function shownLines(model: Model, shapes: ShapeLibrary, body: Body, b: number, meshes: boolean) {
  const reach = shapes.hasShapes(b) ? 1.2 * shapes.reach(b) : 0;
  const lines = body.extent.filter((line) => reach === 0 || line.some((end) => Math.hypot(...end) > reach));
  if (!meshes || (!shapes.hasMesh(b) && body.mass > 0)) return lines;
  const isPlain = (other: number) => !shapes.hasMesh(other) && model.bodies[other].mass > 0;
  return lines.filter(([, end]) =>
    model.joints.some(
      ({ parent, child, at }) => parent === b && isPlain(child) && Math.hypot(...at.map((x, k) => x - end[k])) < 1e-9,
    ),
  );
}

/** The mechanism with the largest mass. */
function heaviest(model: Model, phase: Phase): number {
  const masses = new Map<number, number>();
  model.bodies.forEach(({ mass }, b) => masses.set(phase.mechanism[b], (masses.get(phase.mechanism[b]) ?? 0) + mass));
  return [...masses].reduce((a, b) => (b[1] > a[1] ? b : a), [-1, -Infinity])[0];
}

export class MechanismsView {
  readonly group = new THREE.Group();
  private readonly rods: Rods;
  private readonly springs: SpringLines;
  private readonly rodMaterial = new THREE.MeshLambertMaterial();
  private readonly bodies: (ShapeMeshes | null)[];
  private readonly materials = new Map<string, THREE.MeshLambertMaterial>();
  private readonly outlines = new Map<number, THREE.MeshBasicMaterial>();
  private readonly resolution: Resolution = { value: new THREE.Vector2(1, 1) };
  private readonly disks: THREE.Mesh[] = [];
  // Transparent, so that they are drawn after the bodies, and over them.
  private readonly rim = new THREE.MeshBasicMaterial({ transparent: true, depthTest: false });
  private readonly face = new THREE.MeshBasicMaterial({ transparent: true, depthTest: false });
  private readonly circle = new THREE.CircleGeometry(1, 32);
  private readonly length: number;
  private readonly radius: number;
  /** By body, the lines that its shapes do not show. */
  private readonly lines: (readonly (readonly [Vec3, Vec3])[])[];
  /** By body, whether it is only a frame between bodies that have meshes: it is not drawn. */
  private readonly frames: readonly boolean[];
  private drawnLines: { body: number; from: THREE.Vector3; to: THREE.Vector3 }[] = [];
  private readonly jointColours = new Map<string, string>();
  /** Body under the pointer or selected; −1: none. */
  highlighted = -1;
  /** Whether every joint has a disk, also within the shapes that hide it: for tools that take joints. */
  showsJoints = false;
  /**
   * Shows shapes in their own colours if they have any, outlined in those of their mechanisms except for the heaviest one;
   * otherwise all in the colours of their mechanisms.
   */
  ownColours = true;

  constructor(
    private readonly model: Model,
    shapes: ShapeLibrary,
    private readonly style: DrawingStyle,
  ) {
    this.length = typicalLength(model);
    this.radius = 0.045 * this.length;
    const meshes = model.bodies.some((_body, b) => shapes.hasMesh(b));
    this.lines = model.bodies.map((body, b) => shownLines(model, shapes, body, b, meshes));
    this.frames = model.bodies.map(({ mass }, b) => meshes && mass === 0 && !shapes.has(b));
    this.setLayer(this.rodMaterial);
    this.rods = new Rods(this.rodMaterial, style.faded > 0 ? 0 : 5);
    this.springs = new SpringLines(model.springs ?? [], style.faded);
    this.group.add(this.rods.group, this.springs.group);
    const first = new THREE.MeshLambertMaterial();
    this.bodies = model.bodies.map((_body, b) => (shapes.has(b) ? shapes.copy(b, first, style.faded === 0) : null));
    for (const body of this.bodies) if (body) this.group.add(body.group);
  }

  /** Gives joints individual colours by name (for their load, say); an empty map removes them. */
  colourJoints(colours: ReadonlyMap<string, string>) {
    this.jointColours.clear();
    for (const [joint, colour] of colours) this.jointColours.set(joint, colour);
  }

  private colour(theme: Theme, mechanism: number): string {
    return mixed(mechanismColour(theme, mechanism), theme.ground, this.style.faded);
  }

  /** Material of shapes in a colour; `open`: seen from both sides. */
  private material(colour: string, open: boolean): THREE.MeshLambertMaterial {
    const key = open ? `${colour} open` : colour;
    let material = this.materials.get(key);
    if (material) return material;
    material = new THREE.MeshLambertMaterial({ color: colour, ...(open && { side: THREE.DoubleSide, forceSinglePass: true }) });
    this.setLayer(material);
    if (this.style.faded > 0) material.opacity = 0.35 * (1 - this.style.faded) + 0.1;
    this.materials.set(key, material);
    return material;
  }

  private outline(theme: Theme, mechanism: number): THREE.MeshBasicMaterial {
    let material = this.outlines.get(mechanism);
    if (!material) this.outlines.set(mechanism, (material = outlineMaterial(2.5, this.length, this.resolution)));
    material.color.set(this.colour(theme, mechanism));
    return material;
  }

  /** Past and future poses are drawn first and hide nothing; the present ones are drawn over them. */
  private setLayer(material: THREE.Material) {
    material.transparent = true;
    material.depthWrite = this.style.faded === 0;
  }

  place(poses: ArrayLike<number>, phase: Phase, theme: Theme) {
    this.rods.clear();
    this.drawnLines = [];
    const main = heaviest(this.model, phase);
    const colours = new Map<number, THREE.Color>();
    const colourOf = (mechanism: number) => {
      let colour = colours.get(mechanism);
      if (!colour) colours.set(mechanism, (colour = new THREE.Color(this.colour(theme, mechanism))));
      return colour;
    };
    this.model.bodies.forEach((body, b) => {
      const mechanism = phase.mechanism[b];
      const bright = b === this.highlighted ? new THREE.Color(theme.ink) : colourOf(mechanism);
      const shapes = this.bodies[b];
      if (shapes) {
        const i = 7 * b;
        shapes.group.position.set(poses[i], poses[i + 1], poses[i + 2]);
        shapes.group.quaternion.set(poses[i + 4], poses[i + 5], poses[i + 6], poses[i + 3]);
        const common = this.colour(theme, mechanism);
        for (const { mesh, own, open } of shapes.meshes) {
          const colour = own && this.ownColours ? mixed(shapeColour(own, theme), theme.ground, this.style.faded) : common;
          mesh.material = this.material(colour, open);
          mesh.renderOrder = this.style.faded > 0 ? 0 : 5;
        }
        for (const mesh of shapes.outlines) {
          mesh.visible = this.ownColours && mechanism !== main;
          mesh.renderOrder = 4;
          if (mesh.visible) mesh.material = this.outline(theme, mechanism);
        }
      }
      for (const [from, to] of this.lines[b])
        this.line(b, vector(pointOf(poses, b, from)), vector(pointOf(poses, b, to)), bright);
      if (body.extent.length === 0 && !shapes && !this.frames[b]) {
        const at = vector(pointOf(poses, b, body.com));
        this.rods.ball(at, bright, 2.5);
        this.drawnLines.push({ body: b, from: at, to: at });
      }
    });
    const ink = new THREE.Color(mixed(theme.ink, theme.ground, Math.max(this.style.faded, 0.15)));
    for (const joint of phase.joints) {
      if (joint.kind === "free") continue;
      const own = this.style.joints ? this.jointColours.get(joint.name) : undefined;
      const shown = shownJoint(this.model, joint, poses);
      const at = vector(shown.at);
      const body = colourOf(phase.mechanism[joint.child]);
      const ofBody = (b: number) => (b === this.highlighted ? new THREE.Color(theme.ink) : body);
      for (const { body: b, from, to } of shown.lines) this.line(b, vector(from), vector(to), ofBody(b));
      const isMark = joint.kind !== "weld" || shown.lines.length > 0;
      if (own) this.rods.ball(at, new THREE.Color(own), 2.2, null, 0.25 * this.length);
      else if (this.style.joints && isMark) this.rods.ball(at, ink, joint.locked || joint.kind === "weld" ? 1.1 : 1.35, body);
      else if (this.lines[joint.child].length > 0) this.rods.ball(at, body, 1); // fills the bend
    }
    this.springs.place(poses, phase, theme);
    this.placeDisks(phase, poses, theme);
  }

  private line(body: number, from: THREE.Vector3, to: THREE.Vector3, colour: THREE.Color) {
    this.rods.rod(from, to, colour);
    this.drawnLines.push({ body, from, to });
  }

  private placeDisks(phase: Phase, poses: ArrayLike<number>, theme: Theme) {
    this.rim.color.set(mixed(theme.ink, theme.ground, this.style.faded));
    this.face.color.set(theme.ground);
    const marked = phase.joints.filter(({ parent, kind }) => kind !== "free" && (parent < 0 || this.showsJoints));
    while (this.disks.length < 2 * marked.length) {
      const rim = new THREE.Mesh(this.circle, this.rim);
      const face = new THREE.Mesh(this.circle, this.face);
      for (const disk of [rim, face]) {
        this.group.add(disk);
        this.disks.push(disk);
      }
      rim.renderOrder = 10;
      face.renderOrder = 11;
    }
    this.disks.forEach((disk, i) => {
      const joint = marked[i >> 1];
      disk.visible = joint !== undefined && this.style.joints;
      if (joint) disk.position.set(...(joint.parent < 0 ? joint.at : shownJoint(this.model, joint, poses).at));
    });
  }

  /** Call before each drawing: sets widths in pixels, turns disks towards the camera. */
  fit(camera: THREE.PerspectiveCamera, height: number) {
    this.resolution.value.set(height * camera.aspect, height);
    this.rods.fit(camera, height, this.radius, this.style.pixels);
    this.springs.fit(camera, height, this.radius);
    this.disks.forEach((disk, i) => {
      const r = Math.max(2.4 * this.radius, 6 * pixelSize(camera, height, disk.position)) * (i % 2 === 0 ? 1 : 0.62);
      disk.scale.setScalar(r);
      disk.quaternion.copy(camera.quaternion);
    });
  }

  /** The rod or ball nearest to a point of the picture (pixels from its upper left corner), or null. */
  nearestRod(at: THREE.Vector2, camera: THREE.PerspectiveCamera, width: number, height: number, tolerance: number): Hit | null {
    const onPicture = (p: THREE.Vector3) => {
      const q = p.clone().project(camera);
      return new THREE.Vector2(0.5 * (q.x + 1) * width, 0.5 * (1 - q.y) * height);
    };
    let best: Hit | null = null;
    let least = tolerance;
    for (const { body, from, to } of this.drawnLines) {
      const [a, b] = [onPicture(from), onPicture(to)];
      const along = b.clone().sub(a);
      const share = along.lengthSq() > 0 ? at.clone().sub(a).dot(along) / along.lengthSq() : 0;
      const inside = Math.min(Math.max(share, 0), 1);
      const distance = a.addScaledVector(along, inside).distanceTo(at);
      if (distance < least) {
        least = distance;
        best = { body, point: from.clone().lerp(to, inside) };
      }
    }
    return best;
  }

  dispose() {
    this.rods.dispose();
    this.springs.dispose();
    this.group.removeFromParent();
    for (const material of [this.rodMaterial, this.rim, this.face, ...this.materials.values(), ...this.outlines.values()])
      material.dispose();
    this.circle.dispose();
  }
}
