import { describe, expect, it } from "vitest";
import type { Motion } from "../recording";
import { ArrowScale } from "./arrows";
import { Box3, BoxGeometry, Vector3 } from "three";
import { viewOf } from "./camera";
import { hexOf, mixed, shapeColour, themeOf } from "./colours";
import { frameAt, isGap, lastNotAfter, phaseAt, pointOf, posesAt } from "./frames";
import { ghostSpacing, ghostTimes } from "./ghosts";
import { addOutward } from "./outline";
import { Player } from "./player";
import { between, leafBodies } from "./trails";

const half = Math.SQRT1_2;

/**
 * One body that moves along x and rotates by 90° about z within a second; another pair of frames has the same instant.
 */
function recording(): Motion {
  const frames = [
    [0, 0, 0, 1, 0, 0, 0],
    [2, 0, 0, half, 0, 0, half],
    [4, 0, 0, -half, 0, 0, -half], // the same rotation with the other sign
  ];
  const times = [0, 1, 2];
  return {
    model: {
      title: "",
      gravity: [0, 0, -9.81],
      bodies: [{ name: "a", mass: 1, com: [0, 0, 0], extent: [], shapes: [] }],
      joints: [],
    },
    frames: 3,
    time: (frame) => times[frame],
    poses: (frame) => frames[frame],
    events: [],
    phases: [
      { from: 0, mechanism: [0], joints: [] },
      { from: 0.5, mechanism: [1], joints: [] },
    ],
    mechanisms: ["a", "b"],
  };
}

describe("frames", () => {
  it("finds the last index that is not beyond a time", () => {
    const times = [0, 1, 1, 2];
    const at = (time: number) => lastNotAfter(times.length, (i) => times[i], time);
    expect([-1, 0, 0.5, 1, 1.5, 2, 9].map(at)).toEqual([0, 0, 0, 2, 2, 3, 3]);
    expect(frameAt(recording(), 1.99)).toBe(1);
  });

  it("a phase is valid from its instant on", () => {
    expect(phaseAt(recording(), 0.49).mechanism[0]).toBe(0);
    expect(phaseAt(recording(), 0.5).mechanism[0]).toBe(1);
  });

  it("positions lie on the line and rotations on the arc between two frames", () => {
    const poses = posesAt(recording(), 1 / 3, new Float64Array(7));
    expect(poses[0]).toBeCloseTo(2 / 3, 12);
    expect(2 * Math.atan2(poses[6], poses[3])).toBeCloseTo(Math.PI / 6, 12); // a third of 90°
  });

  it("takes the shorter arc if the signs of quaternions differ, and does not extrapolate", () => {
    const poses = posesAt(recording(), 1.5, new Float64Array(7));
    expect(Math.abs(2 * Math.atan2(poses[6], poses[3]))).toBeCloseTo(Math.PI / 2, 12);
    expect(posesAt(recording(), 99, new Float64Array(7))[0]).toBe(4);
    expect(posesAt(recording(), -1, new Float64Array(7))[0]).toBe(0);
  });

  it("does not interpolate if the motion between two frames is unknown", () => {
    const wild: Motion = { ...recording(), gapAfter: (frame) => frame === 1 };
    expect(posesAt(wild, 0.5, new Float64Array(7))[0]).toBe(1);
    expect(posesAt(wild, 1.9, new Float64Array(7))[0]).toBe(2);
    expect(posesAt(wild, 2, new Float64Array(7))[0]).toBe(4);
    // After 160°, it may as well have rotated in the opposite direction.
    const [c, s] = [Math.cos((80 * Math.PI) / 180), Math.sin((80 * Math.PI) / 180)];
    const fast: Motion = { ...recording(), poses: (frame) => [frame, 0, 0, frame === 1 ? c : 1, 0, 0, frame === 1 ? s : 0] };
    expect([isGap(recording(), 0), isGap(fast, 0), isGap(fast, 2)]).toEqual([false, true, false]);
    expect(posesAt(fast, 0.5, new Float64Array(7))[0]).toBe(0);
  });

  it("points of a body rotate with it", () => {
    const [x, y, z] = pointOf([1, 2, 3, half, 0, 0, half], 0, [1, 0, 0]);
    expect([x, y, z].map((v) => v.toFixed(12))).toEqual([1, 3, 3].map((v) => v.toFixed(12)));
  });
});

describe("the player", () => {
  it("plays at its speed, stops at the end, and restarts from there", () => {
    const player = new Player(() => [1, 3]);
    expect(player.time).toBe(1);
    player.advance(1);
    expect(player.time).toBe(1); // it is not playing
    player.speed = 0.5;
    player.play();
    player.advance(1);
    expect(player.time).toBe(1.5);
    player.advance(100);
    expect([player.time, player.playing]).toEqual([3, false]);
    player.play();
    expect([player.time, player.playing]).toEqual([1, true]);
  });

  it("stays within its range, which may grow", () => {
    let end = 2;
    const times: number[] = [];
    const player = new Player(() => [0, end]);
    player.listen((time) => times.push(time));
    player.seek(5);
    end = 10;
    player.seek(5);
    player.seek(-Infinity);
    expect(times).toEqual([0, 2, 5, 0]);
  });
});

describe("ghosts, trails and outlines", () => {
  it("ghosts are 0.2 s apart, or a round time if these would be too few or too many", () => {
    expect(ghostSpacing(3)).toBe(0.2);
    expect(ghostSpacing(0.4)).toBeCloseTo(0.02, 15);
    expect(ghostSpacing(100)).toBe(5);
    for (const span of [1e-4, 0.01, 0.7, 13, 1e5]) expect(span / ghostSpacing(span)).toBeLessThanOrEqual(60);
  });

  it("ghosts are at frames: two rows do not give thirty", () => {
    const times = (...frames: number[]) => {
      const run: Motion = { ...recording(), frames: frames.length, time: (frame) => frames[frame] };
      return ghostTimes(run, ghostSpacing(frames[frames.length - 1] - frames[0]));
    };
    expect(times(0, 0.001)).toEqual([0, 0.001]);
    expect(times(...Array.from({ length: 101 }, (_none, k) => k * 0.02)).map((time) => time.toFixed(6))).toEqual(
      Array.from({ length: 11 }, (_none, k) => (0.2 * k).toFixed(6)),
    );
    expect(times(0, 0.9, 1, 5)).toEqual([0, 0.9, 1, 5]);
  });

  it("trails go through the frames, and are straight between frames on a line", () => {
    const points = [0, 1, 2, 3].map((k) => [k, 2 * k, -k]);
    expect(between(points, 0)).toEqual([1, 2, -1]);
    expect(between(points, 0.25)).toEqual([1.25, 2.5, -1.25]);
    const bend = [
      [0, 0, 0],
      [1, 0, 0],
      [1, 1, 0],
      [0, 1, 0],
    ];
    expect(between(bend, 1)).toEqual([1, 1, 0]);
  });

  it("leaf bodies are sorted by their distance from the ground", () => {
    const { model } = recording();
    const joint = (child: number, parent: number) => ({ child, parent }) as (typeof model.joints)[number];
    const tree = {
      ...model,
      bodies: [0, 1, 2, 3].map(() => model.bodies[0]),
      joints: [joint(0, -1), joint(1, 0), joint(2, 1), joint(3, 0)],
    };
    expect(leafBodies(tree)).toEqual([2, 3]);
    expect(leafBodies(tree, 1)).toEqual([2]);
  });

  it("mixes colours", () => {
    expect(mixed("#000000", "#ffffff", 0.5)).toBe("#808080");
    expect(mixed("#123456", "#ffffff", 0)).toBe("#123456");
  });

  it("accepts the colours of scenarios, and no others", () => {
    expect([hexOf("#12aB34"), hexOf("gold"), hexOf("steelblue")]).toEqual(["#12ab34", "#ffd700", "#4682b4"]);
    for (const none of ["", "#fff", "#12345g", "url(#x)", "constructor"]) expect(hexOf(none)).toBeNull();
  });

  it("of a dark shape are brighter on a dark ground, and unchanged elsewhere", () => {
    expect(shapeColour("#23272e", themeOf(false))).toBe("#23272e");
    expect(shapeColour("#ffd700", themeOf(true))).toBe("#ffd700");
    const shown = shapeColour("#23272e", themeOf(true));
    expect(parseInt(shown.slice(1, 3), 16)).toBeGreaterThan(0x40);
    expect(parseInt(shown.slice(1, 3), 16)).toBeLessThan(0x80);
  });

  it("outlines have no gaps: a corner moves in one direction, whichever face it belongs to", () => {
    const box = new BoxGeometry(1, 2, 3).translate(5, 0, 0);
    addOutward(box);
    const [position, outward] = [box.getAttribute("position"), box.getAttribute("outward")];
    expect(position.count).toBe(24);
    for (let i = 0; i < position.count; i++) {
      const corner = new Vector3(position.getX(i) - 5, position.getY(i), position.getZ(i));
      for (const [k, axis] of (["x", "y", "z"] as const).entries())
        expect(outward.array[3 * i + k]).toBeCloseTo(Math.sign(corner[axis]) / Math.sqrt(3), 5);
    }
  });
});

describe("the initial view", () => {
  /** Bodies of these masses along x; the last one slides away until the end. */
  function sliding(masses: readonly number[], away: number): Motion {
    const bodies = masses.map((mass, i) => ({ ...recording().model.bodies[0], name: `b${i}`, mass }));
    const at = (frame: number) =>
      masses.flatMap((_mass, i) => [i + (i === masses.length - 1 ? frame * away : 0), 0, 0, 1, 0, 0, 0]);
    const mechanism = masses.map(() => 0);
    return { ...recording(), model: { ...recording().model, bodies }, poses: at, phases: [{ from: 0, mechanism, joints: [] }] };
  }
  const around = new Box3(new Vector3(-0.1, -0.1, -0.1), new Vector3(0.1, 0.1, 0.1));
  const width = (run: Motion) => viewOf(run, () => around).box.getSize(new Vector3()).x;

  it("is around the shapes, not around all that they could reach", () => {
    const long = new Box3(new Vector3(0, -0.1, -0.2), new Vector3(2, 0.1, 0.3)); // moves by 4 m along x, turned by 90° about z
    const { box, lowest } = viewOf(recording(), () => long);
    expect(box.min.toArray()).toEqual([0, -0.1, -0.2].map((each) => expect.closeTo(each, 9) as number));
    expect(box.max.toArray()).toEqual([4.1, 2, 0.3].map((each) => expect.closeTo(each, 9) as number));
    expect(lowest).toBeCloseTo(-0.2, 9);
  });

  it("leaves out a light body that slides far away", () => {
    expect(width(sliding([4, 4, 4, 0.1], 0))).toBeCloseTo(3.2, 9);
    expect(width(sliding([4, 4, 4, 0.1], 1))).toBeCloseTo(5.2, 9);
    expect(width(sliding([4, 4, 4, 0.1], 20))).toBeLessThan(6);
    expect(width(sliding([4, 4, 4, 1], 20))).toBeCloseTo(43.2, 9); // heavier than 2 % of all
  });

  it("shows the whole of a chain, whose links are all light", () => {
    expect(width(sliding(Array<number>(100).fill(0.1), 20))).toBeCloseTo(139.2, 9);
  });
});

it("arrows of round-off have no scale, and those of the same kind keep theirs", () => {
  const arrow = (x: number) => ({ from: new Vector3(), vector: new Vector3(x, 0, 0) });
  const scale = new ArrowScale();
  expect(scale.for([arrow(1e-16)], 2, 1e-9)).toBe(0);
  expect(scale.for([arrow(4)], 2, 1e-9)).toBe(0.5);
  expect(scale.for([arrow(1)], 2, 1e-9)).toBe(0.5);
});
