// The distribution of a flag or a text: a bar for each value. A press on one marks its worlds.
import { h } from "../../panels/dom";
import type { Column } from "../document";
import type { Explorer } from "../explorer";
import { percent, worldsText } from "../words";

/** Values beyond these, the most frequent, are only counted. */
const most = 8;

interface Value {
  readonly index: number;
  readonly label: string;
  readonly share: number;
  /** Of all worlds. */
  readonly count: number;
}

function valuesOf(column: Column): Value[] {
  const { labels, values, count, share } = column;
  if (column.kind === "flag")
    return [1, 0].map((index) => {
      const part = index === 1 ? share : 1 - share;
      return { index, label: labels[index], share: part, count: Math.round(part * count) };
    });
  const counts = new Array<number>(labels.length).fill(0);
  for (const value of values) if (Number.isFinite(value)) counts[value]++;
  const shown = counts.reduce((sum, each) => sum + each, 0);
  return labels
    .map((label, index) => ({ index, label, share: counts[index] / shown, count: Math.round((counts[index] / shown) * count) }))
    .sort((a, b) => b.count - a.count);
}

function barOf(explorer: Explorer, column: Column, value: Value): HTMLElement {
  const bar = h("span", { class: "bar" });
  const filled = h("span", { class: value.index === 1 && column.kind === "flag" ? "filled yes" : "filled" });
  filled.style.width = `${100 * value.share}%`;
  bar.append(filled);
  if (column.interval && value.index === 1) {
    const [from, to] = column.interval;
    const interval = h("span", { class: "interval" });
    interval.style.left = `${100 * from}%`;
    interval.style.width = `${100 * (to - from)}%`;
    bar.append(interval);
  }
  const name = value.label || "(empty)";
  const mark = () => explorer.mark(`${column.name}: ${value.label}`, (row) => column.values[row] === value.index);
  return h(
    "button",
    { type: "button", class: "category", onclick: mark },
    h("span", { class: "hidden-text" }, `Mark ${column.name}: `),
    h("span", { class: "label" }, name),
    bar,
    h("span", { class: "share" }, h("span", { class: "hidden-text" }, ", "), percent(value.share)),
    h("span", { class: "hidden-text" }, `, ${worldsText(value.count)}`),
  );
}

export function categories(explorer: Explorer, column: Column): HTMLElement {
  const values = valuesOf(column);
  const { interval } = column;
  return h(
    "div",
    { class: "categories" },
    ...values.slice(0, most).map((value) => barOf(explorer, column, value)),
    values.length > most && h("p", { class: "note" }, `and ${values.length - most} other values`),
    interval &&
      h(
        "p",
        { class: "note" },
        `${column.labels[1]}: ${worldsText(Math.round(column.share * column.count))}; ` +
          `95 % interval ${percent(interval[0])} to ${percent(interval[1])}`,
      ),
  );
}
