// Reads the document of a sweep. What is wrong with it is an error that names the place.
import { readColumn } from "./read_column";
import type { Column, Failure, Sensitivity, Sweep, Worst, WorstWorld } from "./document";
import { fail, items, list, numberOr, oneOf, record, textOr, type Json } from "./json";

/** Null stands for a number that is absent. */
const optionalNumber = (value: Json, key: string, where: string): number | null => {
  const number = numberOr(value, key, where, NaN);
  return Number.isNaN(number) ? null : number;
};

function worldOf(value: Json, where: string): number {
  const world = numberOr(value, "world", where, NaN);
  if (!Number.isSafeInteger(world) || world < 0) fail(`${where}.world`, "is not the number of a world");
  return world;
}

const failureOf = (value: Json, where: string): Failure => ({
  world: worldOf(value, where),
  why: textOr(value, "why", where, ""),
  replay: textOr(value, "replay", where, ""),
});

const sensitivityOf = (value: Json, where: string): Sensitivity => ({
  measure: textOr(value, "measure", where, ""),
  vary: textOr(value, "vary", where, ""),
  correlation: optionalNumber(value, "correlation", where),
  first_order: optionalNumber(value, "first_order", where),
  pairs: optionalNumber(value, "pairs", where),
  conditional: value.conditional === true,
  correlated: value.correlated === true,
});

/** A file beside the page or below it; null for any other address. */
export function relativePath(text: string): string | null {
  const parts = text.split("/");
  if (text === "" || /[:\\]/.test(parts[0]) || parts.some((part) => part === "" || part === "..")) return null;
  return parts.map(encodeURIComponent).join("/");
}

const worstWorldOf = (value: Json, where: string): WorstWorld => ({
  world: worldOf(value, where),
  value: optionalNumber(value, "value", where),
  replay: textOr(value, "replay", where, ""),
  animation: relativePath(textOr(value, "animation", where, "")),
});

const worstOf = (value: Json, where: string): Worst => ({
  measure: textOr(value, "measure", where, ""),
  end: oneOf(value, "end", where, ["greatest", "least"] as const, "greatest"),
  worlds: items(value.worlds, `${where}.worlds`, worstWorldOf),
});

function worldsOf(values: Json): Float64Array {
  const given = list(values.world, "values.world");
  given.forEach((world, row) => {
    if (!Number.isSafeInteger(world) || (world as number) < 0) fail(`values.world[${row}]`, "is not the number of a world");
  });
  return Float64Array.from(given as number[]);
}

function columnsOf(document: Json, values: Json, world: Float64Array): Column[] {
  const columns = items(document.columns, "columns", (value, where) => {
    const name = textOr(value, "name", where, "");
    if (name === "") fail(where, "has no name");
    const cells = list(values[name], `values["${name}"]`);
    if (cells.length !== world.length)
      fail(`values["${name}"]`, `has ${cells.length} entries, but there are ${world.length} worlds`);
    return readColumn(value, where, cells, world);
  });
  columns.forEach(({ name }, i) => {
    if (columns.findIndex((other) => other.name === name) !== i) fail(`columns[${i}]`, `has the same name as another: ${name}`);
  });
  return columns;
}

/** Throws an Error that says what is wrong with the document. */
export function sweepOf(document: unknown): Sweep {
  const sweep = record(document, "the document");
  if (sweep.format !== 1) fail("format", `is ${JSON.stringify(sweep.format) ?? "missing"}, but this page reads format 1`);
  const values = record(sweep.values, "values");
  // Without columns an empty sweep may leave out the worlds' numbers, too.
  const world =
    values.world === undefined && list(sweep.columns, "columns").length === 0 ? new Float64Array() : worldsOf(values);
  const where = "the document";
  const failures = items(sweep.failures ?? [], "failures", failureOf);
  const failed = numberOr(sweep, "failed", where, failures.length);
  return {
    title: textOr(sweep, "title", where, ""),
    version: sweep.program === undefined ? "" : textOr(record(sweep.program, "program"), "version", "program", ""),
    file: textOr(sweep, "sweep", where, ""),
    scenario: textOr(sweep, "scenario", where, ""),
    seed: optionalNumber(sweep, "seed", where),
    accepted: items(sweep.accepted_changes ?? [], "accepted_changes", (each, at) => textOr(each, "version", at, "")),
    worlds: numberOr(sweep, "worlds", where, world.length),
    done: numberOr(sweep, "done", where, Math.max(world.length - failed, 0)),
    failed,
    world,
    columns: columnsOf(sweep, values, world),
    sensitivities: items(sweep.sensitivities ?? [], "sensitivities", sensitivityOf),
    failures,
    worst: items(sweep.worst ?? [], "worst", worstOf),
  };
}
