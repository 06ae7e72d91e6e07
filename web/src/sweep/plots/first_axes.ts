// What the scatter plot shows first.
import type { Column, Sweep } from "../document";
import { canBeAxis } from "./point_axis";

const varies = (column: Column) => column.count > 0 && !(column.least === column.greatest);

/** The strongest known dependence of a measure, otherwise the first columns that vary; colours by the first flag that varies. */
export function firstAxes({ columns, sensitivities }: Sweep): { x: Column | null; y: Column | null; colour: Column | null } {
  const axes = columns.filter(canBeAxis);
  const named = (name: string) => axes.find((column) => column.name === name);
  const strongest = sensitivities
    .filter(({ measure, vary, correlation }) => correlation !== null && named(measure)?.kind === "number" && named(vary))
    .sort((a, b) => Math.abs(b.correlation ?? 0) - Math.abs(a.correlation ?? 0))[0];
  const first = (role: Column["role"]) =>
    axes.find((column) => column.role === role && column.kind === "number" && varies(column)) ??
    axes.find((column) => column.role === role && column.count > 0);
  const y = (strongest && named(strongest.measure)) ?? first("measure") ?? first("vary") ?? axes[0] ?? null;
  const x =
    (strongest && named(strongest.vary)) ??
    axes.find((column) => column !== y && column.role === "vary" && varies(column)) ??
    axes.find((column) => column !== y) ??
    y;
  return { x, y, colour: axes.find((column) => column.kind === "flag" && varies(column)) ?? null };
}
