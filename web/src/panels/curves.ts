// Common parts of plots: curves with their axes, and the legend with values.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { mechanismColour, type Theme } from "../viewer/colours";
import { h } from "./dom";
import { digits } from "./numbers";
import type { Range } from "./scales";

/** The settings of plots that differ; see uPlot.Options. */
interface CurveOptions extends Pick<uPlot.Options, "cursor" | "hooks"> {
  readonly theme: Theme;
  readonly labels: readonly string[];
  readonly x: uPlot.Scale.Range;
  readonly y: uPlot.Scale.Range;
  /** If there are few, each is drawn as a point, because the line between them is not a result. */
  readonly rows?: number;
}

/** A plot of curves over time that fills an element. */
export function newPlot(host: HTMLElement, data: uPlot.AlignedData, options: CurveOptions): uPlot {
  const { theme, labels, x, y, rows = Infinity, cursor, hooks } = options;
  const axis = {
    stroke: theme.ink,
    font: "11px system-ui, sans-serif",
    grid: { stroke: theme.grid, width: 1 },
    ticks: { stroke: theme.grid, width: 1, size: 4 },
    gap: 2,
  };
  const curves = labels.map((label, i) => ({
    label,
    stroke: mechanismColour(theme, i),
    width: 1.6,
    pxAlign: 0, // no staircase on slopes
    points: { show: rows <= 40, size: 6 },
  }));
  return new uPlot(
    {
      width: Math.max(host.clientWidth, 50),
      height: Math.max(host.clientHeight, 50),
      legend: { show: false },
      padding: [6, 24, 0, 0], // on the right for half of the last label
      scales: { x: { time: false, range: x }, y: { range: y } },
      axes: [
        { ...axis, size: 24, values: (_u, ticks) => ticks.map((t) => `${digits(t)} s`) },
        { ...axis, size: 58, space: 24, values: (_u, ticks) => ticks.map((t) => digits(t)) },
      ],
      series: [{}, ...curves],
      ...(cursor && { cursor }),
      ...(hooks && { hooks }),
    },
    data,
    host,
  );
}

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
