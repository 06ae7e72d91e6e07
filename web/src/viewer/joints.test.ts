import { describe, expect, it } from "vitest";
import type { Joint, Model } from "../recording";
import { inboardJoints } from "./frames";
import { shownJoint, withHistory } from "./joints";
import { endOf, leafBodies } from "./trails";

const joint = (name: string, kind: string, parent: number, child: number, rest: Partial<Joint> = {}): Joint => ({
  name,
  kind,
  parent,
  child,
  at: [0, 0, 0],
  childAt: [0, 0, 0],
  ...rest,
});
const bar = (name: string) => ({
  name,
  mass: 1,
  com: [0.5, 0, 0] as const,
  extent: [[[0, 0, 0] as const, [1, 0, 0] as const] as const],
  shapes: [],
});
/** Three bars in a row, closed by the ground at the far end. */
const model: Model = {
  title: "",
  gravity: [0, 0, -9.81],
  bodies: [bar("a"), bar("b"), bar("c")],
  joints: [
    joint("a", "revolute", -1, 0),
    joint("b", "revolute", 0, 1, { at: [1, 0, 0] }),
    joint("c", "revolute", 1, 2, { at: [1, 0, 0] }),
    joint("pin", "revolute", -1, 2, { at: [3, 0, 0], childAt: [1, 0, 0], loop: true }),
  ],
};
const poses = [0, 1, 2].flatMap((x) => [x, 0, 0, 1, 0, 0, 0]);

describe("a joint that closes a loop", () => {
  it("is not the inboard joint of its child", () => {
    expect([...inboardJoints(model.joints)].map(([body, { name }]) => [body, name])).toEqual([
      [0, "a"],
      [1, "b"],
      [2, "c"],
    ]);
    expect(leafBodies(model)).toEqual([2]);
    expect(endOf(model, 2)).toEqual([0, 0, 0]); // the other end does not move
    expect(endOf(model, 1)).toEqual([1, 0, 0]);
  });

  it("of the model has no lines of its own: those of its bodies reach to it", () => {
    expect(shownJoint(model, model.joints[3], poses)).toEqual({ at: [3, 0, 0], lines: [] });
  });

  it("that was made in the run has lines from its bodies, where it is away from them", () => {
    const made = joint("clasp", "revolute", 0, 2, { at: [1.5, 1, 0], childAt: [-0.5, 1, 0], loop: true });
    const { at, lines } = shownJoint(model, made, poses);
    expect(at).toEqual([1.5, 1, 0]);
    expect(lines).toEqual([
      { body: 2, from: [2, 0, 0], to: [1.5, 1, 0] },
      { body: 0, from: [1, 0, 0], to: [1.5, 1, 0] },
    ]);
    expect(shownJoint(model, { ...made, at: [0.5, 0, 0], childAt: [1, 0, 0] }, poses).lines).toEqual([]);
  });

  it("that is a weld made in the run is a strut, also after it has taken the place of a broken joint", () => {
    const weld = joint("#1", "weld", 0, 2, { at: [2, 0, 0], loop: true });
    const strut = shownJoint(model, weld, poses);
    expect(strut.at).toEqual([1.5, 0, 0]);
    expect(strut.lines.map(({ body, from }) => [body, from])).toEqual([
      [0, [0.5, 0, 0]],
      [2, [2.5, 0, 0]],
    ]);
    const [after] = withHistory([{ ...weld, loop: false }], [weld]);
    expect(after).toMatchObject({ loop: false, wasLoop: true });
    expect(shownJoint(model, after, poses)).toEqual(strut);
    expect(withHistory([after], [after])[0].wasLoop).toBe(true);
    expect(withHistory([joint("d", "weld", 0, 2)], [weld])[0].wasLoop).toBeUndefined();
  });
});

describe("a weld that was made in the run", () => {
  const weld = joint("d", "weld", 0, 2, { at: [2, 0, 0] });

  it("is a strut if its bodies are apart, also if it closes no loop", () => {
    const { at, lines } = shownJoint(model, weld, poses);
    expect(at).toEqual([1.5, 0, 0]);
    expect(lines.map(({ body, from }) => [body, from])).toEqual([
      [0, [0.5, 0, 0]],
      [2, [2.5, 0, 0]],
    ]);
    const had = { ...model, joints: [...model.joints, joint("d", "weld", 2, 0)] };
    expect(shownJoint(had, weld, poses).lines).toEqual([]); // a joint of the model
    const other = { ...model, joints: [...model.joints, joint("d", "weld", 1, 2)] };
    expect(shownJoint(other, weld, poses).lines).toHaveLength(2); // an earlier one had its name
  });

  it("is nothing to see if its bodies touch, as after a grasp", () => {
    expect(shownJoint(model, joint("d", "weld", 0, 1, { at: [1, 0, 0] }), poses).lines).toEqual([]);
    const across = [0, 0, 0, 1, 0, 0, 0, ...poses.slice(7, 14), 0.5, -0.5, 0.1, Math.SQRT1_2, 0, 0, Math.SQRT1_2];
    expect(shownJoint(model, weld, across).lines).toEqual([]);
  });

  it("of a body with shapes begins at their surfaces", () => {
    const at = { xyz: [0, 0, 0] as const, quat: [1, 0, 0, 0] as const };
    const box = (half: number) => ({ kind: "box" as const, size: [2 * half, 0, 0] as const, at });
    const boxes = (half: number): Model => ({
      ...model,
      bodies: model.bodies.map((body) => ({ ...body, com: [0, 0, 0], extent: [], shapes: [box(half)] })),
    });
    expect(shownJoint(boxes(1), weld, poses).lines).toEqual([]);
    expect(shownJoint(boxes(0.5), weld, poses).lines).toHaveLength(2);
  });
});
