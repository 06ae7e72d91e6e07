import { describe, expect, it } from "vitest";
import { policyOf } from "../../content_policy";
import { recordingOf, type ReportData } from "./data";
import { column, doubles, floats } from "./tables";
import { jointUnit } from "./units";

const base64 = (numbers: Float32Array | Float64Array) => Buffer.from(numbers.buffer).toString("base64");

const pose = { xyz: [0, 0, 0], quat: [1, 0, 0, 0] } as const;
const body = { mass: 1, com: [0, 0, 0], extent: [], shape: null } as never;

/**
 * Two bodies on revolute joints; the second breaks off at 0.5 s and is welded to the ground at 1 s, when the first is
 * locked.
 */
const data: ReportData = {
  format: 1,
  pose: false,
  thinned: false,
  joints_left_out: false,
  bodies: ["m/a", "m/b"],
  model: {
    title: "two",
    gravity: [0, 0, -9.81],
    bodies: { "m/b": body, "m/a": body },
    joints: {
      "m/a": { kind: "revolute", parent: null, child: "m/a", at: pose, child_at: pose, axis: [0, 1, 0] },
      "m/pin": { kind: "ball", parent: "m/a", child: "m/b", at: pose, child_at: pose },
    },
  },
  events: [],
  about: [],
  summary: null,
  mechanisms: ["m", "m/b"],
  phases: [
    { from: 0, mechanism: [[2, 0]] },
    {
      from: 0.5,
      mechanism: [
        [1, 0],
        [1, 1],
      ],
      gone: ["m/pin"],
    },
    {
      from: 1,
      mechanism: [
        [1, 0],
        [1, 1],
      ],
      joints: [
        { joint: "m/a", kind: "revolute", parent: -1, child: 0, at: [0, 0, 0], childAt: [0, 0, 0], locked: true },
        { joint: "glue", kind: "weld", parent: -1, child: 1, at: [5, 6, 7], childAt: [0, 0, 0], locked: false },
      ],
    },
  ],
  frames: 2,
  time: base64(new Float64Array([0, 1])),
  poses: base64(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 5, 6, 7, 1, 0, 0, 0])),
  joints: { columns: ["m/a.q0", "m/a.v0", "m/b.q0", "m/a.fx"], rows: base64(new Float32Array([1, 2, NaN, 9, 3, 4, 5, 8])) },
  energy: { columns: ["kinetic", "error"], rows: base64(new Float64Array([1, 0, 2, 1e-9])) },
};

describe("tables", () => {
  it("are little-endian numbers", () => {
    expect(Array.from(doubles("AAAAAAAA8D8="))).toEqual([1]);
    expect(Array.from(floats("AACAPwAAAMA="))).toEqual([1, -2]);
    expect(Array.from(column(new Float32Array([1, 2, 3, 4, 5, 6]), 3, 1))).toEqual([2, 5]);
  });
});

describe("the data of a report as a recording", () => {
  const run = recordingOf(data);

  it("numbers bodies as their columns are, not as the model's document is ordered", () => {
    expect(run.model.bodies.map(({ name }) => name)).toEqual(["m/a", "m/b"]);
    expect(run.model.joints.map(({ parent, child }) => [parent, child])).toEqual([
      [-1, 0],
      [0, 1],
    ]);
    expect(Array.from(run.poses(1)).slice(7, 10)).toEqual([5, 6, 7]);
    expect(run.time(1)).toBe(1);
  });

  it("joints go, come, and are locked", () => {
    expect(run.phases.map(({ links }) => links.map(({ joint }) => joint))).toEqual([
      ["m/a", "m/pin"],
      ["m/a"],
      ["m/a", "glue"],
    ]);
    expect(Array.from(run.phases[1].mechanism)).toEqual([0, 1]);
    const [pin, glue] = run.phases[2].links;
    expect([pin.locked, glue.kind, glue.at]).toEqual([true, "weld", [5, 6, 7]]);
    expect(run.phases[0].links[0].locked ?? false).toBe(false);
  });

  it("has a gap before the last row of a run that diverged", () => {
    const diverged = recordingOf({ ...data, summary: { status: "diverged at t = 1 s: joint 'm/a' …" } });
    expect([diverged.gapAfter!(0), run.gapAfter!(0)]).toEqual([true, false]);
  });

  it("has columns by quantity, with units", () => {
    expect(run.joint("m/a", "q").map(({ label, unit, values }) => [label, unit, ...Array.from(values)])).toEqual([
      ["q0", "rad", 1, 3],
    ]);
    expect(run.joint("m/a", "force").map(({ unit, values }) => [unit, values[1]])).toEqual([["N", 8]]);
    expect(run.joint("m/a", "p")).toEqual([]);
    expect(run.joint("none", "q")).toEqual([]);
    expect(run.world("balance")[0].values[1]).toBe(1e-9);
    expect(run.world("linear")).toEqual([]);
  });

  it("units are those of the kind", () => {
    expect(jointUnit("cylindrical", "v", 1)).toBe("m/s");
    expect(jointUnit("free", "p", 0)).toBe("N s");
    expect(jointUnit("ball", "q", 0)).toBe("");
    expect(jointUnit(undefined, "q", 0)).toBe("");
  });
});

describe("the content policy", () => {
  it("names what runs by its hash, and not the data", () => {
    const page = '<style>a</style><script type="module">b</script><script type="application/json">c</script>';
    const policy = policyOf(page);
    expect(policy).toContain("default-src 'none'");
    expect(policy).toContain("script-src 'sha256-PiPoFgA5WUoziU9lZOGxNIu9egCI1CxKy3PurtWcAJ0='"); // of "b"
    expect(policy).toContain("style-src 'sha256-ypeBEsobvcr6wjGzmiPcTaeG7/gUfE5yuYB3ha/uSLs='"); // of "a"
    expect(policy.match(/sha256/g)).toHaveLength(2);
  });
});
