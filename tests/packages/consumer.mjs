// A project that has installed the package of npm: a double pendulum breaks while it swings, and each part then moves as closed
// forms say.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { Engine, EngineFailure, load, motionSize, status } from "momentree";

const g = 9.81;
const scenario = `format = 1
[world]
gravity = [0, -${g}, 0]
[[mechanism]]
name = "m"
[[mechanism.body]]
name = "a"
mass = 2
com = [0.5, 0, 0]
inertia = [0.01, 0.2, 0.2]
[mechanism.body.joint]
kind = "revolute"
axis = [0, 0, 1]
[[mechanism.body]]
name = "b"
mass = 3
inertia = [0.1, 0.2, 0.3]
[mechanism.body.joint]
kind = "revolute"
parent = "a"
at = { xyz = [1, 0, 0] }
axis = [0, 0, 1]
[integrate]
step = "1 ms"
until = "1 s"
`;

const engine = await load();
assert.ok(engine instanceof Engine);
const world = engine.world();
const read = world.load(scenario);
assert.ok(read.scenario, JSON.stringify(read.diagnostics));
assert.equal(world.run(0.4).status, status.ok);
const before = world.totals();
assert.equal(world.act({ break: "m/b" }).status, status.ok);
const after = world.totals();
for (const [x, y] of [
  [before.kinetic, after.kinetic],
  [before.potential, after.potential],
  ...before.linear.map((x, i) => [x, after.linear[i]]),
  ...before.angular.map((x, i) => [x, after.angular[i]]),
])
  assert.ok(Math.abs(x - y) < 1e-12 * Math.max(1, Math.abs(x)), `${x} and ${y}`);
assert.equal(world.topology().mechanisms.length, 2);

// b, whose origin is its centre of mass, falls freely and keeps its spin; a swings on as a pendulum and keeps its energy.
const start = Array.from(world.motions().subarray(motionSize, 2 * motionSize));
const energy = (m) => 0.5 * (0.2 + 2 * 0.25) * m[12] ** 2 + 2 * g * 0.5 * (2 * (m[3] * m[6] + m[4] * m[5]));
const swing = energy(Array.from(world.motions().subarray(0, motionSize)));
const t = 0.5;
assert.equal(world.run(world.time + t).status, status.ok);
const [a, b] = [0, 1].map((i) => Array.from(world.motions().subarray(i * motionSize, (i + 1) * motionSize)));
const near = (x, y) => assert.ok(Math.abs(x - y) < 1e-9, `${x} and ${y}`);
near(b[0], start[0] + start[7] * t);
near(b[1], start[1] + start[8] * t - (g * t * t) / 2);
near(b[8], start[8] - g * t);
near(b[12], start[12]);
near(energy(a), swing);
assert.equal(world.events().length, 1);

// Errors of users are answers, not exceptions.
assert.equal(world.act({ break: "m/c" }).status, status.refused);
assert.notEqual(world.act({ weld: { body: "m/a", to: "m/a" } }).message, "");
assert.equal(world.load("format = 1\nmechanisms = 1\n").diagnostics[0].line, 2);
assert.ok(EngineFailure.prototype instanceof Error);

// From bytes and from a compiled module, as programs do that keep the file elsewhere.
const bytes = await readFile(createRequire(import.meta.url).resolve("momentree/momentree.wasm"));
for (const module of [bytes, await WebAssembly.compile(bytes)]) {
  const other = (await load({ module })).world();
  assert.ok(other.load(scenario).scenario);
  assert.equal(other.run(0.4).status, status.ok);
  assert.deepEqual(other.totals(), before);
}
console.log("the package of npm simulates, breaks and refuses");
