// The scatter plot of two columns, with colours by a third. A click picks a world, a drag marks those in a rectangle.
import { h } from "../../panels/dom";
import { onThemeChange, themeOf, type Theme } from "../../viewer/colours";
import type { Column } from "../document";
import type { Explorer } from "../explorer";
import { canBeAxis, canBeLog, pointAxis, type PointAxis } from "./point_axis";
import { pointColours } from "./point_colours";
import { pointLegend } from "./point_legend";
import { nearestPoint, nextPoint } from "./point_search";
import { areaOf, draw, positions, type Points } from "./scatter_picture";
import { columnChoice } from "../column_choice";
import { soon } from "../soon";
import { titleOf, valueText, worldsText } from "../words";

export class Scatter {
  readonly element: HTMLElement;
  private readonly canvas = h("canvas", { tabindex: 0, role: "img" });
  private readonly ring = h("div", { class: "ring", hidden: true });
  private readonly rectangle = h("div", { class: "rectangle", hidden: true });
  private readonly tip = h("div", { class: "tip", hidden: true });
  private readonly legend = h("ul", { class: "legend" });
  private readonly note = h("p", { class: "note" });
  private readonly host = h("div", { class: "scatter" }, this.canvas, this.ring, this.rectangle, this.tip);
  private readonly chooseX: HTMLSelectElement;
  private readonly chooseY: HTMLSelectElement;
  private readonly chooseColour: HTMLSelectElement;
  private readonly logX = h("input", { type: "checkbox", "aria-label": "Logarithmic x" });
  private readonly logY = h("input", { type: "checkbox", "aria-label": "Logarithmic y" });
  private readonly zoom = h("button", { type: "button", "aria-pressed": "false", hidden: true }, "Zoom to marked");
  private theme: Theme = themeOf(false);
  private axes: { x: PointAxis; y: PointAxis } | null = null;
  private at: Points = { x: new Float32Array(), y: new Float32Array() };
  private colour: Column | null;
  private anchor: { x: number; y: number } | null = null;
  private readonly paintSoon = soon(() => this.paint());

  /** `colour`: the column that is chosen first for the colours. */
  constructor(
    private readonly explorer: Explorer,
    colour: Column | null,
  ) {
    const columns = explorer.sweep.columns.filter(canBeAxis);
    this.colour = colour;
    this.chooseX = columnChoice("Horizontal axis", columns, explorer.x);
    this.chooseY = columnChoice("Vertical axis", columns, explorer.y);
    this.chooseColour = columnChoice("Colour", columns, colour, "one colour");
    const chosen = (select: HTMLSelectElement) => explorer.column(select.value) ?? null;
    for (const select of [this.chooseX, this.chooseY])
      select.addEventListener("change", () => {
        const [x, y] = [chosen(this.chooseX), chosen(this.chooseY)];
        if (x && y) explorer.plot(x, y);
      });
    this.chooseColour.addEventListener("change", () => {
      this.colour = chosen(this.chooseColour);
      this.paint();
    });
    const swap = h("button", { type: "button", title: "Exchange the axes", "aria-label": "Exchange the axes" }, "⇄");
    swap.addEventListener("click", () => explorer.x && explorer.y && explorer.plot(explorer.y, explorer.x));
    this.element = h(
      "div",
      { class: "box plotted" },
      h(
        "div",
        { class: "choices" },
        h("label", {}, "x ", this.chooseX),
        h("label", {}, this.logX, "log"),
        swap,
        h("label", {}, "y ", this.chooseY),
        h("label", {}, this.logY, "log"),
        h("label", {}, "colour ", this.chooseColour),
        this.zoom,
      ),
      this.legend,
      this.host,
      this.note,
    );
    for (const box of [this.logX, this.logY]) box.addEventListener("change", () => this.show());
    this.zoom.addEventListener("click", () => this.setZoom(!this.zoomed));
    explorer.listen((change) => {
      if (change === "axes") this.show();
      else if (change === "marked") this.showMarked();
      else this.showPicked();
    });
    this.listen();
    onThemeChange((theme) => {
      this.theme = theme;
      this.paint();
    });
    new ResizeObserver(() => this.paint()).observe(this.host);
    this.show();
  }

  private show() {
    const { x, y } = this.explorer;
    if (!x || !y) return;
    this.chooseX.value = x.name;
    this.chooseY.value = y.name;
    const shown = this.zoomed ? this.explorer.marked : null;
    const axis = (column: Column, box: HTMLInputElement) => {
      box.parentElement!.hidden = !canBeLog(column);
      return pointAxis(column, { log: box.checked && canBeLog(column), shown });
    };
    this.axes = { x: axis(x, this.logX), y: axis(y, this.logY) };
    this.canvas.setAttribute(
      "aria-label",
      `Scatter plot of ${y.name} over ${x.name}: arrow keys go from world to world, Escape clears the marks`,
    );
    this.paint();
  }

  private get zoomed() {
    return this.zoom.getAttribute("aria-pressed") === "true";
  }

  private setZoom(zoomed: boolean) {
    this.zoom.setAttribute("aria-pressed", String(zoomed));
    this.show();
  }

  /** Marks that change leave the limits of the axes as they are, until there are none. */
  private showMarked() {
    const { marked, markedCount } = this.explorer;
    this.zoom.hidden = markedCount === 0;
    if (!marked && this.zoomed) this.setZoom(false);
    else this.paintSoon();
  }

  private paint() {
    const { clientWidth: width, clientHeight: height } = this.host;
    const { x, y } = this.explorer;
    if (!this.axes || !x || !y || width === 0 || height === 0) return;
    const [pixelsX, pixelsY] = [Math.round(width * devicePixelRatio), Math.round(height * devicePixelRatio)];
    if (this.canvas.width !== pixelsX || this.canvas.height !== pixelsY)
      [this.canvas.width, this.canvas.height] = [pixelsX, pixelsY];
    this.at = positions(this.axes.x, this.axes.y, areaOf(width, height));
    const picture = {
      ...this.axes,
      titles: { x: titleOf(x), y: titleOf(y) },
      colours: pointColours(this.theme, this.colour, x.values.length),
      marked: this.explorer.marked,
      theme: this.theme,
    };
    draw(this.canvas.getContext("2d")!, picture, this.at, width, height);
    const absent = x.values.reduce((sum, at, row) => sum + Number(!Number.isFinite(at + y.values[row])), 0);
    this.note.textContent = absent > 0 ? `${worldsText(absent)} ${absent === 1 ? "has" : "have"} no value here.` : "";
    this.legend.replaceChildren(...pointLegend(this.theme, this.colour));
    this.showPicked();
  }

  private place(element: HTMLElement, row: number): boolean {
    const there = row >= 0 && Number.isFinite(this.at.x[row] + this.at.y[row]);
    element.hidden = !there;
    if (there) element.style.transform = `translate(${this.at.x[row]}px, ${this.at.y[row]}px)`;
    return there;
  }

  private showPicked() {
    const { picked } = this.explorer;
    this.place(this.ring, picked === null ? -1 : this.explorer.rowOf(picked));
  }

  private showTip(row: number) {
    const { x, y, sweep } = this.explorer;
    if (!this.place(this.tip, row) || !x || !y) return;
    const shown = [x, y, ...(this.colour && this.colour !== x && this.colour !== y ? [this.colour] : [])];
    const lines = shown.map((column) => h("div", {}, `${column.name}: ${valueText(column, column.values[row], 5)}`));
    this.tip.replaceChildren(h("div", { class: "box" }, h("strong", {}, `World ${sweep.world[row]}`), ...lines));
    this.tip.classList.toggle("to-left", this.at.x[row] > 0.5 * this.host.clientWidth);
    this.tip.classList.toggle("to-top", this.at.y[row] > 0.5 * this.host.clientHeight);
  }

  private listen() {
    const { canvas, explorer } = this;
    const placeOf = (event: PointerEvent) => {
      const { left, top } = canvas.getBoundingClientRect();
      return { x: event.clientX - left, y: event.clientY - top };
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.anchor = placeOf(event);
      if (event.pointerType !== "touch") canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const to = placeOf(event);
      if (!this.anchor) return void this.showTip(event.pointerType === "touch" ? -1 : nearestPoint(this.at, to.x, to.y, 12));
      if (event.pointerType === "touch") return; // scrolls the page
      if (!this.rectangle.hidden || Math.hypot(to.x - this.anchor.x, to.y - this.anchor.y) > 4) this.drag(this.anchor, to);
    });
    canvas.addEventListener("pointerup", (event) => {
      const to = placeOf(event);
      const dragged = !this.rectangle.hidden;
      this.rectangle.hidden = true;
      const began = this.anchor;
      this.anchor = null;
      if (dragged || !began) return;
      const row = nearestPoint(this.at, to.x, to.y, event.pointerType === "touch" ? 24 : 12);
      if (row >= 0) explorer.pick(explorer.sweep.world[row]);
      else explorer.clearMarks();
    });
    const stop = () => {
      this.tip.hidden = true;
      if (this.rectangle.hidden) this.anchor = null;
    };
    canvas.addEventListener("pointercancel", stop);
    canvas.addEventListener("pointerleave", stop);
    canvas.addEventListener("keydown", (event) => this.onKey(event));
  }

  /** Marks the points within the rectangle. */
  private drag(from: { x: number; y: number }, to: { x: number; y: number }) {
    const [left, right] = [Math.min(from.x, to.x), Math.max(from.x, to.x)];
    const [top, bottom] = [Math.min(from.y, to.y), Math.max(from.y, to.y)];
    this.tip.hidden = true;
    this.rectangle.hidden = false;
    Object.assign(this.rectangle.style, {
      left: `${left}px`,
      top: `${top}px`,
      width: `${right - left}px`,
      height: `${bottom - top}px`,
    });
    const { x, y } = this.at;
    const { explorer } = this;
    const as = `a part of the plot of ${explorer.y?.name} over ${explorer.x?.name}`;
    explorer.mark(as, (row) => x[row] >= left && x[row] <= right && y[row] >= top && y[row] <= bottom);
  }

  private onKey(event: KeyboardEvent) {
    const { explorer } = this;
    const step = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1 }[event.key];
    if (step !== undefined) {
      const from = explorer.picked === null ? -1 : explorer.rowOf(explorer.picked);
      const row = nextPoint(this.at, from, step, event.key === "ArrowUp" || event.key === "ArrowDown");
      if (row >= 0) explorer.pick(explorer.sweep.world[row]);
    } else if (event.key === "Escape") explorer.clearMarks();
    else return;
    event.preventDefault();
  }
}
