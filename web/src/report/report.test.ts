import { describe, expect, it } from "vitest";
import { policyOf } from "../../content_policy";
import type { Pose } from "../recording";
import type { EventFile } from "../result_files";
import { recordingOf, type ReportData } from "./data";
import { column, doubles, floats } from "./tables";

const base64 = (numbers: Float32Array | Float64Array) => Buffer.from(numbers.buffer).toString("base64");

const pose: Pose = { xyz: [0, 0, 0], quat: [1, 0, 0, 0] };
const body = { mass: 1, com: [0, 0, 0], extent: [], shape: null } as never;

const joint = (kind: string, parent: string | null, child: string) => ({ kind, parent, child, at: pose, child_at: pose });
const event = (time: number, topology: EventFile["topology"]) =>
  ({ time, event: "#", actions: [], changes: [], ...(topology && { topology }) }) as unknown as EventFile;

/**
 * Two bodies on joints; the second breaks off at 0.5 s and is welded to the ground at 1 s, when the first is locked.
 */
const data: ReportData = {
  format: 1,
  thinned: false,
  joints_left_out: false,
  bodies: ["m/a", "m/b"],
  kinds: {
    revolute: { q: ["rad"], v: ["rad/s"], p: ["N m s"] },
    ball: { q: ["", "", "", ""], v: ["rad/s", "rad/s", "rad/s"], p: ["N m s", "N m s", "N m s"] },
    free: { q: ["m", "m", "m", "", "", "", ""], v: ["m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s"], p: [] },
    weld: { q: [], v: [], p: [] },
  },
  model: {
    title: "two",
    gravity: [0, 0, -9.81],
    mechanisms: [{ name: "m", bodies: ["m/b", "m/a"] }],
    bodies: { "m/b": body, "m/a": body },
    joints: { "m/a": joint("revolute", null, "m/a"), "m/elbow": joint("ball", "m/a", "m/b") },
  },
  events: [
    event(0.25, undefined),
    event(0.5, { gone: ["m/elbow"], joints: { "m/b": joint("free", null, "m/b") }, moved: { "m/b": [[1, 1]] } }),
    event(1, {
      gone: ["m/b"],
      joints: {
        "m/a": { ...joint("revolute", null, "m/a"), locked: true },
        glue: { ...joint("weld", null, "m/b"), at: { ...pose, xyz: [5, 6, 7] } },
      },
      moved: {},
    }),
  ],
  summary: null,
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

describe("contacts in a report", () => {
  it("have their points and forces at each frame", () => {
    const rows = new Float32Array([1, 2, 3, 0, 0, 1, 4, 5, 6, 0, 7, 8, 9, 0, 0, 1, 10, 11, 12, 0.5]);
    const contacts = { counts: [0, 2], rows: base64(rows) };
    const run = recordingOf({ ...data, contacts });
    expect(run.contacts!(0)).toEqual([]);
    expect(run.contacts!(1)).toEqual([
      { point: [1, 2, 3], force: [4, 5, 6] },
      { point: [7, 8, 9], force: [10, 11, 12] },
    ]);
    expect(recordingOf(data).contacts).toBeUndefined();
  });

  it("lie on the planes of the model", () => {
    const planes = [{ point: [0, 0, -1], normal: [0, 0, 1] }] as const;
    expect(recordingOf({ ...data, model: { ...data.model, planes: [...planes] } }).model.planes).toEqual(planes);
    expect(recordingOf(data).model.planes).toBeUndefined();
  });
});

describe("the data of a report as a recording", () => {
  const run = recordingOf(data);

  it("numbers bodies in the order of their columns, not of the model's document", () => {
    expect(run.model.bodies.map(({ name }) => name)).toEqual(["m/a", "m/b"]);
    expect(run.model.joints.map(({ parent, child }) => [parent, child])).toEqual([
      [-1, 0],
      [0, 1],
    ]);
    expect(Array.from(run.poses(1)).slice(7, 10)).toEqual([5, 6, 7]);
    expect(run.time(1)).toBe(1);
  });

  it("a joint that closes a loop is in addition to the inboard joints, until it takes the place of one", () => {
    const clasp = joint("ball", "m/a", "m/b");
    const closed = recordingOf({
      ...data,
      events: [
        event(0.5, { gone: [], joints: { clasp: { ...clasp, loop: true } }, moved: {} }),
        event(1, { gone: ["m/elbow"], joints: { clasp }, moved: {} }),
      ],
    });
    expect(closed.phases.map(({ joints }) => joints.map(({ name, loop, wasLoop }) => [name, loop, wasLoop]))).toEqual([
      [
        ["m/a", undefined, undefined],
        ["m/elbow", undefined, undefined],
      ],
      [
        ["m/a", undefined, undefined],
        ["m/elbow", undefined, undefined],
        ["clasp", true, undefined],
      ],
      [
        ["m/a", undefined, undefined],
        ["clasp", undefined, true],
      ],
    ]);
    expect(closed.mechanisms).toEqual(["m"]); // one colour
  });

  it("events remove, make and lock joints, and separate mechanisms", () => {
    expect(run.phases.map(({ from, joints }) => [from, ...joints.map(({ name }) => name)])).toEqual([
      [0, "m/a", "m/elbow"],
      [0.5, "m/a", "m/b"],
      [1, "m/a", "glue"],
    ]);
    expect(run.mechanisms).toEqual(["m", "m/b"]);
    expect(run.phases.map(({ mechanism }) => [...Array.from(mechanism)])).toEqual([
      [0, 0],
      [0, 1],
      [0, 1],
    ]);
    const [first, glue] = run.phases[2].joints;
    expect([first.locked, glue.kind, glue.at]).toEqual([true, "weld", [5, 6, 7]]);
    expect(run.phases[0].joints[0].locked).toBe(false);
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

  it("a column has a unit if all kinds of its joint agree on it", () => {
    const columns = ["q0", "q3", "v0", "v3", "v5"].map((name) => `m/b.${name}`);
    const broken = event(0.5, { gone: [], joints: { "m/b": joint("free", null, "m/b") }, moved: {} });
    const model = { ...data.model, joints: { ...data.model.joints, "m/b": joint("ball", "m/a", "m/b") } };
    const joints = { columns, rows: base64(new Float32Array(10)) };
    const changed = recordingOf({ ...data, model, joints, events: [broken] });
    expect([...changed.joint("m/b", "q"), ...changed.joint("m/b", "v")].map(({ unit }) => unit)).toEqual([
      "",
      "",
      "",
      "rad/s",
      "rad/s",
    ]);
  });
});

describe("the content policy", () => {
  it("allows scripts and styles by their hashes, and ignores the data", () => {
    const page = '<style>a</style><script type="module">b</script><script type="application/json">c</script>';
    const policy = policyOf(page);
    expect(policy).toContain("default-src 'none'");
    expect(policy).toContain("script-src 'sha256-PiPoFgA5WUoziU9lZOGxNIu9egCI1CxKy3PurtWcAJ0='"); // of "b"
    expect(policy).toContain("style-src 'sha256-ypeBEsobvcr6wjGzmiPcTaeG7/gUfE5yuYB3ha/uSLs='"); // of "a"
    expect(policy.match(/sha256/g)).toHaveLength(2);
  });
});
