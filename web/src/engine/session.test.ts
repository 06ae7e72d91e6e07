// The page's record of what the actual engine posts, without a worker; momentree/pages tests the session itself.
import { readFileSync } from "node:fs";
import { beforeAll, beforeEach, describe, expect, it } from "vitest";
import { Engine, type Session } from "../../../wasm/host.mjs";
import { modelOf } from "../result_files";
import { affectedBodies } from "../viewer/before_after";
import { shownJoint } from "../viewer/joints";
import { App } from "../playground/app";
import { loadColours } from "../playground/load_colours";
import { LiveRecording } from "./live";
import { messageFrom, type FromWorker, type PostedMessage, type ToWorker } from "./messages";

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
let session: Session<ToWorker>;
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
  session.send({ type: "play", on: true });
  for (let i = 0; i < frames; i++) session.tick(1 / 60);
  session.send({ type: "play", on: false });
}

beforeAll(async () => {
  engine = await Engine.of(readFileSync(new URL("../../engine/momentree.wasm", import.meta.url)));
});
beforeEach(() => {
  posted = [];
  run = null;
  session = engine.session((message: PostedMessage, bytes) => handle(messageFrom(message, bytes)));
  session.send({ type: "load", text: chain });
});

describe("the record of a session", () => {
  it("has its frames, events and phases", () => {
    play(60);
    expect(run!.last.time).toBeGreaterThan(0.9);
    expect(run!.last.totals.time).toBe(run!.last.time);
    expect(run!.events.map((event) => event.actions[0])).toEqual(["break chain/3"]);
    expect(run!.phases.map((phase) => new Set(Array.from(phase.mechanism)).size)).toEqual([1, 2]);
    expect(affectedBodies(run!, run!.events[0])).toEqual([2]);
  });

  it("goes back, and has the branch that was left", () => {
    play(12);
    const at = run!.last;
    play(30);
    const end = run!.last;
    session.send({ type: "rewind", time: at.time });
    expect([...run!.last.poses]).toEqual([...at.poses]);
    expect(run!.events).toEqual([]);
    expect(run!.otherBranches).toHaveLength(1);
    play(5);
    session.send({ type: "branch", branch: run!.otherBranches[0].number });
    expect(run!.last.time).toBe(end.time);
    expect([...run!.last.poses]).toEqual([...end.poses]);
    expect(run!.otherBranches).toHaveLength(1);
    session.send({ type: "undo", event: 0 });
    expect(run!.events).toEqual([]);
    expect(run!.topology.mechanisms).toHaveLength(1);
  });

  it("shows a loop that was closed until it breaks", () => {
    play(6);
    session.send({ type: "act", action: { weld: { body: "chain/3", to: "chain/1" } } });
    const [weld] = run!.topology.joints.filter(({ loop }) => loop);
    expect(run!.events[0].after?.loops).toMatchObject({ rows: 6 });
    expect(shownJoint(run!.model, run!.phases[1].joints[4], run!.last.poses).lines).toHaveLength(2);
    expect(loadColours(run!.last, run!.topology).colours.has(weld.name)).toBe(true);
    session.send({ type: "act", action: { weld: { body: "chain/4", to: "chain/1" } } });
    play(24); // the scenario breaks chain/3
    const { joints } = run!.phases[run!.phases.length - 1];
    expect(joints.some(({ wasLoop }) => wasLoop)).toBe(true);
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

  it("why an action is refused reaches the page", () => {
    session.send({ type: "act", action: { weld: { body: "chain/2", to: "chain/1" } } });
    const refused = posted.find((message) => message.type === "refused");
    expect(refused?.type === "refused" && refused.message).toMatch(/weld/);
  });
});

describe("a frame", () => {
  it("has its numbers as bytes, or in base64", () => {
    const bytes = new ArrayBuffer(8 * 17 + 4 * 19);
    new Float64Array(bytes, 0, 17).set([1.5, 2, -3, 1, 0, 0, 0, 1, 0, 0.5, -1, 0.25, 0, 0, 0, 1e-9, NaN]);
    new Float32Array(bytes, 8 * 17).set([1, 2, 3, 1, 0, 0, 0, NaN, 4, 1, 0, 0, 4, 5, 6, 7, 0, 0, 8]);
    const sizes = { poses: 7, loads: 6, contacts: 6 };
    const numbers = Buffer.from(bytes).toString("base64");
    for (const message of [
      messageFrom({ type: "frame", frame: sizes }, bytes),
      messageFrom({ type: "frame", frame: { ...sizes, numbers } }),
    ]) {
      if (message.type !== "frame") throw new Error(message.type);
      const { frame } = message;
      expect([...frame.poses]).toEqual([1, 2, 3, 1, 0, 0, 0]);
      expect([...frame.loads]).toEqual([NaN, 4, 1, 0, 0, 4]);
      expect([...frame.contacts]).toEqual([5, 6, 7, 0, 0, 8]);
      expect([frame.time, frame.totals.potential, frame.totals.balance.dissipated]).toEqual([1.5, -3, 0.25]);
      expect(frame.totals.angular).toEqual([0, 1, 0]);
      expect(frame.totals.balance.projection).toBeNaN();
    }
    const loaded = messageFrom({ type: "loaded", world: { frame: { ...sizes, numbers } } });
    expect(loaded.type === "loaded" && loaded.world?.frame.poses.length).toBe(7);
    expect(messageFrom({ type: "playing" })).toEqual({ type: "playing" });
  });
});
