import { describe, expect, it } from "vitest";
import type { RunEvent, Summary } from "../recording";
import { certificate } from "./events";
import { count, digits, duration, instant } from "./numbers";
import { significantColumns } from "./plot";
import { balanceOf } from "./plots";
import { momentumScale, rangeOf, withoutNoise } from "./scales";
import { apart, withoutMiddle } from "./strays";
import { energyTable, missedRow, timesTable } from "./summary";
import { marked } from "./timeline";

describe("numbers as text", () => {
  it("has a few digits and no needless zeros", () => {
    expect([0, 1, -1.5, 1234.56, 123456, 0.00012345, Number.NaN].map((x) => digits(x))).toEqual([
      "0",
      "1",
      "−1.5",
      "1235",
      "1.23e5",
      "1.23e−4",
      "–",
    ]);
    expect(digits(8.539184, 6)).toBe("8.53918");
    expect(digits(100)).toBe("100");
    expect([3000, -1234.5, 99999, 999.7].map((x) => digits(x, 3))).toEqual(["3000", "−1235", "99999", "1000"]);
  });

  it("durations have units that fit", () => {
    expect([0, 2.5, 0.0412, 1.8e-6, 9e-9].map(duration)).toEqual(["0 s", "2.5 s", "41.2 ms", "1.8 µs", "9 ns"]);
  });

  it("instants have the decimals that the run's length needs", () => {
    expect(instant(1.8, 3)).toBe("1.800 s");
    expect(instant(-0.25, 300)).toBe("−0.25 s");
    expect(instant(0.00125, 0.002)).toBe("0.001250 s");
  });

  it("counts", () => {
    expect([count(1, "body", "bodies"), count(0, "body", "bodies")]).toEqual(["1 body", "0 bodies"]);
  });
});

describe("plots", () => {
  const column = (label: string, ...values: number[]) => ({ label, unit: "J", values });

  it("the balance adds present and lost energy, and subtracts work", () => {
    const all = balanceOf([
      column("kinetic", 1, 4),
      column("gravity", 9, 8),
      column("dissipated", 0, 1),
      column("work", 0, 3),
    ])!;
    expect(Array.from(all.values)).toEqual([10, 10]);
    expect(all.label).toBe("all, less work");
    expect(balanceOf([column("kinetic", 1), column("work", 0)])!.label).toBe("all");
    expect(balanceOf([])).toBeNull();
  });

  it("leaves out columns that are negligible beside the rest, but never all of them", () => {
    const shown = significantColumns([column("a", 1, Number.NaN), column("b", 1e-12, 0), column("c", -0.5)]);
    expect(shown.map(({ label }) => label)).toEqual(["a", "c"]);
    expect(significantColumns([column("a", 0), column("b", 0)]).map(({ label }) => label)).toEqual(["a"]);
  });
});

describe("the axis of values", () => {
  it("contains all values, and skips gaps", () => {
    expect(rangeOf([[1, Number.NaN, 3], [-2]], 5)).toEqual({ low: -2, high: 3, flat: null });
    expect(rangeOf([[1e-9, 2e-9]], 1)).toEqual({ low: 1e-9, high: 2e-9, flat: null }); // small, but not noise
    expect(rangeOf([[Number.NaN]], 1)).toEqual({ low: -1, high: 1, flat: null });
  });

  it("does not magnify round-off: zero is a line in the middle, a constant one above it", () => {
    const noise = [1e-14, -3e-15, 2e-14];
    expect(rangeOf([noise, [0, 0, 0]], 20)).toEqual({ low: -20, high: 20, flat: "zero" });
    expect(rangeOf([noise.map((x) => 5 + x)], 0)).toMatchObject({ low: 0, flat: "constant" });
    expect(rangeOf([noise.map((x) => x - 5)], 0)).toMatchObject({ high: 0, flat: "constant" });
    expect(rangeOf([noise], 0).flat).toBeNull(); // nothing shows that it is noise
    expect(rangeOf([[0, 0]], 0)).toEqual({ low: -1, high: 1, flat: "zero" });
    const range = rangeOf([[1000, -20], noise], 3);
    expect([1000, -20, 1e-6, noise[1], -2e-30].map((x) => withoutNoise(x, 3, range))).toEqual([1000, -20, 1e-6, 0, 0]);
    expect(withoutNoise(2e-30, 0, rangeOf([[1e-30, 2e-30]], 0))).toBe(2e-30); // nothing shows that it is noise
    expect(rangeOf([[5, 5 + 4e-7]], 5, 2.4e-7).flat).toBe("constant"); // in single precision
    expect(rangeOf([[5, 5 + 4e-7]], 5).flat).toBeNull();
  });

  it("the scale of momenta follows from mass and energy", () => {
    expect(momentumScale(2, 9)).toBe(6);
    expect(momentumScale(2, -1e-20)).toBe(0);
  });
});

describe("the timeline", () => {
  it("marks events that can be distinguished", () => {
    const events = [0, 1, 1.001, 1.5, 2].map((time) => ({ time }) as RunEvent);
    expect(marked(events, 0, 2)).toEqual([0, 1, 3, 4]);
    expect(marked([{ time: 0 } as RunEvent], 0, 0)).toEqual([0]);
    expect(marked([{ time: 1 }, { time: 5 }] as RunEvent[], 4, 6)).toEqual([1]); // not before the start of the line
  });
});

describe("certificates", () => {
  const totals = (kinetic: number, x: number) => ({
    kinetic,
    potential: 1,
    linear: [x, 0, 0] as const,
    angular: [0, 3, 4] as const,
  });
  const event: RunEvent = {
    time: 1,
    event: "grasp",
    actions: [],
    changes: [],
    mechanisms: { before: [], after: [] },
    before: totals(4, 2),
    after: totals(3, 2),
    released: 0,
    lost: 1,
    work: 0,
    hardest: { joint: "grasp", linear: 8, angular: 0.5 },
    duration_ns: 1500,
  };

  it("report what was conserved and what was not", () => {
    const { rows, notes } = certificate(event);
    expect(rows).toEqual([
      ["energy (J)", "5", "4", "−1", "0.2"],
      ["linear momentum (N\u00a0s)", "2", "2", "0", "0"],
      ["angular momentum (N\u00a0m\u00a0s)", "5", "5", "0", "0"],
    ]);
    expect(notes).toEqual(["Lost in the impact: 1 J", "Largest impulse: 8 N s, 0.5 N m s, through grasp"]);
  });

  it("omit energies and impulses that are round-off", () => {
    expect(certificate({ ...event, lost: 1e-16, released: -2e-17, hardest: null }).notes).toEqual([]);
    const hardest = { joint: "pin", linear: 1e-15, angular: 2e-15 };
    expect(certificate({ ...event, lost: 0, hardest }).notes).toEqual([]);
  });

  it("show the equations of closed loops", () => {
    const loops = { rows: 6, rank: 3, residual: 2.5e-13 };
    expect(certificate({ ...event, after: { ...totals(3, 2), loops } }).rows.slice(3)).toEqual([
      ["equations of loops", "–", "6", "", ""],
      ["independent of them", "–", "3", "", ""],
      ["residual of loops", "–", "2.5e−13", "", ""],
    ]);
  });

  it("have no rows if nothing was recorded", () => {
    expect(certificate({ ...event, before: null }).rows).toEqual([]);
  });
});

describe("the summary", () => {
  const summary: Summary = {
    status: "done",
    method: "rk4",
    step: 1e-3,
    steps: 10,
    evaluations: 40,
    topology_changes: 1,
    real_time_factor: 2,
    wall_clock: { evaluations: { before: 1, after: 2 }, topology: { before: 0, after: 0.5 }, total: { before: 2, after: 4 } },
    energy: { initial: 8, released: 0, error: 0 },
  };

  it("has the rows of Table 2: whole run, before the change, the change, after it", () => {
    expect(timesTable(summary)).toEqual([
      ["Whole simulation", "3 s", "6 s"],
      ["Before the first change", "1 s", "2 s"],
      ["Topology change", "500 ms", "500 ms"],
      ["After it", "2 s", "3.5 s"],
    ]);
    expect(timesTable({ ...summary, topology_changes: 0 })).toHaveLength(1);
    expect(timesTable({ status: "running, or killed" })).toEqual([]);
  });

  it("lists the condition of events that did not happen, and how near it came", () => {
    const grasp = { event: "grasp", quantity: "distance", of: ["arm/hand", "cup"], below: 0.3 };
    expect(missedRow({ ...grasp, nearest: 0.353, nearest_time: 12.7 })).toEqual([
      "grasp",
      "distance of arm/hand and cup below 0.3",
      "nearest: 0.353 at 12.7 s",
    ]);
    expect(missedRow({ event: "a", quantity: "speed", exceeds: 2, nearest: 3, nearest_time: 1, for: 0.5, held: 0.25 })[2]).toBe(
      "nearest: 3 at 1 s, held for 250 ms of 500 ms",
    );
    expect(missedRow({ event: "b", quantity: "position", exceeds: 2, nearest: null })[2]).toBe("there was nothing to measure");
    expect(missedRow({ event: "c", after: "grasp" })).toEqual(["c", "after grasp", "that did not happen"]);
    expect(missedRow({ event: "d", time: 40 })).toEqual(["d", "at 40 s", "the run ended before"]);
  });

  it("leaves out energies that are zero to round-off, but not the error", () => {
    const energy = { ...summary.energy, dissipated: -7e-30 };
    expect(energyTable({ ...summary, energy })).toEqual([
      ["at the start", "8 J"],
      ["error of the balance", "0 J"],
    ]);
    expect(energyTable({ ...summary, energy: { initial: 8, projection: 2e-9, error: 0 } })[1]).toEqual([
      "by closing loops and removing overlaps",
      "2e−9 J",
    ]);
  });
});

describe("names of what is outside the picture", () => {
  it("lose their middle, if anything", () => {
    expect(withoutMiddle("arm/load")).toBe("arm/load");
    expect(withoutMiddle("humanoid/left_forearm/41")).toBe("humano…_forearm/41");
    expect(withoutMiddle("humanoid/left_forearm/41")).toHaveLength(18);
  });

  it("do not cover each other", () => {
    const label = (left: number, top: number) => ({ left, top, width: 100, height: 30 });
    const placed = apart(
      [label(200, 60), label(200, 60), label(230, 65), label(200, 340), label(200, 340), label(20, 60)],
      400,
    );
    placed.forEach((a, i) =>
      placed.slice(0, i).forEach((b) => expect(Math.abs(a.left - b.left) >= 100 || Math.abs(a.top - b.top) >= 30).toBe(true)),
    );
    expect(placed.map(({ top }) => top)).toEqual([60, 94, 128, 340, 306, 60]);
  });
});
