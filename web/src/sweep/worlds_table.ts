// The table of all worlds: sorted by any column; only the rows in view are in the page, so that it can have many.
import { h } from "../panels/dom";
import type { Column } from "./document";
import type { Explorer } from "./explorer";
import { soon } from "./soon";
import { breakable, cellText, shortened } from "./words";

const rowHeight = 26;
/** Rows beyond the view, above and below. */
const spare = 6;

/** In the order of a column (null: of the worlds' numbers); missing values are last in both directions. */
export function sortedRows(rows: Int32Array, values: Float64Array, descending: boolean): Int32Array {
  const sign = descending ? -1 : 1;
  return rows.slice().sort((a, b) => {
    const [one, other] = [values[a], values[b]];
    if (Number.isNaN(one) || Number.isNaN(other)) return Number(Number.isNaN(one)) - Number(Number.isNaN(other)) || a - b;
    return sign * (one - other) || a - b;
  });
}

export class WorldsTable {
  readonly element: HTMLElement;
  /** The rows that are shown, in their order. */
  rows: Int32Array;
  private readonly body = h("tbody");
  private readonly table: HTMLTableElement;
  private readonly headings: HTMLTableCellElement[] = [];
  private sortedBy = -1;
  private descending = false;
  private filtered: Int32Array;
  /** The lines in the page, by place in `rows`. */
  private lines = new Map<number, HTMLElement>();

  constructor(private readonly explorer: Explorer) {
    const { columns, world } = explorer.sweep;
    this.filtered = this.rows = Int32Array.from(world.keys());
    const short = shortened(columns.map(({ name }) => name));
    const heading = (name: string, index: number, column?: Column) => {
      const text = short[index] ?? name;
      const title = column?.about ? `${name}: ${column.about}` : name;
      const label = text !== name && h("span", { class: "hidden-text" }, name);
      const button = h(
        "button",
        { type: "button", title },
        h("span", { "aria-hidden": String(label !== false) }, breakable(text)),
        label,
      );
      button.addEventListener("click", () => this.sort(index, this.sortedBy === index && !this.descending));
      const cell = h("th", { scope: "col" }, button, column?.unit ? h("span", { class: "unit" }, column.unit) : false);
      this.headings.push(cell);
      return cell;
    };
    const cells = [heading("world", -1), ...columns.map((column, i) => heading(column.name, i, column))];
    this.table = h(
      "table",
      { class: "worlds", role: "grid" },
      h("caption", { class: "hidden-text" }, "Worlds: arrow keys go from row to row"),
      h("thead", {}, h("tr", { "aria-rowindex": 1 }, ...cells)),
      this.body,
    );
    this.table.style.width = `${6 + 9.5 * columns.length}em`;
    this.element = h(
      "div",
      { class: "box scrolls worlds-box", tabindex: 0, role: "group", "aria-label": "Table of worlds" },
      this.table,
    );
    const fill = soon(() => this.fill());
    this.element.addEventListener("scroll", fill);
    this.element.addEventListener("keydown", (event) => this.onKey(event));
    new ResizeObserver(fill).observe(this.element);
    explorer.listen((change) => change === "picked" && this.refill());
    this.sort(-1, false);
  }

  /** Shows the rows for which `holds`. */
  filter(holds: (row: number) => boolean) {
    this.filtered = Int32Array.from(this.explorer.sweep.world.keys()).filter(holds);
    this.sort(this.sortedBy, this.descending);
  }

  private sort(index: number, descending: boolean) {
    const { columns, world } = this.explorer.sweep;
    this.sortedBy = index;
    this.descending = descending;
    this.rows = sortedRows(this.filtered, index < 0 ? world : columns[index].values, descending);
    this.headings.forEach((cell, i) => {
      const sorted = i - 1 === index;
      cell.setAttribute("aria-sort", sorted ? (descending ? "descending" : "ascending") : "none");
    });
    this.table.setAttribute("aria-rowcount", String(this.rows.length + 1));
    this.element.scrollTop = 0;
    this.refill();
  }

  private refill() {
    this.lines.clear();
    this.fill();
  }

  private fill() {
    const { columns } = this.explorer.sweep;
    const visible = Math.ceil((this.element.clientHeight || 400) / rowHeight);
    const top = Math.floor(this.element.scrollTop / rowHeight);
    const first = Math.max(Math.min(top, this.rows.length - visible) - spare, 0);
    const last = Math.min(top + visible + spare, this.rows.length);
    const gap = (rows: number) => {
      const cell = h("td", { colspan: columns.length + 1 });
      cell.style.height = `${rows * rowHeight}px`;
      return rows > 0 ? [h("tr", { class: "gap", "aria-hidden": "true" }, cell)] : [];
    };
    const lines = new Map<number, HTMLElement>();
    for (let i = first; i < last; i++) lines.set(i, this.lines.get(i) ?? this.line(i));
    this.lines = lines;
    this.body.replaceChildren(...gap(first), ...lines.values(), ...gap(this.rows.length - last));
  }

  private line(index: number): HTMLElement {
    const { columns, world } = this.explorer.sweep;
    const row = this.rows[index];
    const picked = world[row] === this.explorer.picked;
    const cells = columns.map((column) => h("td", {}, cellText(column, column.values[row])));
    const line = h(
      "tr",
      { "aria-rowindex": index + 2, "aria-selected": String(picked), class: picked ? "picked" : "" },
      h("th", { scope: "row" }, String(world[row])),
      ...cells,
    );
    line.addEventListener("click", () => this.explorer.pick(world[row]));
    return line;
  }

  private onKey(event: KeyboardEvent) {
    if (event.target !== this.element || this.rows.length === 0) return;
    const { world } = this.explorer.sweep;
    const page = Math.max(Math.floor(this.element.clientHeight / rowHeight) - 2, 1);
    const at = this.rows.findIndex((row) => world[row] === this.explorer.picked);
    const last = this.rows.length - 1;
    const next = { ArrowDown: at + 1, ArrowUp: at - 1, PageDown: at + page, PageUp: at - page, Home: 0, End: last }[event.key];
    if (next === undefined) return;
    event.preventDefault();
    const to = Math.min(Math.max(next, 0), last);
    const head = this.headings[0].offsetHeight;
    const { scrollTop, clientHeight } = this.element;
    if (to * rowHeight < scrollTop) this.element.scrollTop = to * rowHeight;
    else if ((to + 1) * rowHeight + head > scrollTop + clientHeight)
      this.element.scrollTop = (to + 1) * rowHeight + head - clientHeight;
    this.explorer.pick(world[this.rows[to]]);
  }
}
