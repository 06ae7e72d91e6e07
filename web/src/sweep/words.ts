// Values, shares and names as the page shows them.
import { digits } from "../panels/numbers";
import type { Column } from "./document";

/** "12.4 N", "yes", "–" if it is missing. */
export function valueText(column: Column, value: number, precision = 6): string {
  if (!Number.isFinite(value)) return "–";
  if (column.kind !== "number") return column.labels[value] ?? "–";
  return `${digits(value, precision)}${column.unit ? ` ${column.unit}` : ""}`;
}

/** "86.1 %". */
export const percent = (share: number): string => (Number.isFinite(share) ? `${digits(100 * share, 3)} %` : "–");

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
