import { describe, expect, it } from "vitest";
import { FrameRate } from "../panels/frame_rate";
import { Pace } from "./pace";

const slowAfter = (durations: number[]) => {
  const pace = new Pace();
  return durations.findIndex((duration) => pace.isSlow(duration)) + 1;
};
const pictures = (count: number, duration: number) => Array<number>(count).fill(duration);

describe("the pace of pictures", () => {
  it("is slow if the browser takes long for many that follow each other", () => {
    expect(slowAfter(pictures(500, 1 / 60))).toBe(0);
    expect(slowAfter(pictures(500, 1 / 10))).toBe(17);
    expect(slowAfter(pictures(500, 3))).toBe(7);
    expect(slowAfter(pictures(16, 1 / 10))).toBe(0);
  });

  it("is not slow because of a few, as the first or those of a page in the background", () => {
    expect(slowAfter([2, 0.5, ...pictures(500, 1 / 60), 3600, ...pictures(500, 1 / 60)])).toBe(0);
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

  it("has the rate of the last two if pictures take longer than a second, but not of two with a pause between them", () => {
    const counter = new FrameRate();
    for (const at of [0, 3, 5, 9]) counter.add(at - 1.5, at);
    expect(counter.rate).toBeCloseTo(1 / 4, 9);
    expect(counter.duration).toBeCloseTo(1.5, 9);
    counter.add(60, 60.1);
    expect(counter.rate).toBeNaN();
    counter.add(60.1, 60.2);
    expect(counter.rate).toBeCloseTo(10, 9);
  });
});
