// Sweeps that are unlike the usual: none of them may break the page.
import type { SweepDocument } from "../src/sweep/document";
import { pendulumSweep } from "./pendulum_sweep";

const worlds = (count: number) => Array.from({ length: count }, (_none, world) => world);
const name = (i: number) =>
  `mechanism.crane.body.segment_${i}.joint.limits.${"upper_".repeat(8)}bound`.padEnd(80, "x").slice(0, 80);

/** 40 columns with names of 80 characters. */
function manyColumns(): SweepDocument {
  const columns = worlds(40).map((i) => ({
    name: name(i),
    role: i < 20 ? ("vary" as const) : ("measure" as const),
    about: "",
  }));
  const values = Object.fromEntries(
    columns.map((column, i) => [column.name, worlds(50).map((world) => Math.sin(world * (i + 1)))]),
  );
  return {
    format: 1,
    title: `A sweep with ${"a_very_long_name_".repeat(8)}`,
    columns,
    values: { world: worlds(50), ...values },
    sensitivities: worlds(20).map((i) => ({ measure: name(20), vary: name(i), correlation: Math.cos(i), first_order: null })),
    failures: [{ world: 7, why: "x".repeat(300), replay: "momentree sweep long.toml --world 7" }],
  };
}

function allFailed(): SweepDocument {
  const failing = worlds(150);
  const data = pendulumSweep({ worlds: 150, failing });
  return { ...data, failures: data.failures!.slice(0, 100), failures_listed: 100, worst: [] };
}

function limited(): SweepDocument {
  const data = pendulumSweep();
  const limits = data.sensitivities!.map((each) => ({
    ...each,
    pairs: 451,
    conditional: each.measure === "lands",
    correlated: true,
  }));
  return { ...data, accepted_changes: [{ version: "0.1.0", hash: "0123456789abcdef" }], sensitivities: limits };
}

export const strangeSweeps: Record<string, { readonly data: SweepDocument; readonly says: readonly string[] }> = {
  nothing: { data: { format: 1, columns: [], values: {} }, says: ["This sweep has no worlds."] },
  no_worlds: {
    data: { ...pendulumSweep({ worlds: 0, failing: [] }), worst: [] },
    says: ["This sweep has no worlds.", "There are no worlds."],
  },
  one_world: { data: pendulumSweep({ worlds: 1, failing: [] }), says: ["22.2991 N in all worlds"] },
  all_failed: { data: allFailed(), says: ["All worlds failed.", "50 more are not listed here.", "No world has a value."] },
  constants: {
    data: {
      format: 1,
      columns: [
        { name: "zero", role: "vary", unit: "N" },
        { name: "large", role: "measure" },
        { name: "always", role: "measure", kind: "flag" },
        { name: "absent", role: "measure" },
      ],
      values: {
        world: worlds(30),
        zero: worlds(30).map(() => 0),
        large: worlds(30).map(() => 1.25e9),
        always: worlds(30).map(() => true),
        absent: worlds(30).map(() => null),
      },
    },
    says: ["1.25e9 in all worlds", "0 N in all worlds", "100 %", "No world has a value."],
  },
  limited: {
    data: limited(),
    says: [
      "Changes were accepted:",
      "These numbers are of the 451 worlds in which lands has a value.",
      "* correlated with another parameter",
    ],
  },
  many_columns: { data: manyColumns(), says: ["20 parameters"] },
  incomplete: {
    data: { ...pendulumSweep(), worlds: 1000, shown: 600 },
    says: ["This sweep is not complete:", "400 worlds are left to run."],
  },
  sample: {
    data: { ...pendulumSweep(), worlds: 1_000_000, done: 999_998 },
    says: ["have a random sample of 600 worlds"],
  },
};
