// A choice of a column, grouped by its role.
import { h } from "../panels/dom";
import type { Column } from "./document";

/** `none`: the text of a first choice without a column. */
export function columnChoice(
  label: string,
  columns: readonly Column[],
  chosen: Column | null,
  none?: string,
): HTMLSelectElement {
  const select = h("select", { "aria-label": label });
  if (none !== undefined) select.append(h("option", { value: "" }, none));
  for (const [role, title] of [
    ["measure", "Measured"],
    ["vary", "Varied"],
  ]) {
    const some = columns.filter((column) => column.role === role);
    if (some.length > 0)
      select.append(h("optgroup", { label: title }, ...some.map(({ name }) => h("option", { value: name }, name))));
  }
  if (chosen) select.value = chosen.name;
  return select;
}
