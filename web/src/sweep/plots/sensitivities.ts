// What a measure depends on: rank correlations as bars around zero, and first-order indices.
import { h } from "../../panels/dom";
import { digits } from "../../panels/numbers";
import type { Column, Sensitivity } from "../document";
import type { Explorer } from "../explorer";
import { breakable, worldsText } from "../words";

const most = 5;

const size = ({ correlation, first_order }: Sensitivity) => Math.max(Math.abs(correlation ?? 0), first_order ?? 0);

function rowOf(explorer: Explorer, measure: Column, { vary, correlation, first_order, correlated }: Sensitivity): HTMLElement {
  const x = explorer.column(vary);
  const name = x
    ? h(
        "button",
        { type: "button", class: "link", title: "Plot the measure over this", onclick: () => explorer.plot(x, measure) },
        breakable(vary),
      )
    : breakable(vary);
  const bar = h("span", { class: "signed", "aria-hidden": "true" });
  if (correlation !== null) {
    const part = h("span", { class: correlation < 0 ? "filled negative" : "filled" });
    const length = 50 * Math.min(Math.abs(correlation), 1);
    part.style.left = `${correlation < 0 ? 50 - length : 50}%`;
    part.style.width = `${length}%`;
    bar.append(part);
  }
  return h(
    "tr",
    {},
    h("th", { scope: "row" }, name, correlated ? " *" : ""),
    h("td", { "aria-hidden": "true" }, bar),
    h("td", {}, correlation === null ? "–" : digits(correlation, 2)),
    h("td", {}, first_order === null ? "–" : digits(first_order, 2)),
  );
}

/** What limits the meaning of the numbers. */
function notesOf(measure: Column, all: readonly Sensitivity[]): HTMLElement[] {
  const texts: string[] = [];
  const some = all.find(({ conditional }) => conditional);
  if (some) {
    const which = typeof some.pairs === "number" ? `the ${worldsText(some.pairs)}` : "worlds";
    texts.push(`These numbers are of ${which} in which ${measure.name} has a value.`);
  }
  if (all.some(({ correlated }) => correlated))
    texts.push("* correlated with another parameter, whose effect the numbers include.");
  return texts.map((text) => h("p", { class: "note" }, text));
}

/** Null if nothing is known about the measure. The greatest come first; the others are folded. */
export function sensitivities(explorer: Explorer, measure: Column): HTMLElement | null {
  const all = explorer.sweep.sensitivities.filter(
    ({ measure: name, correlation, first_order }) => name === measure.name && (correlation !== null || first_order !== null),
  );
  if (all.length === 0) return null;
  const sorted = [...all].sort((a, b) => size(b) - size(a));
  const body = h("tbody", {}, ...sorted.slice(0, most).map((each) => rowOf(explorer, measure, each)));
  const more = h("button", { type: "button", class: "link" }, `Show all ${sorted.length}`);
  more.addEventListener("click", () => {
    body.append(...sorted.slice(most).map((each) => rowOf(explorer, measure, each)));
    more.remove();
  });
  return h(
    "div",
    { class: "sensitivities" },
    h(
      "table",
      {},
      h("caption", { class: "hidden-text" }, `What ${measure.name} depends on`),
      h(
        "thead",
        {},
        h(
          "tr",
          {},
          h("th", { scope: "col" }, "depends on"),
          h("th", { scope: "col", title: "Spearman's rank correlation, from −1 to 1" }, "rank corr."),
          h("th", { scope: "col", title: "Share of the variance that this parameter alone explains" }, "1st order"),
        ),
      ),
      body,
    ),
    sorted.length > most && more,
    ...notesOf(measure, all),
  );
}
