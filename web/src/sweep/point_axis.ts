// An axis of the scatter plot: numbers, or categories whose points are spread so that they do not cover each other.
import type { Column } from "./document";
import { ticksOf, type Ticks } from "./ticks";

export interface PointAxis {
  readonly low: number;
  readonly high: number;
  /** By row; NaN if there is no value. */
  readonly at: Float64Array;
  ticks(most: number): Ticks;
}

/** Texts with more values than these cannot be an axis. */
export const mostCategories = 24;

export const canBeAxis = (column: Column) => column.kind !== "text" || column.labels.length <= mostCategories;

/** Low-discrepancy numbers in [-0.5, 0.5). */
const spread = (row: number) => (((row + 1) * 0.6180339887498949) % 1) - 0.5;

export function pointAxis(column: Column): PointAxis {
  if (column.kind !== "number") {
    const labels = column.labels.length > 0 ? column.labels : [""];
    const at = column.values.map((value, row) => value + 0.6 * spread(row));
    return { low: -0.5, high: labels.length - 0.5, at, ticks: () => ({ at: labels.map((_label, i) => i), labels }) };
  }
  let [low, high] = [Infinity, -Infinity];
  for (const value of column.values)
    if (Number.isFinite(value)) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  if (low > high) [low, high] = [0, 1];
  const margin = high > low ? 0.03 * (high - low) : Math.abs(low) || 1;
  [low, high] = [low - margin, high + margin];
  return { low, high, at: column.values, ticks: (most) => ticksOf(low, high, most) };
}
