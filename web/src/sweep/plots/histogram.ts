// The distribution of a column: bars, and below them the quantiles. A bin can be read and marked by pointer and keyboard.
import { h } from "../../panels/dom";
import { digits } from "../../panels/numbers";
import type { Column, Histogram } from "../document";
import type { Explorer } from "../explorer";
import { soon } from "../soon";
import { binOf } from "./statistics";
import { svg } from "./svg";
import { ticksOf } from "./ticks";
import { percent, worldsText } from "../words";

/** The edges of a bin and the next. */
const edge = ({ from, to, counts }: Histogram, bin: number) => from + ((to - from) * bin) / counts.length;

export class HistogramPlot {
  readonly element: HTMLElement;
  private readonly picture: SVGSVGElement;
  private readonly markedBars: SVGGElement;
  private readonly highlight: SVGRectElement;
  private readonly reading = h("p", { class: "reading", "aria-hidden": "true" });
  private readonly highest: number;
  private readonly total: number;
  private bin: number;
  private anchor: number | null = null;
  /** Marks are drawn only in view. */
  private inView = false;
  private outdated = false;
  /** By row; -1 if there is no value. Computed when worlds are marked for the first time. */
  private bins: Int32Array | null = null;

  constructor(
    private readonly explorer: Explorer,
    private readonly column: Column,
    private readonly histogram: Histogram,
  ) {
    const { counts } = histogram;
    this.highest = Math.max(1, ...counts);
    this.total = counts.reduce((sum, count) => sum + count, 0);
    this.bin = counts.indexOf(Math.max(...counts));
    this.markedBars = svg("g", { class: "bars marked" });
    this.highlight = svg("rect", { class: "highlight", y: 0, width: 1, height: 100 });
    this.highlight.setAttribute("visibility", "hidden");
    this.picture = svg(
      "svg",
      {
        viewBox: `0 0 ${counts.length} 100`,
        preserveAspectRatio: "none",
        tabindex: 0,
        role: "slider",
        "aria-label": `Distribution of ${column.name}: arrow keys choose a bin, Enter marks its worlds`,
        "aria-valuemin": 0,
        "aria-valuemax": counts.length - 1,
      },
      this.highlight,
      svg("g", { class: "bars" }, ...this.bars(counts)),
      this.markedBars,
    );
    this.element = h(
      "div",
      { class: "histogram" },
      h("div", { class: "drawn" }, this.picture as unknown as HTMLElement, this.quantiles(), this.axis()),
      this.reading,
    );
    this.listen();
    this.read(false);
    const showMarked = soon(() => this.showMarked());
    explorer.listen((change) => {
      if (change !== "marked") return;
      this.outdated = true;
      showMarked();
    });
    new IntersectionObserver(([{ isIntersecting }]) => {
      this.inView = isIntersecting;
      showMarked();
    }).observe(this.element);
  }

  private bars(counts: readonly number[]): SVGRectElement[] {
    return counts.flatMap((count, bin) => {
      if (count === 0) return [];
      const height = Math.max((100 * count) / this.highest, 1.2); // visible, if only just
      return [svg("rect", { x: bin + 0.04, y: 100 - height, width: 0.92, height })];
    });
  }

  /** At what share of the width a value is. */
  private place(value: number): number {
    const { from, to } = this.histogram;
    return to > from ? Math.min(Math.max((value - from) / (to - from), 0), 1) : 0.5;
  }

  /** Whiskers from 5 % to 95 %, a box from 25 % to 75 %, a line at the median and a point at the mean. */
  private quantiles(): HTMLElement {
    const strip = h("div", { class: "strip", "aria-hidden": "true" });
    const between = (kind: string, low: number | undefined, high: number | undefined) => {
      if (low === undefined || high === undefined || Number.isNaN(low)) return;
      const part = h("span", { class: kind });
      part.style.left = `${100 * this.place(low)}%`;
      part.style.width = `${100 * (this.place(high) - this.place(low))}%`;
      strip.append(part);
    };
    const { quantiles, mean } = this.column;
    between("whisker", quantiles.get(0.05), quantiles.get(0.95));
    between("middle", quantiles.get(0.25), quantiles.get(0.75));
    between("median", quantiles.get(0.5), quantiles.get(0.5));
    between("mean", mean, mean);
    return strip;
  }

  private axis(): HTMLElement {
    const { from, to } = this.histogram;
    const { at, labels } = ticksOf(from, to, 4);
    const axis = h("div", { class: "axis", "aria-hidden": "true" });
    at.forEach((value, i) => {
      const label = h("span", {}, labels[i]);
      label.style.left = `${100 * this.place(value)}%`;
      axis.append(label);
    });
    return axis;
  }

  private read(highlighted: boolean) {
    const { histogram, bin, column } = this;
    const unit = column.unit ? ` ${column.unit}` : "";
    const [low, high] = [digits(edge(histogram, bin)), digits(edge(histogram, bin + 1))];
    const range = histogram.to > histogram.from ? `${low} to ${high}${unit}` : `${low}${unit}`;
    const share = percent(histogram.counts[bin] / Math.max(this.total, 1));
    // A histogram of a sample of the worlds gives shares, but not numbers of worlds.
    const text = `${range}: ${this.total === column.count ? `${worldsText(histogram.counts[bin])}, ` : ""}${share}`;
    this.picture.setAttribute("aria-valuenow", String(bin));
    this.picture.setAttribute("aria-valuetext", text);
    this.highlight.setAttribute("x", String(bin));
    this.highlight.setAttribute("visibility", highlighted ? "visible" : "hidden");
    this.reading.textContent = highlighted ? text : "";
  }

  private markBins(one: number, other: number) {
    const [first, last] = [Math.min(one, other), Math.max(one, other)];
    const unit = this.column.unit ? ` ${this.column.unit}` : "";
    const [low, high] = [digits(edge(this.histogram, first)), digits(edge(this.histogram, last + 1))];
    this.explorer.mark(`${this.column.name} from ${low} to ${high}${unit}`, (row) => {
      const bin = binOf(this.histogram, this.column.values[row]);
      return bin >= first && bin <= last;
    });
  }

  private listen() {
    const { picture } = this;
    const bins = this.histogram.counts.length;
    const binAt = (event: PointerEvent) => {
      const { left, width } = picture.getBoundingClientRect();
      return Math.min(Math.max(Math.floor(((event.clientX - left) / width) * bins), 0), bins - 1);
    };
    picture.addEventListener("pointermove", (event) => {
      this.bin = binAt(event);
      this.read(true);
      if (this.anchor !== null && this.anchor !== this.bin) this.markBins(this.anchor, this.bin);
    });
    picture.addEventListener("pointerdown", (event) => {
      this.anchor = this.bin = binAt(event);
      picture.setPointerCapture(event.pointerId);
      this.read(true);
    });
    picture.addEventListener("pointerup", () => {
      if (this.anchor !== null) this.markBins(this.anchor, this.bin);
      this.anchor = null;
    });
    picture.addEventListener("pointercancel", () => (this.anchor = null));
    picture.addEventListener("pointerleave", () => this.read(document.activeElement === (picture as Element)));
    picture.addEventListener("focus", () => this.read(picture.matches(":focus-visible")));
    picture.addEventListener("blur", () => this.read(false));
    picture.addEventListener("keydown", (event) => this.onKey(event));
  }

  private onKey(event: KeyboardEvent) {
    const last = this.histogram.counts.length - 1;
    const next = { ArrowLeft: this.bin - 1, ArrowRight: this.bin + 1, Home: 0, End: last }[event.key];
    if (next !== undefined) {
      this.bin = Math.min(Math.max(next, 0), last);
      this.read(true);
    } else if (event.key === "Enter" || event.key === " ") this.markBins(this.bin, this.bin);
    else return;
    event.preventDefault();
  }

  /** The marked worlds in the page, scaled to the worlds of the histogram. */
  private showMarked() {
    if (!this.inView || !this.outdated) return;
    this.outdated = false;
    const { marked } = this.explorer;
    const { histogram, column } = this;
    this.bins ??= Int32Array.from(column.values, (value) => binOf(histogram, value));
    const counts = new Array<number>(histogram.counts.length).fill(0);
    let shown = 0;
    this.bins.forEach((bin, row) => {
      if (bin < 0) return;
      shown++;
      if (marked?.[row]) counts[bin]++;
    });
    const scale = this.total / Math.max(shown, 1);
    this.markedBars.replaceChildren(...(marked ? this.bars(counts.map((count) => count * scale)) : []));
    this.element.classList.toggle("has-marks", marked !== null);
  }
}
