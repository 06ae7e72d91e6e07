import { describe, expect, it } from "vitest";
import { groupsOf, groupText, impulseOf, marksAt, textOf } from "./contacts";
import type { RunEvent, Vec3 } from "./recording";
import { certificate } from "./panels/events";
import { marked } from "./panels/timeline";

const event = (time: number, name: string, rest: Partial<RunEvent> = {}): RunEvent => ({
  time,
  event: name,
  actions: [],
  changes: [],
  mechanisms: { before: ["ball"], after: ["ball"] },
  before: null,
  after: null,
  released: 0,
  lost: 0,
  work: 0,
  hardest: null,
  duration_ns: 0,
  ...rest,
});
const contact = (time: number, name: string, strength = 0, bodies = ["ball", "ground"]) =>
  event(time, name, { bodies, point: [0, 0, 0], normal: [0, 0, 1], impulse: [0, 0, strength] as Vec3 });

/** A ball that bounces with restitution 0.8: impacts in a geometric series. */
function bounces(): RunEvent[] {
  const events: RunEvent[] = [];
  let [time, speed] = [0.4515, 4.429];
  for (let k = 0; k < 69; k++) {
    events.push(contact(time, "impact", 1.8 * speed));
    speed *= 0.8;
    time += (2 * speed) / 9.81;
  }
  return [...events, contact(time, "rest")];
}

describe("the list of contacts", () => {
  it("has one line for the end of a series of bounces, and one for each of the first", () => {
    const events = bounces();
    const groups = groupsOf(events, 0.05);
    expect(groups.length).toBeLessThan(20);
    expect(groups[0]).toEqual({ first: 0, end: 1, main: 0 });
    expect(groups[groups.length - 1].end).toBe(70);
    expect(groupText(events, groups[groups.length - 1])).toMatch(/^\d+ × impact, rest: ball and the ground$/);
    expect(groups.reduce((sum, { first, end }) => sum + end - first, 0)).toBe(70);
  });

  it("keeps events of other kinds apart, and names the hardest impact of a group", () => {
    const events = [
      contact(1, "impact", 1),
      contact(1.001, "impact", 5, ["ball", "box"]),
      event(1.002, "snap", { actions: ["break a"] }),
      contact(1.003, "slip"),
    ];
    const groups = groupsOf(events, 0.1);
    expect(groups.map(({ first, end, main }) => [first, end, main])).toEqual([
      [0, 2, 1],
      [2, 3, 2],
      [3, 4, 3],
    ]);
    expect(groupText(events, groups[0])).toBe("2 × impact: 2 pairs of bodies");
    expect(groupText(events, groups[1])).toBe("break a");
    expect(textOf(events[3])).toBe("slip: ball and the ground");
    expect(textOf({ ...events[3], event: "stick", reason: "why" })).toBe("stick: ball and the ground, why");
  });

  it("holds a hundred thousand events", () => {
    const events = Array.from({ length: 100_000 }, (_, i) => contact(1 + 1e-9 * i, "impact", i));
    expect(groupsOf(events, 0.01)).toHaveLength(1);
    expect(marked(events, 0, 2)).toEqual([99_999]);
    expect(marksAt(events, 2, 10, 0)).toHaveLength(64);
  });
});

describe("marks of contacts", () => {
  it("leave their place on the time line to other events, and to harder impacts", () => {
    const events = [contact(1, "impact", 1), event(1.001, "snap"), contact(3, "impact", 2), contact(3.001, "impact", 9)];
    expect(marked(events, 0, 10)).toEqual([1, 3]);
  });

  it("are those of the last moment, and grow older until they are gone", () => {
    const events = bounces();
    const [mark] = marksAt(events, 0.4515 + 0.15, 0.3, 0);
    expect(mark.age).toBeCloseTo(0.5, 9);
    expect(mark.impulse).toBe(impulseOf(events[0]));
    expect(marksAt(events, 0.4, 0.3, 0)).toEqual([]);
    expect(marksAt(events, 0.8, 0.3, 0)).toEqual([]);
    expect(marksAt(events, 4.1, 0.3, 1e-3).every(({ impulse }) => impulse >= 1e-3)).toBe(true);
  });
});

it("the certificate of an impact has its bodies, its point, its impulse and the reduction of its restitution", () => {
  const impact = event(1, "impact", {
    bodies: ["box/box", "ground"],
    point: [0.25, -1, 0],
    normal: [0, 0, 1],
    impulse: [3, 0, 4],
    scaled: 0.5,
  });
  expect(certificate(impact).notes).toEqual([
    "box/box and the ground at (0.25, −1, 0) m",
    "Impulse: 5 N s",
    "Expansion reduced to 0.5 of its restitution: no energy gained",
  ]);
});
