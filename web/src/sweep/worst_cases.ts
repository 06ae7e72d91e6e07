// The worst worlds of measures, with their animations.
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import { copyButton } from "./copy";
import type { Worst, WorstWorld } from "./document";
import type { Explorer } from "./explorer";

function rowOf(explorer: Explorer, { world, value, replay, animation }: WorstWorld, unit: string): HTMLElement {
  const pick = h("button", { type: "button", class: "link", onclick: () => explorer.pick(world) }, `World ${world}`);
  return h(
    "tr",
    { "data-world": world },
    h("th", { scope: "row" }, pick),
    h("td", {}, value === null ? "–" : `${digits(value, 6)}${unit ? ` ${unit}` : ""}`),
    h("td", {}, animation !== null && h("a", { href: animation, "aria-label": `Animation of world ${world}` }, "▶ Animation")),
    h("td", {}, replay !== "" && copyButton(replay, `the command for world ${world}`)),
  );
}

function listOf(explorer: Explorer, { measure, end, worlds }: Worst): HTMLElement {
  const unit = explorer.column(measure)?.unit ?? "";
  const headings = ["World", "Value", "Animation", "Command"].map((text) => h("th", { scope: "col" }, text));
  return h(
    "article",
    { class: "box card" },
    h("h3", {}, measure, h("span", { class: "unit" }, ` ${end}`)),
    h(
      "table",
      { class: "worst" },
      h("caption", { class: "hidden-text" }, `Worlds with the ${end} ${measure}`),
      h("thead", { class: "hidden-text" }, h("tr", {}, ...headings)),
      h("tbody", {}, ...worlds.map((each) => rowOf(explorer, each, unit))),
    ),
  );
}

/** Null if the document has none. */
export function worstSection(explorer: Explorer): HTMLElement | null {
  const lists = explorer.sweep.worst.filter(({ worlds }) => worlds.length > 0);
  if (lists.length === 0) return null;
  const section = h(
    "section",
    { "aria-labelledby": "worst" },
    h("h2", { id: "worst" }, "Worst cases"),
    h("div", { class: "cards" }, ...lists.map((each) => listOf(explorer, each))),
  );
  const follow = () => {
    for (const row of section.querySelectorAll<HTMLElement>("tr[data-world]"))
      row.classList.toggle("picked", Number(row.dataset.world) === explorer.picked);
  };
  explorer.listen((change) => change === "picked" && follow());
  follow();
  return section;
}
