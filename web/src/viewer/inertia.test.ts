import * as THREE from "three";
import { describe, expect, it } from "vitest";
import type { Body, Joint, Model } from "../recording";
import { lengthText, onPlane, roundLength } from "./floor";
import { ellipsoidOf, principal, roomAround } from "./inertia";

let seed = 7;
const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
const turnOf = () => new THREE.Quaternion(random() - 0.5, random() - 0.5, random() - 0.5, random() - 0.5).normalize();
/** R diag(moments) Rᵀ as xx, yy, zz, xy, xz, yz. */
function rotated(moments: readonly number[], turn: THREE.Quaternion): number[] {
  const e = new THREE.Matrix4().makeRotationFromQuaternion(turn).elements; // columns
  const of = (r: number, c: number) => moments.reduce((sum, m, k) => sum + m * e[4 * k + r] * e[4 * k + c], 0);
  return [of(0, 0), of(1, 1), of(2, 2), of(0, 1), of(0, 2), of(1, 2)];
}
const body = (mass: number, inertia: readonly number[], extent: Body["extent"] = []): Body => ({
  name: "",
  mass,
  com: [0, 0, 0],
  inertia,
  extent,
  shapes: [],
});

describe("the ellipsoid of a body's inertia", () => {
  it("is the ellipsoid that the inertia was computed from, however it is turned", () => {
    for (let n = 0; n < 200; n++) {
      const mass = 0.1 + 5 * random();
      const semi = [0.5 + random(), 0.5 + random(), 0.5 + random()];
      const [a, b, c] = semi.map((x) => x * x);
      const moments = [b + c, a + c, a + b].map((x) => (mass / 5) * x);
      const inertia = rotated(moments, turnOf());
      const found = ellipsoidOf(body(mass, inertia))!;
      expect([...found.semi].sort()).toEqual([...semi].sort().map((x) => expect.closeTo(x, 9)));
      // Its own inertia is the one that was given.
      const back = rotated(
        [0, 1, 2].map((k) => (mass / 5) * ([0, 1, 2].reduce((s, l) => s + found.semi[l] ** 2, 0) - found.semi[k] ** 2)),
        found.turn,
      );
      back.forEach((x, i) => expect(x).toBeCloseTo(inertia[i], 9));
    }
  });

  it("has principal axes that are orthonormal and diagonalise the matrix", () => {
    const { moments, axes } = principal([3, 2, 1, 0.5, -0.2, 0.1]);
    const m = [
      [3, 0.5, -0.2],
      [0.5, 2, 0.1],
      [-0.2, 0.1, 1],
    ];
    for (let k = 0; k < 3; k++)
      for (let r = 0; r < 3; r++)
        expect(m[r].reduce((s, x, c) => s + x * axes[c][k], 0)).toBeCloseTo(moments[k] * axes[r][k], 12);
  });

  it("does not exist for point masses, and for bodies that are drawn by lines", () => {
    const line: Body["extent"] = [
      [
        [0, 0, 0],
        [1, 0, 0],
      ],
    ];
    expect(ellipsoidOf(body(1, [0, 0, 0, 0, 0, 0]))).toBeNull();
    expect(ellipsoidOf(body(1, [0.1, 0.1, 0.1, 0, 0, 0], line))).toBeNull();
    expect(ellipsoidOf(body(1, [0.1, 0.1, 0.1, 0, 0, 0]))!.semi[0]).toBeCloseTo(0.5, 12);
  });

  it("of a placeholder inertia is small beside the neighbours; a disc that fits between them is drawn as it is", () => {
    const line = (length: number): Body["extent"] => [
      [
        [0, 0, 0],
        [length, 0, 0],
      ],
    ];
    const none = [1, 1, 1, 0, 0, 0];
    const bodies = [body(1, none, line(0.2)), body(0.4, none), body(0.4, none), body(0.4, none), body(0.4, none)];
    const joint = (parent: number, child: number): Joint => ({
      ...{ name: "", kind: "revolute", parent, child, at: [0, 0, 0], childAt: [0, 0, 0] },
    });
    const joints = [joint(-1, 0), joint(0, 1), joint(1, 2), joint(-1, 3), joint(3, 4)];
    const model: Model = { title: "", gravity: [0, 0, 0], bodies, joints };
    expect([1, 2, 3, 4].map((b) => roomAround(model, b))).toEqual([0.2, 0.2, Infinity, Infinity]);
    expect(ellipsoidOf(bodies[1], 0.2)!.semi.map((x) => x.toFixed(9))).toEqual(Array(3).fill("0.040000000"));
    expect(ellipsoidOf(bodies[3], Infinity)!.semi[0]).toBeCloseTo(2.5, 12);
    const disc = ellipsoidOf(body(1, [0.002, 0.001, 0.001, 0, 0, 0]), 0.2)!;
    expect(Math.max(...disc.semi)).toBeCloseTo(Math.sqrt(2.5 * 0.002), 12);
  });
});

describe("the scale of the floor", () => {
  it("is a round length, of which at least eight fit", () => {
    for (const size of [0.003, 0.07, 1, 8, 9.99, 41, 1234]) {
      const square = roundLength(size);
      expect(size / square).toBeGreaterThanOrEqual(8 - 1e-9);
      expect(size / square).toBeLessThan(20.1);
      expect(["1", "2", "5"]).toContain(square.toExponential()[0]);
    }
    expect([0.5, 0.02, 2000, 0.001].map(lengthText)).toEqual(["50 cm", "2 cm", "2 km", "1 mm"]);
  });
});

describe("the floor of the world", () => {
  it("is the plane, whatever its normal's length and wherever one looks", () => {
    const plane = { point: [1, 2, 3], normal: [0, 3, 4] } as const;
    const at = onPlane(new THREE.Vector3(7, -1, 5), plane);
    expect(
      at
        .clone()
        .sub(new THREE.Vector3(...plane.point))
        .dot(new THREE.Vector3(...plane.normal)),
    ).toBeCloseTo(0, 12);
    expect(
      new THREE.Vector3(7, -1, 5)
        .sub(at)
        .cross(new THREE.Vector3(...plane.normal))
        .length(),
    ).toBeCloseTo(0, 12);
  });
});
