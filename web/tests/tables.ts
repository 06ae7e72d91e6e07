// Tables of results, read by the tests on their own.
import { readFileSync } from "node:fs";
import { join } from "node:path";

export type Row = Record<string, number>;

export function csv(folder: string, file: string): Row[] {
  const [head, ...lines] = readFileSync(join(folder, file), "utf8").trim().split("\n");
  const names = head.split(",");
  return lines.map((line) => {
    const cells = line.split(",");
    return Object.fromEntries(names.map((name, i) => [name, cells[i] === "" ? Number.NaN : Number(cells[i])]));
  });
}
