// Reads a column of a sweep; statistics that the document leaves out are computed from its values.
import type { Column, Histogram, Kind } from "./document";
import { fail, list, numberOr, oneOf, record, textOr, type Json } from "./json";
import { deviationOf, histogramOf, meanOf, presentValues, quantile, shareInterval } from "./plots/statistics";

const standardQuantiles = [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99];

interface Cells {
  readonly values: Float64Array;
  readonly labels: readonly string[];
}

function cellsOf(cells: readonly unknown[], kind: Kind, where: string): Cells {
  const wrong = (row: number): never => fail(`${where}[${row}]`, `is not a ${kind}: ${JSON.stringify(cells[row])}`);
  const values = new Float64Array(cells.length).fill(NaN);
  const type = { number: "number", flag: "boolean", text: "string" }[kind];
  cells.forEach((cell, row) => cell === null || typeof cell === type || wrong(row));
  if (kind !== "text") {
    cells.forEach((cell, row) => cell !== null && (values[row] = Number(cell)));
    return { values, labels: kind === "flag" ? ["no", "yes"] : [] };
  }
  const labels = [...new Set(cells.filter((cell) => cell !== null) as string[])].sort();
  const indices = new Map(labels.map((label, i) => [label, i]));
  cells.forEach((cell, row) => cell !== null && (values[row] = indices.get(cell as string)!));
  return { values, labels };
}

function histogramIn(value: unknown, where: string): Histogram {
  const histogram = record(value, where);
  const counts = list(histogram.counts, `${where}.counts`);
  const wrong = counts.findIndex((count) => typeof count !== "number" || !(count >= 0));
  if (wrong >= 0) fail(`${where}.counts[${wrong}]`, "is not a number of worlds");
  const [from, to] = [numberOr(histogram, "from", where, NaN), numberOr(histogram, "to", where, NaN)];
  if (!(to >= from)) fail(where, "does not end after it begins");
  return { from, to, counts: counts as number[] };
}

function quantilesOf(value: unknown, where: string): Map<number, number> {
  const given = record(value, where);
  const known = Object.keys(given)
    .map((key) => [Number(key), numberOr(given, key, where, NaN)] as const)
    .filter(([probability, at]) => probability >= 0 && probability <= 1 && Number.isFinite(at));
  return new Map(known.sort((a, b) => a[0] - b[0]));
}

/** `cells`: its values, for each of `world`. */
export function readColumn(column: Json, where: string, cells: readonly unknown[], world: Float64Array): Column {
  const name = textOr(column, "name", where, "");
  const kind = oneOf(column, "kind", where, ["number", "flag", "text"] as const, "number");
  const { values, labels } = cellsOf(cells, kind, `values["${name}"]`);
  const present = presentValues(values);
  const some = present.length > 0 && kind !== "text";
  const count = numberOr(column, "count", where, present.length);
  const worldAt = (value: number) => (some ? world[values.indexOf(value)] : NaN);
  const [least, greatest] = [present[0], present[present.length - 1]];
  const number = (key: string, computed: () => number) => numberOr(column, key, where, some ? computed() : NaN);
  const named = (key: string, computed: number) => {
    const known = numberOr(column, key, where, computed);
    return Number.isNaN(known) ? null : known;
  };
  const share = number("share", () => meanOf(present));
  return {
    name,
    role: oneOf(column, "role", where, ["vary", "measure"] as const, "measure"),
    kind,
    about: textOr(column, "about", where, ""),
    unit: textOr(column, "unit", where, ""),
    values,
    labels,
    count,
    missing: numberOr(column, "missing", where, values.length - present.length),
    mean: number("mean", () => meanOf(present)),
    deviation: number("deviation", () => deviationOf(present)),
    least: number("least", () => least),
    greatest: number("greatest", () => greatest),
    leastWorld: named("least_world", worldAt(least)),
    greatestWorld: named("greatest_world", worldAt(greatest)),
    quantiles: column.quantiles
      ? quantilesOf(column.quantiles, `${where}.quantiles`)
      : new Map(some ? standardQuantiles.map((p) => [p, quantile(present, p)]) : []),
    histogram:
      kind !== "number" ? null : column.histogram ? histogramIn(column.histogram, `${where}.histogram`) : histogramOf(present),
    share: kind === "flag" ? share : NaN,
    interval: kind === "flag" ? intervalOf(column, where, share, count) : null,
  };
}

function intervalOf(column: Json, where: string, share: number, count: number): readonly [number, number] | null {
  if (!column.interval) return Number.isNaN(share) ? null : shareInterval(share * count, count);
  const [from, to] = list(column.interval, `${where}.interval`);
  if (typeof from !== "number" || typeof to !== "number") return null;
  return [from, to];
}
