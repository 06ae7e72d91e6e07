// One plot over time, linked to the clock: a line at the current time, marks at events, values in the legend; a click
// sets the time.
import type uPlot from "uplot";
import type { Column, Recording } from "../recording";
import type { Theme } from "../viewer/colours";
import { endTime, frameAt, startTime } from "../viewer/frames";
import type { Player } from "../viewer/player";
import { axisRange, fillLegend, newPlot } from "./curves";
import { h } from "./dom";
import { digits } from "./numbers";
import { rangeOf, withoutNoise, type Range } from "./scales";
import { marked } from "./timeline";

/** Columns that are negligible compared with the largest are left out, but at least one stays. */
export function significantColumns(columns: readonly Column[], share = 1e-7): readonly Column[] {
  const largest = columns.map((column) => {
    let most = 0;
    for (let i = 0; i < column.values.length; i++) if (Math.abs(column.values[i]) > most) most = Math.abs(column.values[i]);
    return most;
  });
  const all = Math.max(...largest, 0);
  const significant = columns.filter((_column, i) => largest[i] > share * all);
  return significant.length > 0 ? significant : columns.slice(0, 1);
}

export class Plot {
  readonly element = h("div", { class: "plot", role: "img" });
  readonly legend = h("ul", { class: "legend" });
  private chart: uPlot | null = null;
  private readonly cursor = h("div", { class: "now" });
  private columns: readonly Column[] = [];
  private values: HTMLElement[] = [];
  private theme: Theme | null = null;
  private title = "";
  private scale = 0;
  private precision = 0;
  private pointed: number | null = null;
  private range: Range = { low: 0, high: 0, flat: null };
  private readonly marked: readonly number[];
  private readonly resizeObserver = new ResizeObserver(() => this.resize());

  constructor(
    private readonly run: Recording,
    private readonly player: Player,
  ) {
    this.marked = marked(run.events, startTime(run), endTime(run), 0.002);
    this.resizeObserver.observe(this.element);
    player.listen(() => this.follow());
  }

  setTheme(theme: Theme) {
    this.theme = theme;
    this.show(this.title, this.columns, this.scale, this.precision);
  }

  /** `scale`, `precision`: see rangeOf(). */
  show(title: string, columns: readonly Column[], scale: number, precision: number) {
    this.title = title;
    this.columns = columns;
    this.scale = scale;
    this.precision = precision;
    if (!this.theme) return;
    this.chart?.destroy();
    this.chart = null;
    this.pointed = null;
    const theme = this.theme;
    this.legend.replaceChildren();
    this.element.replaceChildren();
    if (columns.length === 0) {
      this.element.append(h("p", { class: "nothing" }, "The run did not record this quantity."));
      return;
    }
    const times = Array.from({ length: this.run.frames }, (_none, frame) => this.run.time(frame));
    // uPlot uses null for a gap in a line.
    const data = columns.map((column) => Array.from(column.values, (value) => (Number.isFinite(value) ? value : null)));
    const range = rangeOf(
      columns.map(({ values }) => values),
      scale,
      precision,
    );
    this.range = range;
    const labels = columns.map(({ label }) => label);
    const [first, last] = [times[0], times[times.length - 1]];
    this.chart = newPlot(this.element, [times, ...data] as uPlot.AlignedData, {
      theme,
      labels,
      x: [first, last > first ? last : first + 1],
      y: axisRange(range),
      rows: this.run.frames,
      cursor: { y: false, points: { size: 6 }, drag: { x: false, y: false }, sync: { key: "time" } },
      hooks: {
        ready: [(u) => this.listen(u)],
        setCursor: [(u) => this.point(u.cursor.idx ?? null)],
        drawClear: [(u) => this.drawEvents(u, theme)],
      },
    });
    this.chart.over.append(this.cursor);
    this.values = fillLegend(this.legend, theme, labels, this.run.frames > 1 ? range.flat : null);
    const unit = columns[0].unit;
    this.element.setAttribute("aria-label", `${title}${unit ? ` in ${unit}` : ""} over time: ${labels.join(", ")}`);
    this.follow();
    this.resize(); // the legend takes room from the chart
  }

  /** A press or a drag on the plot sets the clock. */
  private listen(chart: uPlot) {
    const seek = (event: PointerEvent) => {
      this.player.pause();
      this.player.seek(chart.posToVal(event.clientX - chart.over.getBoundingClientRect().left, "x"));
    };
    chart.over.addEventListener("pointerdown", (event) => {
      if (event.pointerType !== "touch") chart.over.setPointerCapture(event.pointerId);
      seek(event);
    });
    chart.over.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) seek(event);
    });
  }

  private drawEvents(chart: uPlot, theme: Theme) {
    const { ctx, bbox } = chart;
    ctx.save();
    ctx.strokeStyle = theme.ink;
    ctx.globalAlpha = 0.35;
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
    ctx.beginPath();
    for (const index of this.marked) {
      const x = Math.round(chart.valToPos(this.run.events[index].time, "x", true));
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
    }
    ctx.stroke();
    ctx.restore();
  }

  /** The legend shows the values under the pointer, which all plots mark, and otherwise those at the clock. */
  private point(frame: number | null) {
    if (frame === this.pointed) return;
    this.pointed = frame;
    this.follow();
  }

  private follow() {
    const chart = this.chart;
    if (!chart) return;
    this.cursor.style.transform = `translateX(${chart.valToPos(this.player.time, "x")}px)`;
    const frame = this.pointed ?? frameAt(this.run, this.player.time);
    this.columns.forEach((column, i) => {
      this.values[i].textContent = ` ${digits(withoutNoise(column.values[frame], this.scale, this.range))} ${column.unit}`;
    });
  }

  private resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!this.chart || width === 0 || height === 0) return;
    this.chart.setSize({ width, height });
    this.follow();
  }
}
