import { load, motionSize, status, type Outcome, type Topology, type World, type WorldTotals } from "momentree";

const engine = await load({ log: (text) => console.error(text) });
const world: World = engine.world();
const { scenario, diagnostics } = world.load("format = 1\n");
const lines: number[] = diagnostics.map(({ line }) => line);
const step: number | undefined = scenario?.step;
const topology: Topology = world.topology();
for (const joint of topology.joints) {
  const done: Outcome = world.act({ break: joint.name });
  if (done.status === status.refused) console.log(done.message, lines, step);
}
const totals: WorldTotals = world.totals();
const x: number = totals.linear[0] + world.motions()[motionSize * 1]!;
console.log(x);
