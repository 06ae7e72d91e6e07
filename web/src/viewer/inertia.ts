// The ellipsoid of uniform density that has a body's mass and inertia: it shows how the mass is distributed where a body has no
// shape.
import * as THREE from "three";
import type { Body, Model } from "../recording";

/** Eigenvalues and eigenvectors (columns of a rotation) of a symmetric matrix xx, yy, zz, xy, xz, yz; Jacobi's method. */
export function principal([xx, yy, zz, xy, xz, yz]: readonly number[]): { moments: number[]; axes: number[][] } {
  const a = [
    [xx, xy, xz],
    [xy, yy, yz],
    [xz, yz, zz],
  ];
  const v = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  for (let sweep = 0; sweep < 30; sweep++) {
    const off = Math.abs(a[0][1]) + Math.abs(a[0][2]) + Math.abs(a[1][2]);
    if (off <= 1e-15 * (Math.abs(a[0][0]) + Math.abs(a[1][1]) + Math.abs(a[2][2]))) break;
    for (const [p, q] of [
      [0, 1],
      [0, 2],
      [1, 2],
    ]) {
      if (a[p][q] === 0) continue;
      const theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
      const t = (theta >= 0 ? 1 : -1) / (Math.abs(theta) + Math.hypot(theta, 1));
      const c = 1 / Math.hypot(t, 1);
      const s = t * c;
      for (let k = 0; k < 3; k++) [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
      for (let k = 0; k < 3; k++) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
      for (let k = 0; k < 3; k++) [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
    }
  }
  return { moments: [a[0][0], a[1][1], a[2][2]], axes: v };
}

export interface Ellipsoid {
  /** Semi-axes (m), along the columns of `turn`. */
  readonly semi: readonly [number, number, number];
  readonly turn: THREE.Quaternion;
}

const lengthsOf = ({ extent }: Body) => extent.map(([a, b]) => Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]));

/** The longest line of the bodies nearest to a body along joints that have lines (m); Infinity if none of its mechanism has. */
export function roomAround(model: Model, body: number): number {
  const reached = new Set([body]);
  let ring = [body];
  while (ring.length > 0) {
    const next = new Set<number>();
    for (const { parent, child } of model.joints) {
      if (ring.includes(parent) && !reached.has(child)) next.add(child);
      if (ring.includes(child) && parent >= 0 && !reached.has(parent)) next.add(parent);
    }
    ring = [...next];
    for (const each of ring) reached.add(each);
    const longest = Math.max(0, ...ring.flatMap((each) => lengthsOf(model.bodies[each])));
    if (longest > 0) return longest;
  }
  return Infinity;
}

/** The semi-axis of bodies without lines of which the inertia can't be that of a body of this size, as a share of the room. */
const placeholder = 0.2;

/**
 * null for a point mass, and for a body that its lines show. `room`: a body that would be larger is drawn small, as its inertia
 * is a placeholder.
 */
export function ellipsoidOf(body: Body, room = Infinity): Ellipsoid | null {
  const { mass, inertia } = body;
  if (!inertia || !(mass > 0) || body.extent.length > 0) return null;
  const { moments, axes } = principal(inertia);
  const [i, j, k] = moments;
  if (!(Math.max(i, j, k) > 0)) return null;
  const half = (sum: number) => Math.sqrt(Math.max((2.5 / mass) * sum, 0));
  const semi = [half(j + k - i), half(i + k - j), half(i + j - k)];
  const longest = Math.max(...semi);
  const bound = longest > room ? placeholder * room : longest;
  const basis = new THREE.Matrix4().makeBasis(
    new THREE.Vector3(axes[0][0], axes[1][0], axes[2][0]),
    new THREE.Vector3(axes[0][1], axes[1][1], axes[2][1]),
    new THREE.Vector3(axes[0][2], axes[1][2], axes[2][2]),
  );
  const clamp = (x: number) => Math.min(Math.max(x, 0.12 * bound), bound);
  return { semi: [clamp(semi[0]), clamp(semi[1]), clamp(semi[2])], turn: new THREE.Quaternion().setFromRotationMatrix(basis) };
}
