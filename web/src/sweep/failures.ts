// The worlds that failed, why, and how to run them again.
import { h } from "../panels/dom";
import { copyButton } from "./copy";
import type { Sweep } from "./document";
import type { Explorer } from "./explorer";
import { grouped, worldsText } from "./words";

function rowOf(explorer: Explorer, { world, why, replay }: Sweep["failures"][number]): HTMLElement {
  const name = h("button", { type: "button", class: "link", onclick: () => explorer.pick(world) }, `World ${world}`);
  return h(
    "tr",
    {},
    h("th", { scope: "row" }, name),
    h("td", { class: "why" }, why || "no reason is given"),
    h("td", {}, replay !== "" && copyButton(replay, `the command for world ${world}`)),
  );
}

/** Null if no world failed. */
export function failuresSection(explorer: Explorer): HTMLElement | null {
  const { failures, failed } = explorer.sweep;
  if (failed === 0 && failures.length === 0) return null;
  const more = failed - failures.length;
  const table = h(
    "table",
    { class: "failures" },
    h("caption", { class: "hidden-text" }, "Failed worlds"),
    h(
      "thead",
      {},
      h(
        "tr",
        {},
        h("th", { scope: "col" }, "World"),
        h("th", { scope: "col" }, "Reason"),
        h("th", { scope: "col" }, "Command"),
      ),
    ),
    h("tbody", {}, ...failures.map((failure) => rowOf(explorer, failure))),
  );
  return h(
    "section",
    { "aria-labelledby": "failures" },
    h("h2", { id: "failures" }, `${worldsText(failed)} failed`),
    failures.length > 0 && h("div", { class: "box scrolls", tabindex: 0, role: "group", "aria-label": "Failed worlds" }, table),
    more > 0 && h("p", { class: "note" }, `${grouped(more)} more ${more === 1 ? "is" : "are"} not listed here.`),
  );
}
