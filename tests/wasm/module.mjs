// What the module promises beside its numbers: node module.mjs MODULE
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { Engine, jointSize, status } from "../../wasm/host.mjs";

const bytes = readFileSync(process.argv[2]);
const engine = await Engine.of(bytes);
const chain = (links, extra = "") => `format = 1
[world]
gravity = [0, -9.81, 0]
[[mechanism]]
name = "chain"
[mechanism.chain]
links = ${links}
length = 0.2
mass = 0.1
inertia = 3e-4
damping = 1e-4
${extra}`;
const near = (a, b, bound = 1e-12) =>
  assert.ok(Math.abs(a - b) <= bound * Math.max(1, Math.abs(a), Math.abs(b)), `${a} and ${b}`);
const nearAll = (a, b, bound) => a.forEach((x, i) => near(x, b[i], bound));

// A scenario with errors says where and what, and leaves the world as it was.
const world = engine.world();
assert.equal(world.load(chain(6)).scenario.step, 1e-3);
const broken = world.load("format = 1\n[[mechanism]]\nname = 'm'\n[mechanism.chian]\nlinks = 3\n");
assert.equal(broken.scenario, null);
assert.ok(broken.diagnostics.some(({ line, hint }) => line === 4 && hint === "did you mean 'chain'?"));
assert.match(world.load("format = 1\na = [").diagnostics[0].what, /read this/);
assert.match(
  world.load('format = 1\n[[mechanism]]\nname="m"\nmodel = "m.urdf"').diagnostics[0].what,
  /model files can't be read here/,
);
const unknown = world.load(chain(6, '[[event]]\nat = 1\nbreak = "chain/9"\n')).diagnostics.find((d) => d.severity === "error");
assert.match(unknown.what, /chain\/9/);
assert.equal(world.bodies, 6);

// A break changes neither momentum nor energy; the topology says who belongs where.
assert.equal(world.run(0.4).status, status.ok);
const before = world.totals();
const revision = world.revision;
assert.equal(world.act({ break: "chain/4" }).status, status.ok);
const after = world.totals();
nearAll(before.linear, after.linear);
nearAll(before.angular, after.angular);
near(before.kinetic, after.kinetic);
assert.notEqual(world.revision, revision);
assert.deepEqual(
  world.topology().mechanisms.map(({ bodies, grounded }) => [bodies, grounded]),
  [
    [[0, 1, 2], true],
    [[3, 4, 5], false],
  ],
);
assert.equal(world.events().length, 1);

// A lock takes energy and no more; a weld between two mechanisms joins them.
assert.equal(world.act({ lock: "chain/2" }).status, status.ok);
assert.equal(world.topology().joints[1].locked, 1);
assert.ok(world.totals().kinetic <= after.kinetic * (1 + 1e-12));
assert.equal(world.act({ unlock: "chain/2" }).status, status.ok);
const again = world.act({ weld: { body: "chain/2", to: "chain/1" } });
assert.equal(again.status, status.refused);
assert.match(again.message, /already joined/);
assert.equal(world.act({ weld: { body: "chain/4", to: "chain/3" } }).status, status.ok);
assert.equal(world.topology().mechanisms.length, 1);
assert.match(
  world.act({
    attach: { body: "chain/6", to: "chain/1", kind: "no such kind" },
  }).message,
  /no such kind/,
);
assert.match(world.act({ cut: "chain/2" }).message, /unknown action 'cut'/);
assert.equal(world.act({ break: "chain/99" }).status, status.refused);

// Welding two bodies of one mechanism closes a loop: a joint in addition, with a row of its own, that can be locked and broken.
const openLoop = world.snapshot();
assert.equal(world.jointRows, 6);
assert.equal(world.act({ weld: { body: "chain/5", to: "chain/1" } }).status, status.ok);
const loop = world.topology().joints.find((joint) => joint.loop);
assert.deepEqual([loop.kind, loop.child, loop.parent, loop.row], ["weld", 4, 0, 6]);
assert.equal(world.jointRows, 7);
assert.equal(world.joints(true).length, 7 * jointSize);
assert.equal(world.joints(true)[jointSize * loop.row], 0); // a weld has no coordinates
const { loops } = world.events().at(-1).after;
assert.ok(loops.rows === 6 && loops.rank > 0 && loops.residual < 1e-9);
assert.equal(world.run(world.time + 0.1).status, status.ok);
const turning = world.totals().linear;
assert.equal(world.act({ break: loop.name }).status, status.ok);
nearAll(turning, world.totals().linear);
assert.equal(
  world.topology().joints.some((joint) => joint.loop),
  false,
);
assert.equal(world.act({ break: loop.name }).status, status.refused);
assert.equal(world.undo(world.eventCount - 1).status, status.ok);
assert.equal(world.topology().joints.filter((joint) => joint.loop).length, 1);
const withLoop = world.branch();
assert.equal(withLoop.run(withLoop.time + 0.05).status, status.ok);
assert.equal(withLoop.topology().joints.filter((joint) => joint.loop).length, 1);
withLoop.destroy();
assert.equal(world.restore(openLoop).status, status.ok);

// A snapshot is exact, and undoing goes back to just before.
const kept = world.snapshot();
const at = [...world.motions()];
world.setGravity([1, 0, 0]);
world.run(world.time + 0.3);
assert.notDeepEqual([...world.motions()], at);
assert.equal(world.restore(kept).status, status.ok);
assert.deepEqual([...world.motions()], at);
world.drop(kept);
const earlier = world.snapshot();
assert.equal(world.restore(kept).status, status.refused);
const there = world.branch();
world.run(world.time + 0.1);
there.run(there.time + 0.1);
assert.deepEqual([...there.motions()], [...world.motions()]);
assert.equal(there.restore(earlier).status, status.ok);
assert.deepEqual([...there.motions()], at);
there.destroy();
world.drop(earlier);
const count = world.eventCount;
world.act({ break: "chain/6" });
assert.equal(world.undo(count).status, status.ok);
assert.equal(world.eventCount, count);
assert.equal(world.undo(count).status, status.refused);

// The pointer: a grabbed body follows, and comes free again. Balance: what it did is work.
world.load(chain(3));
world.run(0.01);
assert.equal(world.grab("chain/3", [0.2, 0, 0]).status, status.ok);
for (let i = 0; i < 300; i++) {
  world.pull([0.2, -0.2, 0]);
  assert.equal(world.run(world.time + 0.02).status, status.ok);
}
const m = world.motions().subarray(26, 39);
const turned = Math.atan2(2 * m[3] * m[6], 1 - 2 * m[6] * m[6]);
const tip = [m[0] + 0.2 * Math.cos(turned), m[1] + 0.2 * Math.sin(turned)];
assert.ok(Math.hypot(tip[0] - 0.2, tip[1] + 0.2) < 0.1, `${tip}`);
world.releaseGrip();
world.run(world.time + 1);
near(world.totals().balance.error, 0, 1e-4);

// At rest, hanging, a pin carries all that hangs on it; its load is the ratio to its strength.
world.load(chain(2, 'angle = "-90 deg"\n').replace("damping", "strength = { force = 10 }\ndamping"));
const strong = world.load(
  'format = 1\n[[mechanism]]\nname = "m"\n[[mechanism.body]]\nname = "a"\nmass = 2\ninertia = 1\n' +
    '[mechanism.body.joint]\nkind = "weld"\nstrength = { force = "100 N" }\n',
);
assert.ok(strong.scenario, JSON.stringify(strong.diagnostics));
const row = world.joints(true);
near(row[23], 2 * 9.81);
near(row[27], 0.1962);

// 10⁴ calls of each kind leave memory as it is.
world.load(chain(6));
const use = () => {
  const snapshot = world.snapshot();
  world.act({ break: "chain/4" });
  world.act({ weld: { body: "chain/4", to: "chain/3" } });
  world.grab("chain/2", [0, 0, 0]);
  world.act({ weld: { body: "chain/4", to: "chain/3" } }); // refused
  world.pull([1, 1, 1]);
  world.releaseGrip();
  (world.motions(), world.joints(true), world.totals(), world.topology(), world.events(), world.model());
  world.run(world.time + 0.002);
  world.restore(snapshot);
  world.drop(snapshot);
};
const reload = () => (engine.world().destroy(), world.load(chain(6)), world.load("format = "));
for (let i = 0; i < 500; i++) use();
for (let i = 0; i < 500; i++) reload();
world.load(chain(6));
const size = engine.bytes;
for (let i = 0; i < 10000; i++) use();
for (let i = 0; i < 2000; i++) reload();
assert.equal(engine.bytes, size);

// Few functions are exported, whatever a world can do.
assert.ok(WebAssembly.Module.exports(await WebAssembly.compile(bytes)).length <= 12);

console.log("the module keeps what host.d.mts says");
