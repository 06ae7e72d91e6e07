// How the run was computed: times as in Table 2 of the paper, the energy balance, the method.
import type { Missed, Recording, Summary } from "../recording";
import { h, table } from "./dom";
import { count, digits, duration } from "./numbers";

/**
 * Rows of the paper's Table 2: evaluations and total times for the whole run, before the first change, for changes, and
 * after it.
 */
export function timesTable(summary: Summary): string[][] {
  const times = summary.wall_clock;
  if (!times) return [];
  const { evaluations, topology, total } = times;
  const all = ["Whole simulation", duration(evaluations.before + evaluations.after), duration(total.before + total.after)];
  if (!summary.topology_changes) return [all];
  const changes = topology.before + topology.after;
  return [
    all,
    ["Before the first change", duration(evaluations.before), duration(total.before)],
    [
      summary.topology_changes === 1 ? "Topology change" : `Topology changes (${summary.topology_changes})`,
      duration(changes),
      duration(changes),
    ],
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
  projection: "by closing loops and removing overlaps",
  error: "error of the balance",
  largest_kinetic: "largest kinetic energy",
};

export function energyTable(summary: Summary): string[][] {
  const all = Object.entries(summary.energy ?? {});
  // Energies that are only round-off compared with the others are omitted.
  const least = 1e-14 * Math.max(0, ...all.map(([, value]) => Math.abs(value ?? 0)));
  return all
    .filter(([key, value]) => key === "error" || value === null || Math.abs(value) > least)
    .map(([key, value]) => [energyNames[key] ?? key, value === null ? "–" : `${digits(value, key === "error" ? 3 : 7)} J`]);
}

/** An event that did not happen, and why: "position exceeds 20", "nearest: 12.8 at 2 s". */
export function missedRow(missed: Missed): string[] {
  if (missed.quantity !== undefined) {
    const [side, threshold] = missed.exceeds !== undefined ? ["exceeds", missed.exceeds] : ["below", missed.below ?? 0];
    const of = missed.of?.length ? ` of ${missed.of.join(" and ")}` : "";
    const condition = `${missed.quantity}${of} ${side} ${digits(threshold, 6)}`;
    if (missed.nearest == null) return [missed.event, condition, "there was nothing to measure"];
    const held = missed.for === undefined ? "" : `, held for ${duration(missed.held ?? 0)} of ${duration(missed.for)}`;
    return [
      missed.event,
      condition,
      `nearest: ${digits(missed.nearest, 6)} at ${digits(missed.nearest_time ?? 0, 6)} s${held}`,
    ];
  }
  if (missed.after !== undefined) return [missed.event, `after ${missed.after}`, "that did not happen"];
  return [missed.event, `at ${digits(missed.time ?? 0, 6)} s`, "the run ended before"];
}

export function summaryPanel(run: Recording): HTMLElement {
  const summary = run.summary;
  if (!summary) return h("p", { class: "nothing" }, "The run has no summary.");
  const times = timesTable(summary);
  const energy = energyTable(summary);
  const missed = summary.missed ?? [];
  const facts: string[][] = [
    ["status", summary.status],
    ["method", summary.step ? `${summary.method}, step ${duration(summary.step)}` : (summary.method ?? "")],
    ["steps", `${summary.steps ?? 0}, ${count(summary.evaluations ?? 0, "evaluation", "evaluations")}`],
    ...(summary.real_time_factor == null ? [] : [["speed", `${digits(summary.real_time_factor, 3)} times real time`]]),
    ["momentree", summary.version ?? ""],
  ];
  return h(
    "div",
    { class: "summary" },
    times.length > 0 && table("Processing times", ["", "function evaluations", "total"], times),
    energy.length > 0 && table("Energy balance", ["", "energy"], energy),
    missed.length > 0 && table("Events that did not happen", ["", "condition", ""], missed.map(missedRow)),
    table("The run", ["", ""], facts),
  );
}
