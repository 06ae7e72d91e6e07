// The session with the actual engine, without a worker: pace, going back, branches.
import { readFileSync } from "node:fs";
import { beforeAll, beforeEach, describe, expect, it } from "vitest";
import { Engine } from "../../../wasm/host.mjs";
import type { Model } from "../recording";
import { modelOf } from "../report/data";
import { LiveRecording } from "./live";
import type { FromWorker } from "./messages";
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
let said: FromWorker[];

const model = (file: unknown): Model => {
  const read = file as Parameters<typeof modelOf>[0];
  return modelOf(read, Object.keys(read.bodies));
};

/** How the page handles the worker's messages. */
function hear(message: FromWorker) {
  said.push(message);
  if (message.say === "loaded" && message.topology && message.frame)
    run = new LiveRecording(model(message.model), message.topology, message.frame);
  else if (message.say === "frame") run!.addFrame(message.frame);
  else if (message.say === "topology") run!.addTopology(message.time, message.topology);
  else if (message.say === "events") run!.addEvents(message.events);
  else if (message.say === "went back") run!.goBack(message.time, message.events, message.left);
  else if (message.say === "branched") run!.goOn(message.branch, message.left);
}

function play(frames: number) {
  session.hear({ say: "play", on: true });
  for (let i = 0; i < frames; i++) session.tick(1 / 60);
  session.hear({ say: "play", on: false });
}

beforeAll(async () => {
  engine = await Engine.of(readFileSync(new URL("../../engine/momentree.wasm", import.meta.url)));
});
beforeEach(() => {
  said = [];
  run = null;
  session = new Session(engine, hear);
  session.hear({ say: "load", text: chain });
});

describe("a session", () => {
  it("keeps the pace of the clock, in whole steps", () => {
    play(60);
    expect(run!.last.time).toBeGreaterThan(0.9);
    expect(run!.last.time).toBeLessThan(1.02);
    expect(Math.abs(run!.last.time * 1000 - Math.round(run!.last.time * 1000))).toBeLessThan(1e-9);
    expect(run!.events.map((event) => event.actions[0])).toEqual(["break chain/3"]);
    expect(run!.phases.map((phase) => new Set(Array.from(phase.mechanism)).size)).toEqual([1, 2]);
  });

  it("goes slower where it is told to", () => {
    session.hear({ say: "speed", factor: 0.1 });
    play(60);
    expect(run!.last.time).toBeLessThan(0.12);
    expect(run!.frames).toBeGreaterThan(20);
  });

  it("rewinds to the very bits, and keeps what it left", () => {
    play(12);
    const at = run!.last;
    play(30);
    const end = run!.last;
    session.hear({ say: "rewind", time: at.time });
    expect(run!.last.time).toBe(at.time);
    expect([...run!.last.poses]).toEqual([...at.poses]);
    expect(run!.last.totals.linear).toEqual(at.totals.linear);
    expect(run!.events).toEqual([]);
    expect(run!.left).toHaveLength(1);
    play(5);
    session.hear({ say: "branch", branch: run!.left[0].number });
    expect(run!.last.time).toBe(end.time);
    expect([...run!.last.poses]).toEqual([...end.poses]);
    expect(run!.left).toHaveLength(1);
  });

  it("undoes an event, which does not happen again", () => {
    play(30);
    expect(run!.events).toHaveLength(1);
    session.hear({ say: "undo", event: 0 });
    expect(run!.last.time).toBeCloseTo(0.3, 12);
    play(30);
    expect(run!.events).toEqual([]);
    expect(run!.topology.mechanisms).toHaveLength(1);
  });

  it("refuses in words, and changes nothing", () => {
    session.hear({ say: "act", act: { do: "weld", body: 3, to: 0 } });
    const refused = said.find((message) => message.say === "refused");
    expect(refused?.say === "refused" && refused.message).toMatch(/weld/);
    expect(run!.events).toEqual([]);
  });

  it("keeps its world where another has errors", () => {
    session.hear({ say: "load", text: "format = 1\n" });
    const loaded = said.filter((message) => message.say === "loaded").pop();
    expect(loaded?.say === "loaded" && loaded.scenario).toBeNull();
    play(6);
    expect(run!.last.time).toBeGreaterThan(0.05);
  });

  it("tells what is wrong with a text without running it", () => {
    play(6);
    const { frames } = run!;
    const checked = (text: string) => {
      session.hear({ say: "check", text });
      const last = said[said.length - 1];
      return last.say === "checked" ? last.diagnostics : null;
    };
    expect(checked(chain.replace("links", "lynks"))?.map(({ line }) => line)).toEqual([6, 7]);
    expect(checked(chain)).toEqual([]);
    expect(run!.frames).toBe(frames);
    play(6);
    expect(run!.last.time).toBeGreaterThan(0.15);
  });
});
