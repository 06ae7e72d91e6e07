// What plots over time have in common: axes, curves and the legend with its values.
import type uPlot from "uplot";
import { seriesColour, type Theme } from "../viewer/colours";
import { h } from "./dom";
import { digits } from "./numbers";

/** Time below, values on the left. */
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

export const curvesOf = (theme: Theme, labels: readonly string[]): uPlot.Series[] => [
  {},
  ...labels.map((label, i) => ({
    label,
    stroke: seriesColour(theme, i),
    width: 1.6,
    pxAlign: 0, // a slope has no stairs
    points: { show: false },
  })),
];

/** Fills the legend anew; what it returns is for the values. */
export function fillLegend(legend: HTMLElement, theme: Theme, labels: readonly string[]): HTMLElement[] {
  const values = labels.map(() => h("span", { class: "value" }));
  legend.replaceChildren(
    ...labels.map((label, i) => {
      const swatch = h("span", { class: "swatch" });
      swatch.style.background = seriesColour(theme, i);
      return h("li", {}, swatch, label, values[i]);
    }),
  );
  return values;
}
