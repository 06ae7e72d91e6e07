// The session with the actual engine, without a worker: pace, going back, branches.
import { readFileSync } from "node:fs";
import { beforeAll, beforeEach, describe, expect, it } from "vitest";
import { Engine } from "../../../wasm/host.mjs";
import { modelOf } from "../result_files";
import { affectedBodies } from "../viewer/before_after";
import { shownJoint } from "../viewer/joints";
import { App } from "../playground/app";
import { loadColours } from "../playground/load_colours";
import { LiveRecording } from "./live";
import { loadSize, type FromWorker } from "./messages";
import { Session } from "./session";

const chain = `format = 1
[world]
gravity = [0, -9.81, 0]
[[mechanism]]
name = "chain"
[mechanism.chain]
links = 4
length = 0.2
mass = 0.1
inertia = 3e-4
[[event]]
at = 0.3
break = "chain/3"
`;

let engine: Engine;
let session: Session;
let run: LiveRecording | null;
let posted: FromWorker[];

/** How the page handles the session's messages. */
function handle(message: FromWorker) {
  posted.push(message);
  if (message.type === "loaded" && message.world)
    run = new LiveRecording(modelOf(message.world.model), message.world.topology, message.world.frame);
  else if (message.type === "frame") run!.addFrame(message.frame);
  else if (message.type === "topology") run!.addTopology(message.time, message.topology);
  else if (message.type === "events") run!.addEvents(message.events);
  else if (message.type === "rewound") run!.rewind(message.time, message.events, message.savedAs);
  else if (message.type === "resumed") run!.resume(message.branch, message.savedAs);
}

function play(frames: number) {
  session.handle({ type: "play", on: true });
  for (let i = 0; i < frames; i++) session.tick(1 / 60);
  session.handle({ type: "play", on: false });
}

beforeAll(async () => {
  engine = await Engine.of(readFileSync(new URL("../../engine/momentree.wasm", import.meta.url)));
});
beforeEach(() => {
  posted = [];
  run = null;
  session = new Session(engine, handle);
  session.handle({ type: "load", text: chain });
});

describe("a session", () => {
  it("keeps up with the clock, in whole steps", () => {
    play(60);
    expect(run!.last.time).toBeGreaterThan(0.9);
    expect(run!.last.time).toBeLessThan(1.02);
    expect(Math.abs(run!.last.time * 1000 - Math.round(run!.last.time * 1000))).toBeLessThan(1e-9);
    expect(run!.events.map((event) => event.actions[0])).toEqual(["break chain/3"]);
    expect(run!.phases.map((phase) => new Set(Array.from(phase.mechanism)).size)).toEqual([1, 2]);
    expect(affectedBodies(run!, run!.events[0])).toEqual([2]);
  });

  it("runs slower at a lower speed", () => {
    session.handle({ type: "speed", factor: 0.1 });
    play(60);
    expect(run!.last.time).toBeLessThan(0.12);
    expect(run!.frames).toBeGreaterThan(20);
  });

  it("rewinds to the same bits, and keeps the branch that it left", () => {
    play(12);
    const at = run!.last;
    play(30);
    const end = run!.last;
    session.handle({ type: "rewind", time: at.time });
    expect(run!.last.time).toBe(at.time);
    expect([...run!.last.poses]).toEqual([...at.poses]);
    expect(run!.last.totals.linear).toEqual(at.totals.linear);
    expect(run!.events).toEqual([]);
    expect(run!.otherBranches).toHaveLength(1);
    play(5);
    session.handle({ type: "branch", branch: run!.otherBranches[0].number });
    expect(run!.last.time).toBe(end.time);
    expect([...run!.last.poses]).toEqual([...end.poses]);
    expect(run!.otherBranches).toHaveLength(1);
  });

  it("of a program: a page that is opened late begins its record with the present", () => {
    play(30);
    const app = new App({ postMessage: () => undefined, onmessage: null }, undefined, true);
    const tell = (message: FromWorker) => app.handle(message);
    const frames = posted.flatMap((message) => (message.type === "frame" ? [message.frame] : []));
    const at = (time: number): FromWorker => ({ type: "frame", seconds: 0, frame: { ...frames[0], time } });
    for (const message of posted) if (message.type === "loaded" || message.type === "events") tell(message);
    expect(app.run!.events).toHaveLength(1);
    for (const time of [70, 70.1, 71]) tell(at(time));
    expect([0, 1, 2].map((i) => app.run!.time(i))).toEqual([70, 70.1, 71]);
    expect(app.run!.phases).toHaveLength(1);
    app.seek(0.3);
    expect(app.time).toBe(70);
    tell(posted.find(({ type }) => type === "loaded")!); // opened at the start: nothing is left out
    tell(at(0.2));
    expect([app.run!.frames, app.run!.time(0)]).toEqual([2, 0]);
  });

  it("undoes an event, which does not happen again", () => {
    play(30);
    expect(run!.events).toHaveLength(1);
    session.handle({ type: "undo", event: 0 });
    expect(run!.last.time).toBeCloseTo(0.3, 12);
    play(30);
    expect(run!.events).toEqual([]);
    expect(run!.topology.mechanisms).toHaveLength(1);
  });

  it("reports why an action is refused, and changes nothing", () => {
    session.handle({ type: "act", action: { action: "weld", body: 1, to: 0 } });
    const refused = posted.find((message) => message.type === "refused");
    expect(refused?.type === "refused" && refused.message).toMatch(/weld/);
    expect(run!.events).toEqual([]);
  });

  const loops = () => run!.topology.joints.filter(({ loop }) => loop);

  it("closes a loop by a weld of two bodies of one mechanism, opens it by a cut, and goes back across both", () => {
    play(6);
    session.handle({ type: "act", action: { action: "weld", body: 2, to: 0 } });
    expect(posted.some(({ type }) => type === "refused")).toBe(false);
    const [weld] = loops();
    expect(weld).toMatchObject({ kind: "weld", parent: 0, child: 2, row: 4 });
    expect(run!.topology.mechanisms).toHaveLength(1);
    expect(run!.last.loads).toHaveLength(loadSize * 5);
    expect(run!.events[0].after?.loops).toMatchObject({ rows: 6 });
    const shown = () => shownJoint(run!.model, run!.phases[run!.phases.length - 1].joints[4], run!.last.poses).lines;
    expect(shown()).toHaveLength(2);
    const apart = () => Math.hypot(...[0, 1, 2].map((k) => run!.last.poses[14 + k] - run!.last.poses[k]));
    const distance = apart();
    play(6);
    expect(apart()).toBeCloseTo(distance, 5);
    expect(loadColours(run!.last, run!.topology).colours.has(weld.name)).toBe(true);
    session.handle({ type: "act", action: { action: "break", joint: weld.number } });
    expect(loops()).toEqual([]);
    play(6);
    const end = run!.last;
    session.handle({ type: "undo", event: 1 });
    expect(loops()).toHaveLength(1);
    session.handle({ type: "undo", event: 0 });
    expect(loops()).toEqual([]);
    session.handle({ type: "branch", branch: 0 });
    expect([...run!.last.poses]).toEqual([...end.poses]);
  });

  it("after the break of a joint of a loop, the loop joint holds the part and can be cut like any other", () => {
    play(6);
    session.handle({ type: "act", action: { action: "weld", body: 3, to: 0 } });
    play(24); // the scenario breaks chain/3
    expect(loops()).toEqual([]);
    expect(run!.topology.mechanisms).toHaveLength(1);
    const { joints } = run!.phases[run!.phases.length - 1];
    const held = joints.filter(({ wasLoop }) => wasLoop);
    expect(held).toHaveLength(1);
    const { number } = run!.topology.joints.find(({ name }) => name === held[0].name)!;
    session.handle({ type: "act", action: { action: "break", joint: number } });
    expect(run!.topology.mechanisms).toHaveLength(2);
  });

  it("reads scenarios with closed loops, and reports those that can't be closed", () => {
    const bars = (at: string) => `${chain.replace("links = 4", 'links = 3\nangle = "40 deg"').replace("break = ", "lock = ")}
[[loop]]
name = "pin"
kind = "revolute"
body = "chain/3"
at = { xyz = ${at} }
child_at = { xyz = [0.2, 0, 0] }
`;
    session.handle({ type: "load", text: bars("[0.3, 0, 0]") });
    expect(loops().map(({ name }) => name)).toEqual(["pin"]);
    const [mark] = run!.phases[0].joints.filter(({ loop }) => loop);
    const place = () => shownJoint(run!.model, mark, run!.last.poses).at;
    play(12);
    expect(place()[0]).toBeCloseTo(0.3, 5);
    expect(place()[1]).toBeCloseTo(0, 5);
    session.handle({ type: "check", text: bars("[3, 0, 0]") });
    const checked = posted[posted.length - 1];
    expect(checked.type === "checked" && checked.diagnostics.map(({ what }) => what).join()).toMatch(/pin.*can't be closed/);
  });

  it("keeps its world if another scenario has errors", () => {
    session.handle({ type: "load", text: "format = 1\n" });
    const loaded = posted.filter((message) => message.type === "loaded").pop();
    expect(loaded?.type === "loaded" && loaded.world).toBeNull();
    play(6);
    expect(run!.last.time).toBeGreaterThan(0.05);
  });

  it("reports the errors of a text without running it", () => {
    play(6);
    const { frames } = run!;
    const checked = (text: string) => {
      session.handle({ type: "check", text });
      const last = posted[posted.length - 1];
      return last.type === "checked" ? last.diagnostics : null;
    };
    expect(checked(chain.replace("links", "lynks"))?.map(({ line }) => line)).toEqual([6, 7]);
    expect(checked(chain)).toEqual([]);
    expect(run!.frames).toBe(frames);
    play(6);
    expect(run!.last.time).toBeGreaterThan(0.15);
  });
});
