// A sweep in closed form, as a document of the page: a pendulum of random length and strength is released from rest at a
// random angle; where the force in its rod exceeds the strength, the bob comes off and flies on.
import { writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { join } from "node:path";
import type { ColumnDocument, SweepDocument } from "../src/sweep/document";

const gravity = 9.81;
const pivot = 2.5;

/** Uniform in [0, 1), always the same for a seed (splitmix32). */
function uniform(seed: number): () => number {
  let state = seed | 0;
  return () => {
    state = (state + 0x9e3779b9) | 0;
    let z = state ^ (state >>> 16);
    z = Math.imul(z, 0x21f0aaad);
    z = Math.imul(z ^ (z >>> 15), 0x735a2d97);
    return ((z ^ (z >>> 15)) >>> 0) / 2 ** 32;
  };
}

export interface Outcome {
  readonly broke: boolean;
  /** Largest force in the rod of a bob of 1 kg (N). */
  readonly load: number;
  /** When and how fast it comes off (s, m/s), and where it lands (m). */
  readonly when: number | null;
  readonly speed: number | null;
  readonly lands: number | null;
  readonly end: string;
}

/** The elliptic integral of the first kind from `from` to π/2, by Simpson's rule. */
function elliptic(from: number, k: number): number {
  const n = 200;
  const step = (Math.PI / 2 - from) / n;
  let sum = 0;
  for (let i = 0; i <= n; i++)
    sum += (i === 0 || i === n ? 1 : i % 2 ? 4 : 2) / Math.sqrt(1 - (k * Math.sin(from + i * step)) ** 2);
  return (sum * step) / 3;
}

/** `angle` from the vertical (rad). The force in the rod is m g (3 cos θ − 2 cos θ₀). */
export function pendulum(strength: number, angle: number, length: number): Outcome {
  const greatest = gravity * (3 - 2 * Math.cos(angle));
  const cosine = (strength / gravity + 2 * Math.cos(angle)) / 3;
  if (greatest <= strength) return { broke: false, load: greatest, when: null, speed: null, lands: null, end: "swings on" };
  const at = Math.acos(cosine);
  const k = Math.sin(angle / 2);
  const when = Math.sqrt(length / gravity) * elliptic(Math.asin(Math.sin(at / 2) / k), k);
  const speed = Math.sqrt(2 * gravity * length * (cosine - Math.cos(angle)));
  const down = speed * Math.sin(at);
  const falls = (Math.sqrt(down ** 2 + 2 * gravity * (pivot - length * cosine)) - down) / gravity;
  const lands = length * Math.sin(at) - speed * cosine * falls;
  return { broke: true, load: strength, when, speed, lands, end: lands < -0.8 ? "lands outside" : "lands inside" };
}

type Cell = number | boolean | string | null;

/** The shares x with (share − x)² = z² x (1 − x) / count. */
function scoreInterval(share: number, count: number): [number, number] {
  const square = 1.959964 ** 2 / count;
  const half = Math.sqrt((2 * share + square) ** 2 - 4 * (1 + square) * share ** 2);
  const root = (sign: number) => (2 * share + square + sign * half) / (2 * (1 + square));
  return [Math.max(root(-1), 0), Math.min(root(1), 1)];
}

function statistics(cells: readonly Cell[], kind: string, bins: number): Partial<ColumnDocument> {
  const present = cells.flatMap((cell, world) => (cell === null ? [] : [{ world, value: Number(cell) }]));
  const count = present.length;
  const all = { count, missing: cells.length - count };
  if (kind === "text" || count === 0) return all;
  const mean = present.reduce((sum, { value }) => sum + value / count, 0);
  if (kind === "flag") {
    return { ...all, share: mean, interval: scoreInterval(mean, count) };
  }
  const deviation = Math.sqrt(present.reduce((sum, { value }) => sum + (value - mean) ** 2, 0) / Math.max(count - 1, 1));
  const sorted = [...present].sort((a, b) => a.value - b.value);
  const [least, greatest] = [sorted[0], sorted[count - 1]];
  const probabilities = [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99];
  const quantiles = Object.fromEntries(probabilities.map((p) => [String(p), sorted[Math.round(p * (count - 1))].value]));
  const width = (greatest.value - least.value) / bins;
  const counts = Array.from({ length: bins }, () => 0);
  for (const { value } of present) counts[width > 0 ? Math.min(Math.floor((value - least.value) / width), bins - 1) : 0]++;
  return {
    ...all,
    mean,
    deviation,
    least: least.value,
    greatest: greatest.value,
    least_world: least.world,
    greatest_world: greatest.world,
    quantiles,
    histogram: { from: least.value, to: greatest.value, counts },
  };
}

const ranks = (values: readonly number[]) => {
  const order = values.map((_value, i) => i).sort((a, b) => values[a] - values[b]);
  const result = new Array<number>(values.length);
  order.forEach((i, rank) => (result[i] = rank));
  return result;
};

function correlation(a: readonly number[], b: readonly number[]): number {
  const mean = (a.length - 1) / 2;
  let [ab, aa] = [0, 0];
  a.forEach((rank, i) => {
    ab += (rank - mean) * (b[i] - mean);
    aa += (rank - mean) ** 2;
  });
  return ab / aa;
}

/** The share of the variance between groups of similar x. */
function firstOrder(x: readonly number[], y: readonly number[], groups = 16): number {
  const mean = y.reduce((sum, value) => sum + value / y.length, 0);
  const total = y.reduce((sum, value) => sum + (value - mean) ** 2, 0);
  const sums = Array.from({ length: groups }, () => ({ sum: 0, count: 0 }));
  ranks(x).forEach((rank, i) => {
    const group = sums[Math.floor((rank * groups) / y.length)];
    group.sum += y[i];
    group.count++;
  });
  return sums.reduce((sum, group) => sum + (group.count ? group.count * (group.sum / group.count - mean) ** 2 : 0), 0) / total;
}

export interface Options {
  readonly worlds?: number;
  readonly seed?: number;
  /** Worlds that fail. */
  readonly failing?: readonly number[];
  /** Worlds with an animation. */
  readonly animated?: readonly number[];
}

export function pendulumSweep({ worlds = 600, seed = 7, failing = [118, 431], animated = [] }: Options = {}): SweepDocument {
  const random = uniform(seed);
  const names = {
    strength: "event.snap.when.exceeds",
    angle: "mechanism.pendulum.body.bob.joint.q",
    length: "mechanism.pendulum.body.bob.com",
    drag: "mechanism.pendulum.body.bob.drag",
  };
  const values: Record<string, Cell[]> = { world: [] };
  const columns: { name: string; role: "vary" | "measure"; kind: "number" | "flag" | "text"; about: string; unit: string }[] = [
    { name: names.strength, role: "vary", kind: "number", about: "uniform 8 to 24", unit: "N" },
    { name: names.angle, role: "vary", kind: "number", about: "uniform 40 deg to 90 deg", unit: "deg" },
    { name: names.length, role: "vary", kind: "number", about: "uniform 0.8 to 1.2", unit: "m" },
    { name: names.drag, role: "vary", kind: "number", about: "lognormal, median 0.1", unit: "" },
    { name: "broke", role: "measure", kind: "flag", about: "whether event snap happened", unit: "" },
    { name: "when", role: "measure", kind: "number", about: "time of event snap", unit: "s" },
    { name: "load", role: "measure", kind: "number", about: "greatest force of the joint pendulum/bob", unit: "N" },
    { name: "speed", role: "measure", kind: "number", about: "speed of the bob when it comes off", unit: "m/s" },
    { name: "lands", role: "measure", kind: "number", about: "where the bob lands", unit: "m" },
    { name: "end", role: "measure", kind: "text", about: "what becomes of the bob", unit: "" },
  ];
  for (const { name } of columns) values[name] = [];
  for (let world = 0; world < worlds; world++) {
    const strength = 8 + 16 * random();
    const angle = 40 + 50 * random();
    const length = 0.8 + 0.4 * random();
    const drag = 0.1 * Math.exp(0.5 * (random() + random() + random() + random() - 2));
    const failed = failing.includes(world);
    const outcome = pendulum(strength, (angle * Math.PI) / 180, length);
    values.world.push(world);
    values[names.strength].push(strength);
    values[names.angle].push(angle);
    values[names.length].push(length);
    values[names.drag].push(drag);
    for (const key of ["broke", "when", "load", "speed", "lands", "end"] as const)
      values[key].push(failed ? null : outcome[key]);
  }
  const replay = (world: number) => `momentree sweep pendulum_sweep.toml --world ${world}`;
  const known = (measure: string) => values.world.map(Number).filter((world) => values[measure][world] !== null);
  const sensitivities = columns
    .filter(({ role, kind }) => role === "measure" && kind !== "text")
    .flatMap(({ name: measure }) =>
      Object.values(names).map((vary) => {
        const rows = known(measure);
        const [x, y] = [rows.map((row) => Number(values[vary][row])), rows.map((row) => Number(values[measure][row]))];
        const some = rows.length > 1 && y.some((value) => value !== y[0]);
        return {
          measure,
          vary,
          correlation: some ? correlation(ranks(x), ranks(y)) : null,
          first_order: some && rows.length > 100 ? firstOrder(x, y) : null,
        };
      }),
    );
  const worst = (measure: string, end: "greatest" | "least") => ({
    measure,
    end,
    worlds: known(measure)
      .sort((a, b) => (end === "greatest" ? -1 : 1) * (Number(values[measure][a]) - Number(values[measure][b])))
      .slice(0, 5)
      .map((world) => ({
        world,
        value: Number(values[measure][world]),
        replay: replay(world),
        animation: animated.includes(world) ? `worlds/${world}/report.html` : null,
      })),
  });
  const failed = failing.filter((world) => world < worlds);
  return {
    format: 1,
    program: { name: "momentree", version: "0.1.0" },
    title: "A pendulum of uncertain strength",
    sweep: "pendulum_sweep.toml",
    scenario: "pendulum.toml",
    seed,
    worlds,
    done: worlds - failed.length,
    failed: failed.length,
    shown: worlds,
    columns: columns.map((column) => ({ ...column, ...statistics(values[column.name], column.kind, 30) })),
    sensitivities,
    values,
    failures: failed.map((world) => ({
      world,
      why: "diverged at t = 0.412 s: joint 'pendulum/bob': reduce integrate.step, or choose method = \"dopri5\"",
      replay: replay(world),
    })),
    failures_listed: failed.length,
    worst: [worst("load", "greatest"), worst("lands", "least"), worst("speed", "greatest")],
  };
}

const page = new URL("../dist/sweep.html", import.meta.url);

/** Writes the built page with these data; its file. `data` may be any text, also none that can be read. */
export function sweepPage(folder: string, html: string, data: SweepDocument | string): string {
  const text = (typeof data === "string" ? data : JSON.stringify(data)).replaceAll("<", "\\u003c");
  const file = join(folder, "report.html");
  writeFileSync(
    file,
    html.replace(/(id="sweep">)(<)/, (_all, begin: string, end: string) => begin + text + end),
  );
  return file;
}
export const builtPage = fileURLToPath(page);
