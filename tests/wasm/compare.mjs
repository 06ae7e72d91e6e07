// Runs scenarios in the module and by the command, and compares how they end: node compare.mjs PROGRAM MODULE FOLDER BOUND SCENARIO[:UNTIL:BOUND]…
// BOUND: "same bits", or the largest relative difference of a coordinate, velocity or momentum.
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, rmSync } from "node:fs";
import { basename } from "node:path";
import { Engine, jointSize } from "../../wasm/host.mjs";

const [program, modulePath, folder, bound, ...scenarios] = process.argv.slice(2);
const engine = await Engine.of(readFileSync(modulePath));
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
let failures = 0;

/** As the command steps: onto every row of its tables, and onto the end. */
function runAs(world, every, until) {
  while (world.time < until) {
    const next = (Math.floor((world.time / every) * (1 + 1e-12)) + 1) * every;
    const row = every > 0 ? Number(next.toPrecision(15)) : until;  // rows are at decimal instants
    const { status, message } = world.run(Math.min(row, until));
    if (status !== 0) throw new Error(message);
  }
}

/** The sign of a quaternion is arbitrary: files have the one with w ≥ 0. `units`: of the coordinates. */
const withPositiveW = (units, q) => {
  const w = units.indexOf("");
  return w >= 0 && q[w] < 0 ? q.map((x, i) => (i >= w ? -x : x)) : q;
};

for (const argument of scenarios) {
  const [path, given, own = bound] = argument.split(":");
  const name = basename(path, ".toml");
  const out = `${folder}/${name}`;
  const text = readFileSync(path, "utf8");
  // The scenarios of web/gallery name meshes as if they were in scenarios/.
  execFileSync(program, ["run", "-", "--quiet", "--out", out, ...(given ? ["--until", given] : [])], {
    cwd: new URL("../../scenarios", import.meta.url),
    input: text,
    stdio: ["pipe", "ignore", "ignore"],
  });
  const final = JSON.parse(readFileSync(`${out}/final.json`, "utf8"));
  const native = readFileSync(`${out}/events.jsonl`, "utf8").split("\n").filter(Boolean);

  const world = engine.world();
  const { scenario, diagnostics } = world.load(text);
  if (!scenario) throw new Error(`${path}: ${JSON.stringify(diagnostics)}`);
  runAs(world, scenario.every, given ? Number(given) : scenario.until);

  const topology = world.topology();
  const kinds = world.kinds();
  const rows = world.joints();
  let worst = 0;
  let numbers = 0;
  const compare = (mine, theirs, where) => {
    if (mine.length !== theirs.length) throw new Error(`${name}: ${where}: ${mine.length} numbers, not ${theirs.length}`);
    const size = Math.max(1e-3, ...theirs.map(Math.abs));
    mine.forEach((x, i) => {
      numbers++;
      if (x !== theirs[i]) worst = Math.max(worst, Math.abs(x - theirs[i]) / size || Number.MIN_VALUE);
    });
  };
  for (const { row: place, name: joint, kind, loop } of topology.joints) {
    const row = [...rows.subarray(jointSize * place, jointSize * (place + 1))];
    const theirs = final.joints[joint];
    if (!theirs || theirs.kind !== kind) throw new Error(`${name}: joint ${joint} is another`);
    compare(withPositiveW(kinds[kind].q, row.slice(2, 2 + row[0])), theirs.q, joint);
    compare(row.slice(9, 9 + row[1]), theirs.v, joint);
    if (!loop) compare(row.slice(15, 15 + row[1]), theirs.p, joint);
  }
  const names = (list) => list.map((mechanism) => mechanism.name).join();
  const events = world.events();
  const good =
    topology.joints.length === Object.keys(final.joints).length &&
    names(topology.mechanisms) === names(final.mechanisms) &&
    world.time === final.time &&
    events.length === native.length &&
    events.every((event, i) => event.event === JSON.parse(native[i]).event) &&
    worst <= (own === "same bits" ? 0 : Number(own));
  if (!good) failures++;
  const told = worst === 0 ? "the same bits" : `within ${worst.toExponential(1)}`;
  console.log(`${good ? "ok" : "FAILED"}: ${name} at ${world.time} s: ${numbers} numbers ${told}, ${events.length} events`);
  world.destroy();
}
process.exit(failures ? 1 : 0);
