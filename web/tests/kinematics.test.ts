// The page's own kinematics, against where the engine puts the bodies for the same coordinates: all kinds of joint.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, it } from "vitest";
import { posesOf } from "../src/model/kinematics";
import { modelOf } from "../src/report/data";
import { report, scenario } from "./browser";
import { csv } from "./tables";

it("places bodies where the engine does", () => {
  const folder = report(scenario("tree_of_joints.toml"), "--until", "0.5");
  const file = JSON.parse(readFileSync(join(folder, "model.json"), "utf8"));
  const model = modelOf(file, Object.keys(file.bodies));
  expect(new Set(model.joints.map(({ kind }) => kind)).size).toBe(9);
  const bodies = csv(folder, "bodies.csv");
  const joints = csv(folder, "joints.csv");
  expect(bodies.length).toBeGreaterThan(10);
  let moved = 0;
  bodies.forEach((row, r) => {
    const coordinates = new Map(
      model.joints.map(({ name }) => {
        const q: number[] = [];
        for (let k = 0; Number.isFinite(joints[r][`${name}.q${k}`]); k++) q.push(joints[r][`${name}.q${k}`]);
        return [name, q];
      }),
    );
    const poses = posesOf(model, coordinates);
    model.bodies.forEach(({ name }, b) => {
      const engine = ["x", "y", "z", "qw", "qx", "qy", "qz"].map((part) => row[`${name}.${part}`]);
      const page = Array.from(poses.slice(7 * b, 7 * b + 7));
      const sign = engine.slice(3).reduce((sum, q, k) => sum + q * page[3 + k], 0) < 0 ? -1 : 1;
      engine.forEach((x, k) =>
        expect(Math.abs((k < 3 ? 1 : sign) * page[k] - x), `${name} at ${row.time}`).toBeLessThan(1e-10),
      );
      moved = Math.max(moved, Math.abs(engine[0] - bodies[0][`${name}.x`]));
    });
  });
  expect(moved).toBeGreaterThan(0.05); // else the test would say little
});
