import { describe, expect, it } from "vitest";
import type { Quat, Vec3 } from "../recording";
import { motion, zero } from "./kinematics";
import { compose, exponential, inverse, logarithm, rotate } from "./rotations";
import { coordinatesOf, slidersOf } from "./sliders";

const close = (a: ArrayLike<number>, b: ArrayLike<number>) => Array.from(a).forEach((x, i) => expect(x).toBeCloseTo(b[i], 12));

describe("rotations", () => {
  it("exponential and logarithm are each other's inverse, also near no turn and near a whole one", () => {
    for (const turn of [
      [0, 0, 0],
      [1e-9, 0, 0],
      [0.3, -1, 2],
      [0, 3.1, 0],
    ] as Vec3[])
      close(logarithm(exponential(turn)), turn);
    close(logarithm([-1, 0, 0, 0]), [0, 0, 0]);
  });

  it("a pose and its inverse are nothing", () => {
    const pose = { xyz: [1, 2, 3] as Vec3, quat: exponential([0.4, 0.5, -2]) as Quat };
    const { xyz, quat } = compose(pose, inverse(pose));
    close([...xyz, ...quat], [0, 0, 0, 1, 0, 0, 0]);
    close(rotate(exponential([0, 0, Math.PI / 2]), [1, 0, 0]), [0, 1, 0]);
  });
});

describe("kinds of joint", () => {
  it("at their zero they move nothing", () => {
    const kinds = ["revolute", "prismatic", "helical", "cylindrical", "universal", "ball", "planar", "free", "weld"] as const;
    for (const kind of kinds) {
      const { xyz, quat } = motion({ kind, axis: [1, 1, 0], axis2: [0, 0, 1], pitch: 2 }, zero(kind));
      close([...xyz, ...quat], [0, 0, 0, 1, 0, 0, 0]);
    }
  });

  it("a screw goes its pitch in one turn", () => {
    close(motion({ kind: "helical", axis: [0, 0, 2], pitch: 0.1 }, [2 * Math.PI]).xyz, [0, 0, 0.1]);
  });

  it("sliders stand for coordinates and back", () => {
    for (const [kind, q] of [
      ["ball", [...exponential([0.1, 0.2, 0.3])]],
      ["free", [1, 2, 3, ...exponential([0, 0, 1])]],
      ["planar", [1, 2, 3]],
    ] as const)
      close(coordinatesOf(kind, slidersOf(kind, q)), q);
  });
});
