import { describe, expect, it } from "vitest";
import { modelOf, phasesOf, type EventFile, type ModelFile } from "../result_files";
import { mixed, themeOf } from "./colours";
import { endsOf, springColour, SpringLines } from "./springs";

const pose = { xyz: [0, 0, 0] as const, quat: [1, 0, 0, 0] as const };
const end = (body: string, ...point: [number, number, number]) => ({ body, point });
const spring = (name: string, more = {}) => ({
  [name]: {
    from: end("ground", 0, 0, 3),
    to: end("m/b", 0, 1, 0),
    stiffness: 10,
    rest: 2,
    tension_only: true,
    strength: 20,
    broken: false,
    ...more,
  },
});
const file: ModelFile = {
  title: "",
  gravity: [0, 0, 0],
  mechanisms: [{ name: "m", bodies: ["m/a", "m/b"] }],
  bodies: Object.fromEntries(["m/a", "m/b"].map((name) => [name, { mass: 1, com: pose.xyz, extent: [], shape: null }])),
  joints: {},
  springs: {
    ...spring("rope"),
    ...spring("gone", { broken: true }),
    ...spring("elsewhere", { to: end("n/c", 0, 0, 0) }),
    ...spring("other", { from: end("m/a", 1, 0, 0), strength: null }),
  },
};
const theme = themeOf(false);

describe("springs", () => {
  const model = modelOf(file, ["m/b", "m/a"]);
  const [rope, other] = model.springs!;

  it("are those that act between known bodies, numbered as these are", () => {
    expect(model.springs!.map(({ name, from, to, strength }) => [name, from, to, strength])).toEqual([
      ["rope", -1, 0, 20],
      ["other", 1, 0, null],
    ]);
  });

  it("vanish when an event breaks them", () => {
    const event = { time: 1, topology: { gone: [], joints: {}, moved: {}, broken_springs: ["rope"] } } as unknown as EventFile;
    const { phases } = phasesOf(file, model, [event]);
    expect(phases.map(({ springs }) => springs!.map(({ name }) => name))).toEqual([["rope", "other"], ["other"]]);
  });

  it("join their points, which move with the bodies", () => {
    const poses = [1, 0, 0, Math.SQRT1_2, 0, 0, Math.SQRT1_2, 0, 0, 5, 1, 0, 0, 0]; // m/b is rotated by 90° about z
    expect(endsOf(rope, poses).map((at) => at.toArray().map((x) => Math.round(1e9 * x) / 1e9 + 0))).toEqual([
      [0, 0, 3],
      [0, 0, 0],
    ]);
    expect(endsOf(other, poses)[0].toArray()).toEqual([1, 0, 5]);
    const lines = new SpringLines(model.springs!, 0);
    lines.place(poses, { from: 0, mechanism: [0, 0], joints: [] }, theme);
    lines.dispose();
  });

  it("are pale while slack, and redder the nearer they are to their strength", () => {
    const [pale, plain] = [0.7, 0.35].map((share) => mixed(theme.ink, theme.ground, share));
    expect(springColour(rope, 1.9, theme, 0)).toBe(pale);
    expect(springColour(rope, 3, theme, 0)).toBe(mixed(plain, "#d8342b", 0.5));
    expect(springColour(rope, 9, theme, 0)).toBe("#d8342b");
    expect(springColour(other, 9, theme, 0)).toBe(plain);
    expect(springColour(rope, 9, theme, 1)).toBe(theme.ground);
    const cable = { ...rope, stiffness: 0, tensionOnly: false, inextensible: true };
    expect(springColour(cable, 0.999 * cable.rest, theme, 0)).toBe(pale);
    expect(springColour(cable, cable.rest, theme, 0)).toBe(plain);
  });
});
