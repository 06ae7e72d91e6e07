// Keeps the mechanisms in the picture while they move: the camera moves and recedes no more than it must. Pieces that are too far
// away for that are named at the picture's edge (panels/strays.ts).
import * as THREE from "three";
import type { Model, Vec3 } from "../recording";
import { pointOf } from "./frames";

/** Something with a place and a size (m). */
export interface Sphere {
  readonly at: THREE.Vector3;
  readonly radius: number;
}

export interface Aim {
  readonly target: THREE.Vector3;
  readonly distance: number;
}

/** The time in which the camera covers most of its way (63 %) to where it must be (s). */
const settling = 0.13;
/** Longer times between two pictures count as this (s): not all of a pause. */
const longest = 1;
/** The farthest that the camera stays behind what moves fast, relative to its distance: the middle third of the picture. */
const farthestBehind = 0.1;

/** How far the camera has come from `present` to `aim` after a time (s), however many pictures were drawn in it. */
export function stepTowards(present: Aim, aim: Aim, seconds: number): Aim {
  const share = 1 - Math.exp(-Math.min(Math.max(seconds, 0), longest) / settling);
  const behind = present.target.clone().sub(aim.target);
  behind.clampLength(0, farthestBehind * aim.distance).multiplyScalar(1 - share);
  return {
    target: behind.add(aim.target),
    distance: present.distance + share * (aim.distance - present.distance),
  };
}

/** Spheres around the bodies that exist; `shapes`: around a body's shapes, in its axes. */
export function spheresOf(
  model: Model,
  poses: ArrayLike<number>,
  shapes: (body: number) => THREE.Sphere | null,
): (Sphere | null)[] {
  return model.bodies.map((body, b) => {
    if (Number.isNaN(poses[7 * b])) return null;
    const own = shapes(b);
    const centre: Vec3 = own ? [own.center.x, own.center.y, own.center.z] : body.com;
    let radius = own?.radius ?? 0;
    for (const line of body.extent)
      for (const end of line) radius = Math.max(radius, Math.hypot(end[0] - centre[0], end[1] - centre[1], end[2] - centre[2]));
    return { at: new THREE.Vector3(...pointOf(poses, b, centre)), radius };
  });
}

/**
 * The spheres that are not farther from the main group than `room`; the group begins with those near `home`. When everything has
 * left, the camera goes with the largest.
 */
export function gathered(spheres: readonly (Sphere | null)[], home: THREE.Vector3, room: number): Sphere[] {
  const present = spheres.filter((each): each is Sphere => each !== null);
  const near = present.filter(({ at }) => at.distanceTo(home) <= room);
  if (near.length > 0) return near;
  const [first] = [...present].sort((a, b) => b.radius - a.radius);
  return first ? present.filter(({ at }) => at.distanceTo(first.at) <= room) : [];
}

/** The sphere nearest to a point; −1: there is none. */
export function nearestTo(point: THREE.Vector3, spheres: readonly (Sphere | null)[]): number {
  const distance = (sphere: Sphere | null) => (sphere ? sphere.at.distanceTo(point) : Infinity);
  return spheres.reduce((best, sphere, i) => (distance(sphere) < distance(spheres[best] ?? null) ? i : best), -1);
}

/** What the camera shows. */
export interface Lens {
  /** Vertical angle of view (deg). */
  readonly fov: number;
  readonly aspect: number;
  /** The share of the picture's height that is left free at its top; less than 0.45. */
  readonly above?: number;
}

/** The share of the picture, without what is left free, that spheres may fill. */
const margin = 0.94;

/**
 * How the camera must look at spheres that it sees along `direction` (from the target to the camera): as it does if all are
 * in the picture, below the part that is left free; otherwise so that their middle is in the middle of the rest, from where
 * all are within. A camera that is farther away than `home` comes back when they fill less than half of the picture.
 */
export function aimAt(
  spheres: readonly Sphere[],
  present: Aim,
  direction: THREE.Vector3,
  up: THREE.Vector3,
  { fov, aspect, above = 0 }: Lens,
  home = Infinity,
): Aim {
  if (spheres.length === 0) return present;
  const half = Math.tan(THREE.MathUtils.degToRad(fov) / 2);
  const wide = margin * half * aspect;
  const tall = margin * half * (1 - above);
  /** By distance from the camera, how far the middle of the rest is below the middle of the picture. */
  const lower = half * above;
  const right = new THREE.Vector3().crossVectors(up, direction).normalize();
  const top = new THREE.Vector3().crossVectors(direction, right);
  /** The distance from which all are within; `away`: how far from the camera a sphere must be for its height. */
  const needed = (target: THREE.Vector3, away: (height: number, nearer: number, radius: number) => number) =>
    Math.max(
      ...spheres.map(({ at, radius }) => {
        const from = at.clone().sub(target);
        const nearer = from.dot(direction);
        return nearer + Math.max((Math.abs(from.dot(right)) + radius) / wide, away(from.dot(top), nearer, radius));
      }),
    );
  const now = needed(present.target, (height, _nearer, radius) =>
    Math.max((radius + height) / (tall - lower), (radius - height) / (tall + lower)),
  );
  const back = present.distance > 1.001 * home && now < 0.5 * present.distance;
  if (now <= present.distance && !back) return present;
  const box = new THREE.Box3();
  for (const { at, radius } of spheres)
    box.expandByPoint(at.clone().addScalar(radius)).expandByPoint(at.clone().addScalar(-radius));
  const middle = box.getCenter(new THREE.Vector3());
  const around = needed(middle, (height, nearer, radius) => (Math.abs(height - lower * nearer) + radius) / tall);
  const distance = Math.max(back ? home : present.distance, around);
  return { target: middle.addScaledVector(top, lower * distance), distance };
}
