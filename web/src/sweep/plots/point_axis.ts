// An axis of the scatter plot: numbers, or categories whose points are spread so that they do not cover each other.
import { digits } from "../../panels/numbers";
import type { Column } from "../document";
import { ticksOf, type Ticks } from "./ticks";

export interface PointAxis {
  readonly low: number;
  readonly high: number;
  /** By row; NaN if there is no value. */
  readonly at: Float64Array;
  ticks(most: number): Ticks;
}

export interface AxisOptions {
  readonly log?: boolean;
  /** By row, whether its value must be within the limits; all if null. */
  readonly shown?: Uint8Array | null;
}

/** Texts with more values than these cannot be an axis. */
export const mostCategories = 24;

export const canBeAxis = (column: Column) => column.kind !== "text" || column.labels.length <= mostCategories;

export const canBeLog = (column: Column) => column.kind === "number" && column.least > 0;

/** Low-discrepancy numbers in [-0.5, 0.5). */
const spread = (row: number) => (((row + 1) * 0.6180339887498949) % 1) - 0.5;

/** With a margin of 3 %. */
function limits(at: Float64Array, shown: Uint8Array | null): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  at.forEach((value, row) => {
    if (!Number.isFinite(value) || (shown && !shown[row])) return;
    low = Math.min(low, value);
    high = Math.max(high, value);
  });
  if (low > high) return [0, 1];
  const margin = high > low ? 0.03 * (high - low) : Math.abs(low) || 1;
  return [low - margin, high + margin];
}

/** Powers of ten; round numbers if the axis has hardly any. */
function logTicks(low: number, high: number, most: number): Ticks {
  const powers = Math.floor(high) - Math.ceil(low) + 1;
  if (powers < 3) {
    const { at, labels } = ticksOf(10 ** low, 10 ** high, most);
    return { at: at.map(Math.log10), labels };
  }
  const step = Math.max(Math.ceil(powers / Math.max(most, 1)), 1);
  const at = Array.from({ length: Math.ceil(powers / step) }, (_none, i) => Math.ceil(low) + i * step);
  return { at, labels: at.map((power) => digits(10 ** power)) };
}

export function pointAxis(column: Column, { log = false, shown = null }: AxisOptions = {}): PointAxis {
  if (column.kind !== "number") {
    const labels = column.labels.length > 0 ? column.labels : [""];
    const at = column.values.map((value, row) => value + 0.6 * spread(row));
    return { low: -0.5, high: labels.length - 0.5, at, ticks: () => ({ at: labels.map((_label, i) => i), labels }) };
  }
  const at = log ? column.values.map((value) => (value > 0 ? Math.log10(value) : NaN)) : column.values;
  const [low, high] = limits(at, shown);
  return { low, high, at, ticks: (most) => (log ? logTicks : ticksOf)(low, high, most) };
}
