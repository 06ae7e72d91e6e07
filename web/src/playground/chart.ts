// A plot of the last seconds, drawn again a few times a second while frames come.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { LiveRecording } from "../engine/live";
import { axesOf, curvesOf, fillLegend } from "../panels/curves";
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
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

  constructor(
    title: string,
    private readonly unit: string,
    private readonly series: readonly Series[],
  ) {
    this.host.setAttribute("aria-label", `${title} over time: ${series.map((s) => s.label).join(", ")}`);
    this.element = h("figure", {}, h("figcaption", {}, h("span", {}, title), this.legend), this.host);
    new ResizeObserver(() => {
      const { clientWidth: width, clientHeight: height } = this.host;
      if (width > 0 && height > 0) this.chart?.setSize({ width, height });
    }).observe(this.host);
  }

  setTheme(theme: Theme) {
    const labels = this.series.map(({ label }) => label);
    const data = this.chart?.data ?? ([[], ...this.series.map(() => [])] as uPlot.AlignedData);
    this.chart?.destroy();
    this.chart = new uPlot(
      {
        width: Math.max(this.host.clientWidth, 50),
        height: Math.max(this.host.clientHeight, 50),
        legend: { show: false },
        padding: [6, 10, 0, 0],
        cursor: { show: false },
        scales: {
          x: { time: false, range: (_u, from, to) => [from ?? 0, Math.max(to ?? 1, (from ?? 0) + 1)] },
          y: { range: (_u, low, high) => (low === high ? [low - 1, high + 1] : uPlot.rangeNum(low, high, 0.1, true)) },
        },
        axes: axesOf(theme),
        series: curvesOf(theme, labels),
      },
      data,
      this.host,
    );
    this.values = fillLegend(this.legend, theme, labels);
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
    this.chart?.setData([times, ...columns]);
    this.series.forEach((_each, k) => {
      if (this.values[k]) this.values[k].textContent = ` ${digits(columns[k][columns[k].length - 1] ?? NaN)} ${this.unit}`;
    });
  }
}
