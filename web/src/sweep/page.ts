// The page of a sweep: failures, distributions, a scatter plot, worst cases, and the table of worlds; the picked world
// is beside them.
import { h } from "../panels/dom";
import { helpButton } from "../panels/help";
import { themeButton } from "../panels/theme_button";
import { card } from "./cards";
import type { Column, Role, Sweep } from "./document";
import { Explorer } from "./explorer";
import { failuresSection } from "./failures";
import { firstAxes } from "./plots/first_axes";
import { about, sections as helpSections } from "./help";
import { Scatter } from "./plots/scatter";
import { grouped, worldsText } from "./words";
import { worldsSection } from "./worlds_section";
import { worstSection } from "./worst_cases";
import { WorldPanel } from "./world_panel";

/** With more cards than these, varied parameters are folded. */
const mostUnfolded = 6;

function header(sweep: Sweep): HTMLElement {
  const title = sweep.title || sweep.file || "A sweep";
  document.title = `${title} – momentree`;
  const parts = [
    worldsText(sweep.worlds),
    `${grouped(sweep.done)} done`,
    sweep.failed > 0 && `${grouped(sweep.failed)} failed`,
    sweep.scenario && sweep.file && `${sweep.scenario} varied by ${sweep.file}`,
    sweep.seed !== null && `seed ${sweep.seed}`,
    sweep.version && `momentree ${sweep.version}`,
  ].filter(Boolean);
  return h(
    "header",
    {},
    h("h1", {}, title),
    h("p", {}, parts.join(" · ")),
    helpButton(about, helpSections),
    themeButton(),
    ...statusOf(sweep),
  );
}

/** What the reader must know about the numbers. */
function statusOf({ worlds, done, failed, world, accepted }: Sweep): HTMLElement[] {
  const notes: HTMLElement[] = [];
  const left = worlds - done - failed;
  const say = (strong: string, text: string, role: string) =>
    notes.push(h("p", { class: "status", role }, h("strong", {}, strong), text));
  if (worlds > 0 && failed >= worlds) say("All worlds failed. ", "The reasons are below.", "alert");
  if (left > 0) say("This sweep is not complete: ", `${worldsText(left)} ${left === 1 ? "is" : "are"} left to run.`, "alert");
  if (accepted.length > 0)
    say(
      "Changes were accepted: ",
      "some worlds were computed before the sweep, its files or momentree changed (--accept-changes).",
      "alert",
    );
  if (world.length > 0 && world.length < done)
    notes.push(
      h(
        "p",
        { class: "status" },
        `The plot, the table and marks have a random sample of ${worldsText(world.length)}; ` +
          "counts, means and extremes are of all.",
      ),
    );
  return notes;
}

function cardsSection(explorer: Explorer, role: Role, title: string): HTMLElement | null {
  const columns = explorer.sweep.columns.filter((column) => column.role === role);
  if (columns.length === 0) return null;
  const cards = h("div", { class: "cards" }, ...columns.map((column) => card(explorer, column)));
  const heading = h("h2", { id: role }, title);
  const folded = role === "vary" && columns.length > mostUnfolded;
  return h(
    "section",
    { "aria-labelledby": role },
    ...(folded
      ? [h("details", {}, h("summary", {}, heading, ` ${columns.length} parameters`), cards)]
      : [heading, role === "measure" && h("p", { class: "note" }, measuresHint), cards]),
  );
}

const measuresHint =
  "Below a histogram: box 25 % to 75 %, line 5 % to 95 %, bar at the median, point at the mean. " +
  "Click a bin, or drag over bins, to mark worlds in all plots.";

function scatterSection(explorer: Explorer, colour: Column | null): HTMLElement {
  return h(
    "section",
    { "aria-labelledby": "relations" },
    h("h2", { id: "relations" }, "Relations"),
    h("p", { class: "note" }, "Click a point to pick its world. Drag with a mouse or pen to mark worlds."),
    new Scatter(explorer, colour).element,
  );
}

/** What is marked, with a button that clears it. */
function markedBar(explorer: Explorer): HTMLElement {
  const text = h("span", { role: "status" });
  const clear = h("button", { type: "button", onclick: () => explorer.clearMarks() }, "Clear");
  const bar = h("div", { class: "marked-bar", hidden: true }, text, clear);
  explorer.listen((change) => {
    if (change !== "marked") return;
    bar.hidden = !explorer.marked;
    text.textContent = explorer.marked ? `${worldsText(explorer.markedCount)} marked: ${explorer.markedAs}` : "";
  });
  return bar;
}

/** `#world=401` picks that world; otherwise, where there is room beside the page, the first of the worst is picked. */
function firstPick(explorer: Explorer): number | null {
  const given = /^#world=(\d+)$/.exec(location.hash);
  if (given) return Number(given[1]);
  const worst = explorer.sweep.worst.find(({ worlds }) => worlds.length > 0);
  return worst && window.matchMedia("(min-width: 1100px)").matches ? worst.worlds[0].world : null;
}

export function showSweep(page: HTMLElement, sweep: Sweep) {
  const explorer = new Explorer(sweep);
  const { x, y, colour } = firstAxes(sweep);
  explorer.x = x;
  explorer.y = y;
  const some = sweep.world.length > 0;
  const sections = [
    failuresSection(explorer),
    sweep.worlds === 0 && !some && h("p", { class: "nothing" }, "This sweep has no worlds."),
    cardsSection(explorer, "measure", "Measures"),
    some && x && y && scatterSection(explorer, colour),
    worstSection(explorer),
    cardsSection(explorer, "vary", "Varied parameters"),
    some && sweep.columns.length > 0 && worldsSection(explorer),
  ];
  const content = h("div", { class: "sections" }, ...sections.map((section) => section || null));
  page.append(header(sweep), h("div", { class: "beside" }, content, new WorldPanel(explorer).element), markedBar(explorer));
  const pick = firstPick(explorer);
  if (pick !== null) explorer.pick(pick);
}
