// A plot of the last seconds, redrawn a few times a second while frames arrive.
import type uPlot from "uplot";
import type { LiveRecording } from "../engine/live";
import { axisRange, fillLegend, newPlot } from "../panels/curves";
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import { rangeOf, withoutNoise, type Range } from "../panels/scales";
import type { Theme } from "../viewer/colours";
import type { WorldTotals } from "../../../wasm/host.mjs";

export interface Series {
  readonly label: string;
  readonly of: (totals: WorldTotals) => number;
}

const most = 1200;

export class Chart {
  readonly element: HTMLElement;
  private readonly host = h("div", { class: "plot", role: "img" });
  private readonly legend = h("ul", { class: "legend" });
  private chart: uPlot | null = null;
  private values: HTMLElement[] = [];
  private theme: Theme | null = null;
  private times: [number, number] = [0, 1];
  private range: Range = { low: -1, high: 1, flat: null };

  /** `scale`: typical size of the quantity in these frames (rangeOf). */
  constructor(
    title: string,
    private readonly unit: string,
    private readonly series: readonly Series[],
    private readonly scale: (run: LiveRecording, from: number, to: number) => number,
  ) {
    this.host.setAttribute("aria-label", `${title} over time: ${series.map((s) => s.label).join(", ")}`);
    this.element = h("figure", {}, h("figcaption", {}, h("span", {}, title), this.legend), this.host);
    new ResizeObserver(() => {
      const { clientWidth: width, clientHeight: height } = this.host;
      if (width > 0 && height > 0) this.chart?.setSize({ width, height });
    }).observe(this.host);
  }

  setTheme(theme: Theme) {
    this.theme = theme;
    const labels = this.series.map(({ label }) => label);
    const data = this.chart?.data ?? ([[], ...this.series.map(() => [])] as uPlot.AlignedData);
    this.chart?.destroy();
    this.chart = newPlot(this.host, data, {
      theme,
      labels,
      x: () => this.times,
      y: () => axisRange(this.range),
      cursor: { show: false },
    });
    this.fillLegend();
  }

  private fillLegend() {
    const labels = this.series.map(({ label }) => label);
    if (this.theme) this.values = fillLegend(this.legend, this.theme, labels, this.range.flat);
  }

  /** Up to the frame that is shown. */
  show(run: LiveRecording, frame: number) {
    const from = Math.max(0, frame + 1 - most);
    const times: number[] = [];
    const columns: number[][] = this.series.map(() => []);
    for (let i = from; i <= frame; i++) {
      const totals = run.totals(i);
      times.push(run.time(i));
      this.series.forEach((each, k) => columns[k].push(each.of(totals)));
    }
    const wasFlat = this.range.flat;
    this.times = [times[0], Math.max(times[times.length - 1], times[0] + 1)];
    const scale = this.scale(run, from, frame);
    this.range = rangeOf(columns, scale);
    if (frame === 0) this.range = { ...this.range, flat: null }; // one frame does not show which values change
    if (this.range.flat !== wasFlat) this.fillLegend();
    this.chart?.setData([times, ...columns]);
    this.series.forEach((_each, k) => {
      const value = withoutNoise(columns[k][columns[k].length - 1] ?? NaN, scale, this.range);
      if (this.values[k]) this.values[k].textContent = ` ${digits(value)} ${this.unit}`;
    });
  }
}
