import { describe, expect, it } from "vitest";
import { pendulum, pendulumSweep } from "../../tests/pendulum_sweep";
import { themeOf } from "../viewer/colours";
import { conditionOf, relations } from "./conditions";
import { csvOf } from "./csv";
import type { SweepDocument } from "./document";
import { Explorer } from "./explorer";
import { firstAxes } from "./plots/first_axes";
import { pointAxis } from "./plots/point_axis";
import { pointColours, scaleColour, steps } from "./plots/point_colours";
import { nearestPoint, nextPoint } from "./plots/point_search";
import { positions } from "./plots/scatter_picture";
import { relativePath, sweepOf } from "./read";
import { binOf, deviationOf, histogramOf, presentValues, quantile, shareInterval } from "./plots/statistics";
import { ticksOf } from "./plots/ticks";
import { percent, replayOf, shortened } from "./words";
import { sortedRows } from "./worlds_table";

const small: SweepDocument = {
  format: 1,
  columns: [
    { name: "x", role: "vary" },
    { name: "hit", kind: "flag" },
    { name: "why, then", kind: "text" },
  ],
  values: { world: [4, 7, 9], x: [2, null, -1], hit: [true, false, null], "why, then": ["b", 'a "c"', null] },
};

describe("the document of a sweep", () => {
  it("may leave out everything but its columns and values", () => {
    const sweep = sweepOf(small);
    expect([sweep.worlds, sweep.done, sweep.failed, sweep.seed]).toEqual([3, 3, 0, null]);
    const [x, hit, why] = sweep.columns;
    expect(Array.from(x.values)).toEqual([2, NaN, -1]);
    expect([x.count, x.missing, x.mean, x.least, x.leastWorld, x.greatestWorld]).toEqual([2, 1, 0.5, -1, 9, 4]);
    expect(x.deviation).toBeCloseTo(Math.sqrt(4.5), 12);
    expect([hit.share, ...Array.from(hit.values)]).toEqual([0.5, 1, 0, NaN]);
    expect([why.labels, ...Array.from(why.values)]).toEqual([['a "c"', "b"], 1, 0, NaN]);
    expect(sweepOf({ format: 1, columns: [], values: {} }).world.length).toBe(0);
  });

  it("says what is wrong with it, and where", () => {
    const message = (change: object) => {
      try {
        sweepOf({ ...small, ...change });
      } catch (error) {
        return (error as Error).message;
      }
      return "nothing";
    };
    expect(message({ format: 2 })).toBe("format is 2, but this page reads format 1");
    expect(message({ format: undefined })).toBe("format is missing, but this page reads format 1");
    expect(message({ columns: {} })).toBe("columns is missing, or not a list");
    expect(message({ values: { ...small.values, x: [1] } })).toBe('values["x"] has 1 entries, but there are 3 worlds');
    expect(message({ values: { ...small.values, x: [1, "2", 3] } })).toBe('values["x"][1] is not a number: "2"');
    expect(message({ values: { ...small.values, world: [1, 2.5, 3] } })).toBe("values.world[1] is not the number of a world");
    expect(message({ columns: [{ name: "x", kind: "odd" }] })).toBe(
      'columns[0]: kind is "odd", and not one of "number", "flag", "text"',
    );
    expect(message({ columns: [{ name: "x" }, { name: "x" }] })).toBe("columns[1] has the same name as another: x");
    expect(message({ columns: [{ name: "x", mean: "1" }] })).toBe('columns[0]: mean is not a number: "1"');
    expect(message({ columns: [{ name: "x", histogram: { from: 2, to: 1, counts: [1] } }] })).toBe(
      "columns[0].histogram does not end after it begins",
    );
    expect(message({ columns: [{ name: "x", histogram: { from: 0, to: 1, counts: [1, -1] } }] })).toBe(
      "columns[0].histogram.counts[1] is not a number of worlds",
    );
    expect(message({ failures: [{ why: "?" }] })).toBe("failures[0].world is not the number of a world");
    expect(message({ worst: [{ measure: "x", end: "most", worlds: [] }] })).toContain("worst[0]: end");
    expect(message({ title: 3 })).toBe("the document: title is not a text: 3");
  });

  it("its statistics are those that the page computes if they are absent", () => {
    const full = pendulumSweep({ worlds: 500 });
    const bare = { ...full, columns: full.columns.map(({ name, role, kind }) => ({ name, role, kind })) } as SweepDocument;
    const [given, computed] = [sweepOf(full).columns, sweepOf(bare).columns];
    given.forEach((column, i) => {
      const other = computed[i];
      expect([other.count, other.missing, other.leastWorld]).toEqual([column.count, column.missing, column.leastWorld]);
      if (column.kind === "number") {
        expect(other.mean).toBeCloseTo(column.mean, 9);
        expect(other.deviation).toBeCloseTo(column.deviation, 9);
        expect(Math.abs(other.quantiles.get(0.25)! - column.quantiles.get(0.25)!)).toBeLessThan(0.05 * column.deviation);
      }
      if (column.kind !== "flag") return;
      expect(other.share).toBeCloseTo(column.share, 12);
      [0, 1].forEach((end) => expect(other.interval![end]).toBeCloseTo(column.interval![end], 6));
    });
  });

  it("links only to files beside the page", () => {
    expect(relativePath("worlds/401/report.html")).toBe("worlds/401/report.html");
    expect(relativePath("worlds/4 1#/report.html")).toBe("worlds/4%201%23/report.html");
    for (const bad of ["", "javascript:alert(1)", "//elsewhere.example/x", "/etc/passwd", "../x", "a/../../x", "C:\\x"])
      expect(relativePath(bad)).toBeNull();
  });
});

describe("statistics", () => {
  it("of the numbers 1 to 5", () => {
    const sorted = presentValues(new Float64Array([3, NaN, 1, 5, 2, 4]));
    expect([0, 0.25, 0.5, 0.9, 1].map((p) => quantile(sorted, p))).toEqual([1, 2, 3, 4.6, 5]);
    expect(deviationOf(sorted)).toBeCloseTo(Math.sqrt(2.5), 12);
    expect(deviationOf(new Float64Array([4]))).toBeNaN();
    expect(histogramOf(sorted)).toEqual({ from: 1, to: 5, counts: [1, 1, 1, 1, 1] });
    expect(histogramOf(new Float64Array([7, 7]))).toEqual({ from: 7, to: 7, counts: [2] });
  });

  it("a bin includes its lower limit, the last one both", () => {
    const histogram = { from: 0, to: 4, counts: [0, 0, 0, 0] };
    expect([0, 0.9, 1, 3.9, 4, NaN].map((value) => binOf(histogram, value))).toEqual([0, 0, 1, 3, 3, -1]);
  });

  it("Wilson's interval: textbook values for 8 of 10, and never beyond 0 and 1", () => {
    const [low, high] = shareInterval(8, 10)!;
    expect([low, high].map((value) => value.toFixed(4))).toEqual(["0.4902", "0.9433"]);
    expect(shareInterval(0, 5)![0]).toBe(0);
    expect(shareInterval(5, 5)![1]).toBe(1);
    expect(shareInterval(0, 0)).toBeNull();
  });
});

describe("the sample", () => {
  it("the rod's force of a pendulum from 90° is three times its weight, and its period that of small swings", () => {
    expect(pendulum(100, Math.PI / 2, 1).load).toBeCloseTo(3 * 9.81, 9);
    const small = 0.01;
    const nearlyGreatest = 9.81 * (3 - 2 * Math.cos(small)) * (1 - 1e-12);
    expect(pendulum(nearlyGreatest, small, 1).when).toBeCloseTo((Math.PI / 2) * Math.sqrt(1 / 9.81), 4);
  });

  it("first shows the strongest dependence, with the flag as colours", () => {
    const { x, y, colour } = firstAxes(sweepOf(pendulumSweep()));
    expect([x?.name, y?.name, colour?.name]).toEqual(["event.snap.when.exceeds", "when", "broke"]);
  });
});

describe("axes and colours", () => {
  it("ticks are round and have the decimals that they need", () => {
    expect(ticksOf(0.05, 0.55, 5).labels).toEqual(["0.1", "0.2", "0.3", "0.4", "0.5"]);
    expect(ticksOf(-1.2, 2.1, 4).labels).toEqual(["−1", "0", "1", "2"]);
    expect(ticksOf(1000.001, 1000.004, 3).labels).toEqual(["1000.001", "1000.002", "1000.003", "1000.004"]);
    expect(ticksOf(0, 3e9, 3).labels).toEqual(["0", "1e9", "2e9", "3e9"]);
    expect(ticksOf(0, 2.5e9, 5).labels).toEqual(["0", "5e8", "1.0e9", "1.5e9", "2.0e9", "2.5e9"]);
    expect(ticksOf(2.5, 2.5, 4).labels).toEqual(["2.5"]);
    expect(ticksOf(0, 2e-7, 2).labels).toEqual(["0", "1e−7", "2e−7"]);
  });

  it("spread flags over their category, and give a constant column room", () => {
    const [, hit] = sweepOf(small).columns;
    const axis = pointAxis(hit);
    expect([axis.low, axis.high, ...axis.ticks(5).labels]).toEqual([-0.5, 1.5, "no", "yes"]);
    expect(Math.abs(axis.at[0] - 1)).toBeLessThanOrEqual(0.3);
    expect(axis.at[2]).toBeNaN();
    const constant = pointAxis({ ...hit, kind: "number", values: new Float64Array([5, 5]) });
    expect([constant.low, constant.high]).toEqual([0, 10]);
  });

  it("logarithmic axes have powers of ten, or round numbers if there are few", () => {
    const [x] = sweepOf(small).columns;
    const axis = pointAxis({ ...x, values: new Float64Array([1e-3, 10, -1]) }, { log: true });
    expect(Array.from(axis.at)).toEqual([-3, 1, NaN]);
    expect(axis.ticks(8)).toEqual({ at: [-3, -2, -1, 0, 1], labels: ["0.001", "0.01", "0.1", "1", "10"] });
    expect(axis.ticks(3).labels).toEqual(["0.001", "0.1", "10"]);
    const few = pointAxis({ ...x, values: new Float64Array([2, 9]) }, { log: true }).ticks(4);
    expect(few.labels).toEqual(["2", "4", "6", "8"]);
    expect(few.at[1]).toBeCloseTo(Math.log10(4), 12);
  });

  it("limits are those of the shown rows, and points beyond them are not drawn", () => {
    const [x] = sweepOf(small).columns;
    const values = new Float64Array([0, 10, 1e9]);
    const axis = pointAxis({ ...x, values }, { shown: Uint8Array.from([1, 1, 0]) });
    expect([axis.low, axis.high]).toEqual([-0.3, 10.3]);
    const at = positions(axis, axis, { left: 0, top: 0, width: 106, height: 106 });
    expect(Array.from(at.x, Math.round)).toEqual([3, 103, NaN]);
    expect(Array.from(at.y, Math.round)).toEqual([103, 3, NaN]);
  });

  it("points are found by their positions", () => {
    const at = { x: Float32Array.from([0, 10, NaN, 20]), y: Float32Array.from([0, 5, 5, 1]) };
    expect([nearestPoint(at, 11, 5, 3), nearestPoint(at, 15, 5, 3)]).toEqual([1, -1]);
    expect([nextPoint(at, 1, 1, false), nextPoint(at, 1, -1, false), nextPoint(at, 3, 1, false)]).toEqual([3, 0, 3]);
    expect([nextPoint(at, 1, 1, true), nextPoint(at, 2, 1, false), nextPoint(at, -1, -1, false)]).toEqual([3, 0, 3]);
    expect(nextPoint({ x: new Float32Array([NaN]), y: new Float32Array([1]) }, 0, 1, false)).toBe(-1);
  });

  it("points stand out from the ground (WCAG: 3 to 1), the more the greater the number", () => {
    const luminance = (colour: string) =>
      [1, 3, 5]
        .map((at) => parseInt(colour.slice(at, at + 2), 16) / 255)
        .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
        .reduce((sum, c, i) => sum + [0.2126, 0.7152, 0.0722][i] * c, 0);
    const contrast = (a: string, b: string) => {
      const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
      return (high + 0.05) / (low + 0.05);
    };
    for (const [dark, panel] of [
      [false, "#ffffff"],
      [true, "#1a2028"],
    ] as const) {
      const all = Array.from({ length: steps }, (_none, i) => contrast(scaleColour(themeOf(dark), i / (steps - 1)), panel));
      expect(Math.min(...all)).toBeGreaterThan(3);
      expect(all.every((each, i) => i === 0 || each > all[i - 1])).toBe(true);
      const { palette } = pointColours(themeOf(dark), sweepOf(small).columns[1], 3);
      for (const colour of palette) expect(contrast(colour, panel)).toBeGreaterThan(3);
    }
  });

  it("missing values have a colour of their own", () => {
    const [x] = sweepOf(small).columns;
    expect(Array.from(pointColours(themeOf(false), x, 3).of)).toEqual([steps - 1, steps, 0]);
  });
});

describe("worlds", () => {
  const sweep = sweepOf(small);
  const rows = Int32Array.from([0, 1, 2]);

  it("are sorted by a column, missing values last in both directions", () => {
    expect(Array.from(sortedRows(rows, sweep.columns[0].values, false))).toEqual([2, 0, 1]);
    expect(Array.from(sortedRows(rows, sweep.columns[0].values, true))).toEqual([0, 2, 1]);
  });

  it("are filtered by conditions", () => {
    const holds = (column: number, name: string, given = "") => {
      const relation = relations[sweep.columns[column].kind].find((each) => each.name === name)!;
      return Array.from(rows).filter(conditionOf(sweep.columns[column], relation, given)!.holds);
    };
    expect(holds(0, "≥", "−1")).toEqual([0, 2]);
    expect(holds(0, "≤", "0")).toEqual([2]);
    expect(holds(0, "has no value")).toEqual([1]);
    expect(holds(1, "is yes")).toEqual([0]);
    expect(holds(1, "has a value")).toEqual([0, 1]);
    expect(holds(2, "contains", "A")).toEqual([1]);
    expect(conditionOf(sweep.columns[0], relations.number[0], "two")).toBeNull();
  });

  it("as comma-separated values", () => {
    expect(csvOf(sweep, [2, 0, 1])).toBe('world,x,hit,"why, then"\n9,-1,,\n4,2,true,b\n7,,false,"a ""c"""\n');
  });

  it("can be marked and picked", () => {
    const explorer = new Explorer(sweep);
    const changes: string[] = [];
    explorer.listen((change) => changes.push(change));
    explorer.mark("x", (row) => row > 0);
    explorer.pick(9);
    expect([explorer.markedCount, explorer.rowOf(9), explorer.rowOf(1)]).toEqual([2, 2, -1]);
    explorer.clearMarks();
    explorer.clearMarks();
    expect(changes).toEqual(["marked", "picked", "marked"]);
  });
});

describe("words", () => {
  it("shares have the digits that distinguish them from none and all", () => {
    expect([0, 1, 0.5, 0.86123, 0.0001, 0.99999, NaN].map(percent)).toEqual([
      "0 %",
      "100 %",
      "50.0 %",
      "86.1 %",
      "0.01 %",
      "99.999 %",
      "–",
    ]);
  });

  it("long names keep the parts that tell them apart", () => {
    expect(
      shortened([
        "mechanism.pendulum.state.joints.hinge.q",
        "mechanism.pendulum.state.joints.bob.q",
        "load",
        "mechanism.left.links.number.7.damping",
        "mechanism.right.links.number.7.damping",
      ]),
    ).toEqual([
      "…state.joints.hinge.q",
      "…state.joints.bob.q",
      "load",
      "mechanism.left.links.number.7.damping",
      "mechanism.right.links.number.7.damping",
    ]);
  });

  it("commands are quoted for the shell", () => {
    expect(replayOf("p.toml", 3)).toBe("momentree sweep p.toml --world 3");
    expect(replayOf("it's $x.toml", 3)).toBe("momentree sweep 'it'\\''s $x.toml' --world 3");
    expect(replayOf("", 3)).toBe("");
  });
});
