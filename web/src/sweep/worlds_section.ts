// The table of worlds with its filters, and the file of what it shows.
import { h } from "../panels/dom";
import { Conditions } from "./conditions";
import { csvOf, save } from "./csv";
import type { Explorer } from "./explorer";
import { soon } from "./soon";
import { worldsText } from "./words";
import { WorldsTable } from "./worlds_table";

export function worldsSection(explorer: Explorer): HTMLElement {
  const table = new WorldsTable(explorer);
  const onlyMarked = h("input", { type: "checkbox" });
  const markedLabel = h("label", { class: "only-marked", hidden: true }, onlyMarked, " only marked");
  const status = h("p", { class: "note", role: "status" });
  const mark = h("button", { type: "button" }, "Mark these in the plots");
  const csv = h("button", { type: "button" }, "Save as CSV");
  const total = explorer.sweep.world.length;
  const show = () => {
    const { marked } = explorer;
    if (!marked) onlyMarked.checked = false;
    table.filter((row) => conditions.all.every(({ holds }) => holds(row)) && (!onlyMarked.checked || marked?.[row] === 1));
    const shown = table.rows.length;
    status.textContent = shown === total ? worldsText(total) : `${worldsText(shown)} of ${total}`;
    csv.disabled = shown === 0;
    mark.hidden = conditions.all.length === 0;
  };
  const conditions = new Conditions(explorer, show);
  onlyMarked.addEventListener("change", show);
  const followMarks = soon(() => {
    markedLabel.hidden = !explorer.marked;
    if (onlyMarked.checked) show();
  });
  explorer.listen((change) => change === "marked" && followMarks());
  mark.addEventListener("click", () => {
    const rows = new Set(table.rows);
    explorer.mark(conditions.all.map(({ text }) => text).join(", "), (row) => rows.has(row));
  });
  const stem = (explorer.sweep.file.split("/").pop() ?? "").replace(/\.toml$/, "") || "sweep";
  csv.addEventListener("click", () => save(`${stem}_worlds.csv`, csvOf(explorer.sweep, table.rows)));
  show();
  return h(
    "section",
    { "aria-labelledby": "worlds" },
    h("h2", { id: "worlds" }, "Worlds"),
    h("div", { class: "table-tools" }, conditions.element, markedLabel, mark, csv, status),
    table.element,
  );
}
