// Worlds with contact in a session: what is thrown lands, and a world that makes no progress is stopped with a message.
import { readFileSync } from "node:fs";
import { afterEach, describe, expect, it, vi } from "vitest";
import { Engine, status, type World } from "../../../wasm/host.mjs";
import { isContact } from "../contacts";
import { modelOf } from "../result_files";
import { LiveRecording } from "./live";
import type { FromWorker } from "./messages";
import { Session } from "./session";

const engine = await Engine.of(readFileSync(new URL("../../engine/momentree.wasm", import.meta.url)));
const crates = readFileSync(new URL("../../../scenarios/hanging_boxes_fall.toml", import.meta.url), "utf8");

function opened(text: string, by: Engine = engine) {
  const posted: FromWorker[] = [];
  const shown: { run: LiveRecording | null } = { run: null };
  const session = new Session(by, (message) => {
    posted.push(message);
    if (message.type === "loaded" && message.world)
      shown.run = new LiveRecording(modelOf(message.world.model), message.world.topology, message.world.frame);
    else if (message.type === "frame") shown.run!.addFrame(message.frame);
    else if (message.type === "topology") shown.run!.addTopology(message.time, message.topology);
    else if (message.type === "events") shown.run!.addEvents(message.events);
  });
  session.handle({ type: "load", text });
  const play = (frames: number, each: (frame: number) => void = () => undefined) => {
    session.handle({ type: "play", on: true });
    for (let i = 0; i < frames; i++) {
      each(i);
      session.tick(1 / 60);
    }
  };
  return { posted, session, play, run: () => shown.run! };
}

/** Height of the lowest corner of a crate (m), a cube of 40 cm around (0, 0, −0.3). */
function lowest(poses: ArrayLike<number>, body: number): number {
  const [, , z, w, x, y, q] = Array.from(poses).slice(7 * body, 7 * body + 7);
  const row = [2 * (x * q - w * y), 2 * (y * q + w * x), 1 - 2 * (x * x + y * y)]; // of the rotation matrix: world z
  return z - 0.3 * row[2] - 0.2 * row.reduce((sum, each) => sum + Math.abs(each), 0);
}

describe("contact in a session", () => {
  afterEach(() => vi.restoreAllMocks());

  it("a crate that is grabbed and thrown lands on the floor and stays above it", () => {
    // Each frame is computed whole, so that the motion does not depend on the speed of the machine.
    const unhurried = {
      world: () => {
        const world: World = engine.world();
        const advance = world.run.bind(world);
        world.run = (target) => advance(target, Infinity);
        return world;
      },
    };
    const { session, play, run, posted } = opened(crates, unhurried as unknown as Engine);
    vi.spyOn(performance, "now").mockReturnValue(0);
    const playTo = (time: number, each: (time: number) => void = () => undefined) => {
      for (let i = 0; run().last.time < time && i < 5000; i++) play(1, () => each(run().last.time));
    };
    playTo(1.5);
    session.handle({ type: "grab", body: 2, point: [0, 0, -0.3], target: [0, 0, 1.5] });
    playTo(2, (time) => session.handle({ type: "pull", target: [3.6 * (time - 1.5), 0, 1.5] }));
    session.handle({ type: "release" });
    playTo(5);
    expect(posted.filter(({ type }) => type === "stopped")).toEqual([]);
    for (let frame = 0; frame < run().frames; frame++)
      for (const body of [1, 2]) expect(lowest(run().poses(frame), body)).toBeGreaterThan(-1e-5); // poses are in single precision
    expect(lowest(run().last.poses, 2)).toBeLessThan(0.05);
    expect(run().events.filter(isContact).length).toBeGreaterThan(10);
    // Contacts are no changes of the topology: only the link that parted is one.
    expect(run().phases).toHaveLength(2);
  });

  it("the forces of contacts are in the frames, if the engine reports them", () => {
    const reporting = {
      world: () =>
        Object.assign(engine.world(), { contacts: () => Float64Array.from([1, -1, 2, 3, 4, 0, 0, 1, 5, 6, 7, 0, 0, 0, 1]) }),
    };
    expect(
      opened(crates, reporting as unknown as Engine)
        .run()
        .contacts(0),
    ).toEqual([{ point: [2, 3, 4], force: [5, 6, 7] }]);
  });

  it("an overlap at the start is a problem with its line, in words", () => {
    const { posted } = opened(crates.replace("xyz = [0, 0, 3]", "xyz = [0, 0, 1]"));
    const [loaded] = posted;
    if (loaded.type !== "loaded") throw new Error("nothing was loaded");
    expect(loaded.world).toBeNull();
    expect(loaded.diagnostics[0].what).toMatch(/overlap/);
    expect(loaded.diagnostics[0].line).toBeGreaterThan(1);
  });

  it("a method that has no contact is a problem, in words", () => {
    const { posted } = opened(crates.replace('"dop853"', '"midpoint"').replace("rtol   = 1e-6\n", ""));
    const [loaded] = posted;
    if (loaded.type !== "loaded") throw new Error("nothing was loaded");
    expect(loaded.diagnostics.map(({ what, hint }) => `${what} ${hint}`).join()).toMatch(/dop853/);
  });
});

describe("a world that makes no progress", () => {
  afterEach(() => vi.restoreAllMocks());

  it("is stopped after a while, with a message", () => {
    let now = 0;
    vi.spyOn(performance, "now").mockImplementation(() => now);
    const stuck = {
      world: () => {
        const world: World = engine.world();
        world.run = () => {
          now += 20; // ms
          return { status: status.interrupted, message: "" };
        };
        return world;
      },
    };
    const { posted, play } = opened(crates, stuck as unknown as Engine);
    play(190);
    expect(posted.filter(({ type }) => type === "stopped")).toEqual([]);
    play(20);
    expect(posted.filter(({ type }) => type === "stopped")).toEqual([
      { type: "stopped", message: "No progress at t = 0.00000 s: too much happens at once. Go back, or restart." },
    ]);
    expect(posted.filter(({ type }) => type === "playing")).toEqual([{ type: "playing", on: false }]);
  });
});

describe("a floor below a scenario that has none", () => {
  afterEach(() => vi.restoreAllMocks());
  const chain = `format = 1
title = "A chain"
[[mechanism]]
name = "chain"
[mechanism.chain]
links = 8
length = 0.1
mass = 0.05
inertia = 4e-5
axis = [0, 1, 0]
damping = 0.0002
`;

  it("a chain that is cut and thrown lands there, with forces in the frames", () => {
    vi.spyOn(performance, "now").mockReturnValue(0);
    const { session, play, run, posted } = opened(chain);
    session.handle({ type: "load", text: chain, floor: true });
    const [, loaded] = posted.filter(({ type }) => type === "loaded");
    expect(loaded.type === "loaded" && loaded.world?.scenario.floor).toBe(true);
    const planes = loaded.type === "loaded" ? modelOf(loaded.world!.model).planes! : [];
    expect(planes).toHaveLength(1);
    const height = planes[0].point[2];
    expect(height).toBeLessThan(-0.8);
    play(30);
    session.handle({ type: "act", action: { action: "break", joint: 0 } });
    session.handle({ type: "grab", body: 4, point: [0, 0, 0], target: [0, 0, 0.3] });
    play(30, (i) => session.handle({ type: "pull", target: [0.02 * i, 0, 0.3] }));
    session.handle({ type: "release" });
    play(240);
    expect(posted.filter(({ type }) => type === "stopped" || type === "refused")).toEqual([]);
    for (let frame = 0; frame < run().frames; frame++)
      for (let body = 0; body < 8; body++) expect(run().poses(frame)[7 * body + 2]).toBeGreaterThan(height - 0.002);
    // It lies there, folded as it fell, with its weight.
    for (let body = 0; body < 8; body++) expect(run().last.poses[7 * body + 2]).toBeLessThan(height + 0.2);
    const force = run()
      .contacts(run().frames - 1)
      .reduce((sum, each) => sum + each.force[2], 0);
    expect(force).toBeGreaterThan(0.9 * 8 * 0.05 * 9.81);
    expect(force).toBeLessThan(1.1 * 8 * 0.05 * 9.81);
  });

  it("a joint breaks when it is pulled harder than the limit", () => {
    vi.spyOn(performance, "now").mockReturnValue(0);
    const { session, play, run } = opened(chain);
    session.handle({ type: "load", text: chain, floor: true });
    session.handle({ type: "strength", force: 20 });
    play(60);
    expect(run().topology.joints.some(({ force }) => force === 20)).toBe(true);
    const joints = run().topology.joints.filter(({ kind }) => kind !== "free").length;
    session.handle({ type: "grab", body: 7, point: [0.1, 0, 0], target: [0, 0, -0.7] });
    play(60, (i) => session.handle({ type: "pull", target: [0.1 * i, 0, 0] }));
    expect(run().events.some(({ event }) => event.startsWith("strength of"))).toBe(true);
    expect(run().topology.joints.filter(({ kind }) => kind !== "free").length).toBeLessThan(joints);
  });

  it("is the one of the scenario if it has one", () => {
    const { session, posted } = opened(crates);
    session.handle({ type: "load", text: crates, floor: true });
    const worlds = posted.flatMap((message) => (message.type === "loaded" && message.world ? [message.world] : []));
    expect(worlds.map(({ model }) => modelOf(model).planes!.length)).toEqual([1, 1]);
    expect(modelOf(worlds[0].model).planes).toEqual(modelOf(worlds[1].model).planes);
  });
});
