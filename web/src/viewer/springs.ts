// Springs and cables as thin lines between their ends: pale while they are slack, and redder the nearer their force is to their
// strength.
import * as THREE from "three";
import type { Phase, Spring } from "../recording";
import { mixed, type Theme } from "./colours";
import { pointOf } from "./frames";
import { Rods } from "./rods";

const strained = "#d8342b";

/** The ends of a spring in the world. */
export function endsOf(spring: Spring, poses: ArrayLike<number>): [THREE.Vector3, THREE.Vector3] {
  const end = (body: number, point: readonly [number, number, number]) =>
    new THREE.Vector3(...(body < 0 ? point : pointOf(poses, body, point)));
  return [end(spring.from, spring.fromPoint), end(spring.to, spring.toPoint)];
}

/** True for a rope or a cable that exerts no force at this length. */
export function isSlack(spring: Spring, length: number): boolean {
  if (spring.inextensible) return length < (1 - 1e-6) * spring.rest;
  return spring.tensionOnly && length <= spring.rest;
}

/** `faded`: how near the colour is to the ground's, 0 to 1. */
export function springColour(spring: Spring, length: number, theme: Theme, faded: number): string {
  const stretch = length - spring.rest;
  const load = spring.strength === null ? 0 : Math.min(1, Math.abs(spring.stiffness * stretch) / spring.strength);
  const plain = mixed(theme.ink, theme.ground, 0.35);
  const colour = isSlack(spring, length) ? mixed(theme.ink, theme.ground, 0.7) : mixed(plain, strained, load);
  return mixed(colour, theme.ground, faded);
}

export class SpringLines {
  private readonly material = new THREE.MeshLambertMaterial({ transparent: true });
  private readonly lines: Rods;

  constructor(
    private readonly springs: readonly Spring[],
    private readonly faded: number,
  ) {
    this.material.depthWrite = faded === 0;
    this.lines = new Rods(this.material, faded > 0 ? 0 : 5);
  }

  get group() {
    return this.lines.group;
  }

  place(poses: ArrayLike<number>, phase: Phase, theme: Theme) {
    this.lines.clear();
    for (const spring of phase.springs ?? this.springs) {
      const [from, to] = endsOf(spring, poses);
      this.lines.rod(from, to, new THREE.Color(springColour(spring, from.distanceTo(to), theme, this.faded)));
    }
  }

  fit(camera: THREE.PerspectiveCamera, height: number, radius: number) {
    this.lines.fit(camera, height, 0.1 * radius, this.faded > 0 ? 1 : 2);
  }

  dispose() {
    this.lines.dispose();
    this.material.dispose();
  }
}
