// Values, shares and names as the page shows them.
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import type { Column } from "./document";

/** "12.4 N", "yes", "–" if it is missing. */
export function valueText(column: Column, value: number, precision = 6): string {
  if (!Number.isFinite(value)) return "–";
  if (column.kind !== "number") return column.labels[value] ?? "–";
  return `${digits(value, precision)}${column.unit ? ` ${column.unit}` : ""}`;
}

/** The same without the unit. */
export const cellText = (column: Column, value: number): string =>
  column.kind === "number" && Number.isFinite(value) ? digits(value, 6) : valueText(column, value);

/** "86.1 %". */
export function percent(share: number): string {
  if (!Number.isFinite(share)) return "–";
  const [value, rest] = [100 * share, 100 - 100 * share];
  if (value === 0 || rest === 0) return `${value} %`;
  return `${Math.min(value, rest) < 0.05 ? digits(value, value < 1 ? 2 : 6) : value.toFixed(1)} %`;
}

/** "1 world", "20 000 worlds". */
export const worldsText = (count: number): string => `${grouped(count)} ${count === 1 ? "world" : "worlds"}`;

/** Thin spaces between groups of three digits, from five digits on. */
export const grouped = (count: number): string =>
  count >= 10000 ? String(count).replace(/\B(?=(\d{3})+$)/g, "\u202f") : String(count);

/** A column's name and unit: "load (N)". */
export const titleOf = ({ name, unit }: Column): string => (unit ? `${name} (${unit})` : name);

/** A word of a shell command. */
export const quoted = (word: string): string => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

/** The command that runs one world again; empty if the document does not name the sweep. */
export const replayOf = (file: string, world: number): string =>
  file === "" ? "" : `momentree sweep ${quoted(file)} --world ${world}`;

/** A name that may break after its dots and underscores. */
export const breakable = (name: string): HTMLElement =>
  h("span", { class: "name" }, ...name.split(/(?<=[./_])/).flatMap((part, i) => (i === 0 ? [part] : [h("wbr"), part])));

/**
 * Dotted names for narrow places: of long ones the last parts, which tell them apart, after an ellipsis; whole where two would
 * look the same.
 */
export function shortened(names: readonly string[], most = 26): string[] {
  const short = names.map((name) => {
    if (name.length <= most) return name;
    const parts = name.split(/(?<=[./])/);
    let end = parts.pop() ?? "";
    while (parts.length > 0 && end.length + parts[parts.length - 1].length < most) end = parts.pop() + end;
    return parts.length > 0 ? `…${end}` : name;
  });
  return short.map((text, i) => (short.indexOf(text) === short.lastIndexOf(text) ? text : names[i]));
}
