// Conditions on columns, which filter the table of worlds, and the form that adds them.
import { h } from "../panels/dom";
import { columnChoice } from "./column_choice";
import type { Column, Kind } from "./document";
import type { Explorer } from "./explorer";

type Test = (column: Column, value: number, given: string) => boolean;

interface Relation {
  readonly name: string;
  readonly needs: "number" | "text" | null;
  readonly holds: Test;
}

const missing: readonly Relation[] = [
  { name: "has no value", needs: null, holds: (_column, value) => Number.isNaN(value) },
  { name: "has a value", needs: null, holds: (_column, value) => !Number.isNaN(value) },
];
export const relations: Readonly<Record<Kind, readonly Relation[]>> = {
  number: [
    { name: "≥", needs: "number", holds: (_column, value, given) => value >= Number(given) },
    { name: "≤", needs: "number", holds: (_column, value, given) => value <= Number(given) },
    { name: "=", needs: "number", holds: (_column, value, given) => value === Number(given) },
    ...missing,
  ],
  flag: [
    { name: "is yes", needs: null, holds: (_column, value) => value === 1 },
    { name: "is no", needs: null, holds: (_column, value) => value === 0 },
    ...missing,
  ],
  text: [
    {
      name: "contains",
      needs: "text",
      holds: ({ labels }, value, given) => (labels[value] ?? "").toLowerCase().includes(given.toLowerCase()),
    },
    ...missing,
  ],
};

export interface Condition {
  readonly text: string;
  readonly holds: (row: number) => boolean;
}

/** Null if it needs a number and none was given. */
export function conditionOf(column: Column, { name, needs, holds }: Relation, given: string): Condition | null {
  const bare = given.trim().replace("−", "-");
  if (needs === "number" && (bare === "" || !Number.isFinite(Number(bare)))) return null;
  const text = needs ? `${column.name} ${name} ${given.trim()}` : `${column.name} ${name}`;
  return { text, holds: (row) => holds(column, column.values[row], bare) };
}

export class Conditions {
  readonly element: HTMLElement;
  readonly all: Condition[] = [];
  private readonly chips = h("ul", { class: "chips", "aria-label": "Conditions" });
  private readonly message = h("span", { class: "note", role: "alert" });

  constructor(
    explorer: Explorer,
    private readonly changed: () => void,
  ) {
    const { columns } = explorer.sweep;
    const choice = columnChoice(
      "Column of the condition",
      columns,
      columns.find(({ role }) => role === "measure") ?? columns[0],
    );
    const relation = h("select", { "aria-label": "Relation" });
    const value = h("input", { type: "text", size: 8, "aria-label": "Value", autocomplete: "off" });
    const chosen = () => explorer.column(choice.value)!;
    const related = () => relations[chosen().kind].find(({ name }) => name === relation.value)!;
    const fill = () => {
      relation.replaceChildren(...relations[chosen().kind].map(({ name }) => h("option", {}, name)));
      value.hidden = related().needs === null;
    };
    choice.addEventListener("change", fill);
    relation.addEventListener("change", () => (value.hidden = related().needs === null));
    fill();
    const add = (event: Event) => {
      event.preventDefault();
      const condition = conditionOf(chosen(), related(), value.value);
      this.message.textContent = condition ? "" : "Give a number, as in 2.5.";
      if (!condition) return void value.focus();
      value.value = "";
      this.add(condition);
    };
    const form = h("form", { class: "filter" }, choice, relation, value, h("button", { type: "submit" }, "Add filter"));
    form.addEventListener("submit", add);
    this.element = h("div", { class: "conditions" }, form, this.message, this.chips);
  }

  private add(condition: Condition) {
    this.all.push(condition);
    const remove = h("button", { type: "button", "aria-label": `Remove the filter ${condition.text}` }, "×");
    const chip = h("li", {}, condition.text, remove);
    remove.addEventListener("click", () => {
      this.all.splice(this.all.indexOf(condition), 1);
      chip.remove();
      this.changed();
    });
    this.chips.append(chip);
    this.changed();
  }
}
