import { describe, expect, it } from "vitest";
import { messageFrom } from "./remote";

const base64 = (numbers: Float32Array) => Buffer.from(numbers.buffer).toString("base64");

describe("a message of a program", () => {
  const frame = {
    time: 1.5,
    poses: base64(Float32Array.of(1, 2, 3, 1, 0, 0, 0)),
    loads: base64(Float32Array.of(NaN, 4, 1, 0, 0, 4)),
    totals: [1.5, 2, -3, 1, 0, 0, 0, 1, 0, 0.5, -1, 0.25, 0, 0, 0, 1e-9, null],
  };

  it("of a frame has its numbers", () => {
    const message = messageFrom(JSON.stringify({ type: "frame", seconds: 0, frame }));
    if (message.type !== "frame") throw new Error(message.type);
    expect([...message.frame.poses]).toEqual([1, 2, 3, 1, 0, 0, 0]);
    expect([...message.frame.loads]).toEqual([NaN, 4, 1, 0, 0, 4]);
    expect(message.frame.totals.potential).toBe(-3);
    expect(message.frame.totals.angular).toEqual([0, 1, 0]);
    expect(message.frame.totals.balance.dissipated).toBe(0.25);
    expect(message.frame.totals.balance.projection).toBeNaN();
  });

  it("of a world has its first frame", () => {
    const message = messageFrom(JSON.stringify({ type: "loaded", diagnostics: [], world: { frame } }));
    if (message.type !== "loaded") throw new Error(message.type);
    expect(message.world?.frame.poses.length).toBe(7);
  });

  it("of another kind is as it was sent", () => {
    expect(messageFrom('{"type": "playing", "on": true}')).toEqual({ type: "playing", on: true });
  });
});
