import { describe, expect, it } from "vitest";
import { FrameRate } from "../panels/frame_rate";
import { Pace } from "./pace";

const run = (pace: Pace, interval: number, count: number) => {
  let slow = false;
  for (let i = 0; i < count; i++) slow = pace.isSlow(i * interval) || slow;
  return slow;
};

describe("the pace of pictures", () => {
  it("is slow only if many that follow each other are slow", () => {
    expect(run(new Pace(), 1 / 60, 500)).toBe(false);
    expect(run(new Pace(), 1 / 10, 500)).toBe(true);
    expect(run(new Pace(), 1 / 10, 20)).toBe(false);
    expect(run(new Pace(), 1, 500)).toBe(false); // single pictures, as when the reader moves the slider
  });
});

describe("the counter of pictures", () => {
  it("has the rate and the mean duration over the last second", () => {
    const counter = new FrameRate();
    expect(counter.rate).toBeNaN();
    for (let i = 0; i < 30; i++) counter.add(i / 30, i / 30 + 0.02);
    for (let i = 0; i <= 120; i++) counter.add(1 + i / 60, 1 + i / 60 + 0.004);
    expect(counter.rate).toBeCloseTo(60, 9);
    expect(counter.duration).toBeCloseTo(0.004, 9);
  });
});
