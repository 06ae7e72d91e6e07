// How the run was computed: times as in Table 2 of the paper, the energy balance, where it came from.
import type { Recording, Summary } from "../recording";
import { h, table } from "./dom";
import { count, digits, duration } from "./numbers";

/** Rows of the paper's Table 2: evaluations and all, before the first change, for changes, after it, and together. */
export function timesTable(summary: Summary): string[][] {
  const times = summary.times;
  if (!times) return [];
  const { evaluations, topology, total } = times;
  const all = ["Whole simulation", duration(evaluations.before + evaluations.after), duration(total.before + total.after)];
  if (summary.changes === 0) return [all];
  const changes = topology.before + topology.after;
  return [
    all,
    ["Before the first change", duration(evaluations.before), duration(total.before)],
    [summary.changes === 1 ? "Topology change" : `Topology changes (${summary.changes})`, duration(changes), duration(changes)],
    ["After it", duration(evaluations.after), duration(total.after - changes)],
  ];
}

const energyNames: Record<string, string> = {
  initial: "at the start",
  final: "at the end",
  dissipated: "dissipated",
  work: "work done on it",
  lost_in_impacts: "lost in impacts",
  released: "released by changes",
  error: "error of the balance",
};

export function energyTable(summary: Summary): string[][] {
  const all = Object.entries(summary.energy ?? {});
  // What is round-off beside the others is nothing.
  const least = 1e-14 * Math.max(0, ...all.map(([, value]) => Math.abs(value ?? 0)));
  return all
    .filter(([key, value]) => key === "error" || value === null || Math.abs(value) > least)
    .map(([key, value]) => [energyNames[key] ?? key, value === null ? "–" : `${digits(value, key === "error" ? 3 : 7)} J`]);
}

export function summaryPanel(run: Recording): HTMLElement {
  const summary = run.summary;
  if (!summary) return h("p", { class: "nothing" }, "The run left no summary.");
  const times = timesTable(summary);
  const energy = energyTable(summary);
  const facts: string[][] = [
    ["status", summary.status],
    ["method", summary.step > 0 ? `${summary.method}, step ${duration(summary.step)}` : summary.method],
    ["steps", `${summary.steps}, ${count(summary.evaluations, "evaluation", "evaluations")}`],
    ...(summary.realTimeFactor === null ? [] : [["pace", `${digits(summary.realTimeFactor, 3)} times real time`]]),
    ["momentree", summary.version],
  ];
  return h(
    "div",
    { class: "summary" },
    times.length > 0 && table("Processing times", ["", "function evaluations", "total"], times),
    energy.length > 0 && table("Energy balance", ["", "energy"], energy),
    table("The run", ["", ""], facts),
  );
}
