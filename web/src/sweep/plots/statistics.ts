// Statistics of columns, for documents without them. Missing values are NaN, and are left out.
import type { Histogram } from "../document";

/** In ascending order. */
export function presentValues(values: Float64Array): Float64Array {
  return values.filter((value) => Number.isFinite(value)).sort();
}

/** Of sorted values, interpolated between neighbours; NaN if there are none. */
export function quantile(sorted: Float64Array, probability: number): number {
  if (sorted.length === 0) return NaN;
  const at = probability * (sorted.length - 1);
  const below = Math.floor(at);
  const above = Math.min(below + 1, sorted.length - 1);
  return sorted[below] + (at - below) * (sorted[above] - sorted[below]);
}

export function meanOf(values: Float64Array): number {
  let sum = 0;
  for (const value of values) sum += value;
  return sum / values.length;
}

/** The sample's standard deviation; NaN for a single value. */
export function deviationOf(values: Float64Array): number {
  const mean = meanOf(values);
  let sum = 0;
  for (const value of values) sum += (value - mean) ** 2;
  return Math.sqrt(sum / (values.length - 1));
}

/** Null without values. */
export function histogramOf(sorted: Float64Array): Histogram | null {
  if (sorted.length === 0) return null;
  const [from, to] = [sorted[0], sorted[sorted.length - 1]];
  const bins = to > from ? Math.min(Math.max(Math.ceil(Math.sqrt(sorted.length)), 5), 40) : 1;
  const counts = new Array<number>(bins).fill(0);
  for (const value of sorted) counts[binOf({ from, to, counts }, value)]++;
  return { from, to, counts };
}

/** The bin of a value; values outside are in the first or the last bin, NaN in none: -1. */
export function binOf({ from, to, counts }: Histogram, value: number): number {
  if (!Number.isFinite(value)) return -1;
  if (!(to > from)) return 0;
  return Math.min(Math.max(Math.floor(((value - from) / (to - from)) * counts.length), 0), counts.length - 1);
}

/** Wilson's interval for a share, with 95 % confidence. */
export function shareInterval(hits: number, count: number): [number, number] | null {
  if (count === 0) return null;
  const z = 1.959963984540054;
  const share = hits / count;
  const middle = share + (z * z) / (2 * count);
  const half = z * Math.sqrt((share * (1 - share)) / count + (z * z) / (4 * count * count));
  const scale = 1 + (z * z) / count;
  return [Math.max((middle - half) / scale, 0), Math.min((middle + half) / scale, 1)];
}
