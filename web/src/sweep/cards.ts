// A card for each column: its distribution, its statistics, and for measures what they depend on.
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import { categories } from "./plots/categories";
import type { Column } from "./document";
import type { Explorer } from "./explorer";
import { HistogramPlot } from "./plots/histogram";
import { sensitivities } from "./plots/sensitivities";
import { breakable, valueText, worldsText } from "./words";

/** The least or the greatest value; a press picks its world. */
function extreme(explorer: Explorer, label: string, value: number, world: number | null): HTMLElement {
  const text = digits(value, 5);
  const pick = { type: "button", class: "link", title: `World ${world}`, "aria-label": `${label}: ${text}, world ${world}` };
  const content =
    world === null || !Number.isFinite(value) ? text : h("button", { ...pick, onclick: () => explorer.pick(world) }, text);
  return h("div", {}, h("dt", {}, label), h("dd", {}, content));
}

function statistics(explorer: Explorer, column: Column): HTMLElement {
  const term = (name: string, value: number | undefined) =>
    h("div", {}, h("dt", {}, name), h("dd", {}, digits(value ?? NaN, 5)));
  return h(
    "dl",
    { class: "statistics" },
    term("mean", column.mean),
    term("deviation", column.deviation),
    term("median", column.quantiles.get(0.5)),
    term("5 %", column.quantiles.get(0.05)),
    term("95 %", column.quantiles.get(0.95)),
    extreme(explorer, "least", column.least, column.leastWorld),
    extreme(explorer, "greatest", column.greatest, column.greatestWorld),
  );
}

export function card(explorer: Explorer, column: Column): HTMLElement {
  const { histogram } = column;
  const constant = column.kind === "number" && column.count > 0 && column.least === column.greatest;
  const parts: (HTMLElement | false | null)[] =
    column.count === 0
      ? [h("p", { class: "note" }, column.missing > 0 ? "No world has a value." : "There are no worlds.")]
      : [
          constant && h("p", { class: "constant" }, `${valueText(column, column.least)} in all worlds`),
          !constant && histogram && new HistogramPlot(explorer, column, histogram).element,
          !constant && (column.kind === "number" ? statistics(explorer, column) : categories(explorer, column)),
          column.missing > 0 && h("p", { class: "note" }, `${worldsText(column.missing)} without a value.`),
        ];
  return h(
    "article",
    { class: "box card", "aria-label": column.name },
    h("h3", {}, breakable(column.name), column.unit !== "" && h("span", { class: "unit" }, ` ${column.unit}`)),
    column.about !== "" && h("p", { class: "about" }, column.about),
    ...parts,
    column.role === "measure" && sensitivities(explorer, column),
  );
}
