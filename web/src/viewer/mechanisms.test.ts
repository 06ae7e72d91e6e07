import * as THREE from "three";
import { describe, expect, it } from "vitest";
import type { Model, Phase, Shape } from "../recording";
import { mechanismColour, themeOf } from "./colours";
import { MechanismsView } from "./mechanisms";
import { ShapeLibrary } from "./shapes";

const at = { xyz: [0, 0, 0], quat: [1, 0, 0, 0] } as const;
const ball = (colour?: string): Shape => ({ kind: "sphere", radius: 1, at, ...(colour !== undefined && { colour }) });
const body = (name: string, ...shapes: Shape[]) => ({ name, mass: 1, com: [0, 0, 0] as const, extent: [], shapes });
const model: Model = {
  title: "",
  gravity: [0, 0, 0],
  bodies: [body("plain", ball()), body("painted", ball("gold"), ball("#123456"), ball("no colour"))],
  joints: [],
};
const poses = [0, 0, 0, 1, 0, 0, 0, 5, 0, 0, 1, 0, 0, 0];
const phase = (...mechanism: number[]): Phase => ({ from: 0, mechanism, joints: [] });
const theme = themeOf(false);

/** Colours of a body's pickable meshes, and of the visible outlines. */
function colours(view: MechanismsView) {
  const shown: string[][] = [[], []];
  const outlines: string[] = [];
  view.group.traverse((object) => {
    if (!(object instanceof THREE.Mesh) || object instanceof THREE.InstancedMesh || !object.visible) return;
    const material = object.material as THREE.MeshLambertMaterial;
    const colour = `#${material.color.getHexString()}`;
    if (object.userData.body !== undefined) shown[object.userData.body].push(colour);
    else if (material.side === THREE.BackSide) outlines.push(colour);
  });
  return { shown, outlines };
}

describe("joints", () => {
  const bar = { ...body("bar"), extent: [[[0, 0, 0] as const, [1, 0, 0] as const] as const] };
  const bars: Model = { title: "", gravity: [0, 0, 0], bodies: [bar, bar], joints: [] };
  const weld = { name: "#1", kind: "weld", parent: 0, child: 1, at: [5, 0, 0], childAt: [0, 0, 0], loop: true } as const;
  /** Numbers of drawn rods and balls. */
  const drawn = (joints: Phase["joints"]) => {
    const view = new MechanismsView(bars, new ShapeLibrary(bars), { faded: 0, pixels: 4, joints: true });
    view.place(poses, { from: 0, mechanism: [0, 0], joints }, theme);
    view.fit(new THREE.PerspectiveCamera(), 100);
    const counts: number[] = [];
    view.group.traverse((object) => object instanceof THREE.InstancedMesh && counts.push(object.count));
    return counts.slice(0, 2); // then those of springs
  };

  it("that close a loop appear when they are made, and vanish when they are broken", () => {
    expect(drawn([])).toEqual([2, 0]);
    expect(drawn([weld])).toEqual([4, 1]);
  });
});

describe("the bodies' colours", () => {
  const view = () => new MechanismsView(model, new ShapeLibrary(model), { faded: 0, pixels: 4, joints: true });
  const [one, other] = [mechanismColour(theme, 0), mechanismColour(theme, 1)];

  it("are those of their shapes, or of their mechanisms", () => {
    const drawn = view();
    drawn.place(poses, phase(0, 0), theme);
    expect(colours(drawn)).toEqual({ shown: [[one], ["#ffd700", "#123456", one]], outlines: [] });
  });

  it("after a break, outlines distinguish the parts", () => {
    const drawn = view();
    drawn.place(poses, phase(0, 1), theme);
    expect(colours(drawn)).toEqual({ shown: [[one], ["#ffd700", "#123456", other]], outlines: [other, other] });
  });

  it("are those of the mechanisms if own colours are switched off", () => {
    const drawn = view();
    drawn.ownColours = false;
    drawn.place(poses, phase(0, 1), theme);
    expect(colours(drawn)).toEqual({ shown: [[one], [other, other, other]], outlines: [] });
  });
});
