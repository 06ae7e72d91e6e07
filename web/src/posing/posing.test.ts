import { readFileSync } from "node:fs";
import { beforeAll, describe, expect, it } from "vitest";
import { Engine } from "../../../wasm/host.mjs";
import type { Vec3 } from "../recording";
import { exponential, logarithm } from "./rotations";
import { coordinatesOf, labelsOf, valuesOf } from "./sliders";

const close = (a: ArrayLike<number>, b: ArrayLike<number>, digits = 12) => {
  expect(a.length).toBe(b.length);
  Array.from(a).forEach((x, i) => expect(x).toBeCloseTo(b[i], digits));
};

describe("rotation vectors", () => {
  it("exponential and logarithm are inverse functions, also near zero and near a whole turn", () => {
    for (const vector of [
      [0, 0, 0],
      [1e-9, 0, 0],
      [0.3, -1, 2],
      [0, 3.1, 0],
    ] as Vec3[])
      close(logarithm(exponential(vector)), vector);
    close(logarithm([-1, 0, 0, 0]), [0, 0, 0]);
  });
});

describe("sliders", () => {
  it("have labels by the units of the coordinates", () => {
    const labels = (...units: string[]) => labelsOf(units).map(({ label }) => label);
    expect(labels("rad")).toEqual(["angle"]);
    expect(labels("rad", "m")).toEqual(["angle q0", "displacement q1"]);
    expect(labels("m", "", "", "", "")).toEqual(["displacement q0", "rotation x", "rotation y", "rotation z"]);
    expect(labels()).toEqual([]);
  });

  it("represent the coordinates of any kind", () => {
    for (const [units, q] of [
      [
        ["rad", "m"],
        [1, 2],
      ],
      [
        ["m", "", "", "", "", "rad"],
        [1, ...exponential([0.1, 0.2, 0.3]), 2],
      ],
      [
        ["", "", "", "", "", "", "", ""],
        [...exponential([0, 0, 1]), ...exponential([2, 0, 1])],
      ],
    ] as const) {
      close(coordinatesOf(units, valuesOf(units, q)), q);
      expect(valuesOf(units, q)).toHaveLength(labelsOf(units).length);
    }
  });
});

describe("the engine", () => {
  let engine: Engine;
  beforeAll(async () => {
    engine = await Engine.of(readFileSync(new URL("../../engine/momentree.wasm", import.meta.url)));
  });

  it("poses bodies as in a run with the same coordinates: all kinds of joint", () => {
    const world = engine.world();
    const text = readFileSync(new URL("../../../scenarios/tree_of_joints.toml", import.meta.url), "utf8");
    expect(world.load(text).scenario).not.toBeNull();
    const start = Array.from(world.motions());
    const { joints } = world.topology();
    expect(new Set(joints.map(({ kind }) => kind))).toEqual(new Set(Object.keys(world.kinds())));
    world.run(0.5);
    const poses = (motions: ArrayLike<number>) => Array.from(motions).filter((_number, i) => i % 13 < 7);
    const now = poses(world.motions());
    close(poses(world.motionsAt(joints.flatMap(({ row }) => world.coordinates(row)))), now);
    close(now, poses(world.motions()), 15); // the world has not changed
    expect(Math.max(...now.map((x, i) => Math.abs(x - poses(start)[i])))).toBeGreaterThan(0.05);
  });

  it("keeps loops closed, and the last pose where that is impossible", () => {
    const world = engine.world();
    const bars = `format = 1
[[mechanism]]
name = "bars"
[mechanism.chain]
links = 3
length = 1
mass = 1
inertia = 0.1
angle = "40 deg"
[[loop]]
name = "pin"
kind = "revolute"
body = "bars/3"
at = { xyz = [1.5, 0, 0] }
child_at = { xyz = [1, 0, 0] }
`;
    expect(world.load(bars).diagnostics.filter(({ severity }) => severity === "error")).toEqual([]);
    const { joints } = world.topology();
    const q = joints.filter(({ loop }) => !loop).flatMap(({ row }) => world.coordinates(row));
    expect(q).toHaveLength(3);
    const end = (motions: Float64Array) => {
      const [x, y, , w, , , qz] = motions.subarray(26, 33);
      return [x + 1 - 2 * qz * qz, y + 2 * w * qz];
    };
    const start = Array.from(world.motionsAt(q));
    close(end(Float64Array.from(start)), [1.5, 0], 9);
    const turned = Float64Array.from(world.motionsAt([q[0] + 0.3, q[1], q[2]]));
    const posed = world.posed();
    expect(posed[0]).toBe(q[0] + 0.3); // the joint that was moved stays there
    expect(posed[2]).not.toBe(q[2]);
    close(end(turned), [1.5, 0], 9);
    expect(Math.hypot(turned[13] - start[13], turned[14] - start[14])).toBeCloseTo(2 * Math.sin(0.15), 9);
    expect(world.motionsAt([NaN, 0, 0]).every((x) => Number.isFinite(x))).toBe(true);
  });
});
