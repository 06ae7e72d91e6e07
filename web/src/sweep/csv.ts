// Worlds as comma-separated values (RFC 4180), as other programs read them.
import type { Column, Sweep } from "./document";

const cell = (text: string) => (/[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

function valueOf({ kind, values, labels }: Column, row: number): string {
  const value = values[row];
  if (!Number.isFinite(value)) return "";
  return kind === "number" ? String(value) : kind === "flag" ? String(value === 1) : cell(labels[value]);
}

/** These rows with all columns; missing values are empty. */
export function csvOf({ world, columns }: Sweep, rows: ArrayLike<number>): string {
  const lines = [["world", ...columns.map(({ name }) => cell(name))].join(",")];
  for (let i = 0; i < rows.length; i++)
    lines.push([String(world[rows[i]]), ...columns.map((column) => valueOf(column, rows[i]))].join(","));
  return `${lines.join("\n")}\n`;
}

export function save(name: string, text: string) {
  const address = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
