// Common parts of plots: axes, curves, and the legend with values.
import uPlot from "uplot";
import { mechanismColour, type Theme } from "../viewer/colours";
import { h } from "./dom";
import { digits } from "./numbers";
import type { Range } from "./scales";

/** Time at the bottom, values on the left. */
export function axesOf(theme: Theme): uPlot.Axis[] {
  const axis = {
    stroke: theme.ink,
    font: "11px system-ui, sans-serif",
    grid: { stroke: theme.grid, width: 1 },
    ticks: { stroke: theme.grid, width: 1, size: 4 },
  };
  return [
    { ...axis, size: 24, gap: 2, values: (_u, ticks) => ticks.map((t) => `${digits(t)} s`) },
    { ...axis, size: 58, gap: 2, space: 24, values: (_u, ticks) => ticks.map((t) => digits(t)) },
  ];
}

/** Space to the right of the plot for half of the last label (pixels). */
export const labelRoom = 24;

/** `rows`: if there are few, each is drawn as a point, because the line between them is not a result. */
export const curvesOf = (theme: Theme, labels: readonly string[], rows = Infinity): uPlot.Series[] => [
  {},
  ...labels.map((label, i) => ({
    label,
    stroke: mechanismColour(theme, i),
    width: 1.6,
    pxAlign: 0, // no staircase on slopes
    points: { show: rows <= 40, size: 6 },
  })),
];

/** Limits of the value axis: with a margin, unless the curve is flat. */
export const axisRange = ({ low, high, flat }: Range): [number, number] => {
  if (flat) return [low, high];
  const [from, to] = uPlot.rangeNum(low, high, 0.1, true);
  return [from ?? low, to ?? high];
};

/**
 * Rebuilds the legend; returns the elements for the values. `flat`: a note that all values are zero, or constant, to
 * round-off.
 */
export function fillLegend(
  legend: HTMLElement,
  theme: Theme,
  labels: readonly string[],
  flat: Range["flat"] = null,
): HTMLElement[] {
  const values = labels.map(() => h("span", { class: "value" }));
  legend.replaceChildren(
    ...labels.map((label, i) => {
      const swatch = h("span", { class: "swatch" });
      swatch.style.background = mechanismColour(theme, i);
      return h("li", {}, swatch, label, values[i]);
    }),
    ...(flat ? [h("li", { class: "flat" }, `${flat} to round-off`)] : []),
  );
  return values;
}
