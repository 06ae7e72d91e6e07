import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { Engine } from "../../../wasm/host.mjs";
import { LiveRecording } from "../engine/live";
import { frameOf } from "../engine/messages";
import { modelOf, type ModelFile } from "../result_files";
import { phaseAt } from "../viewer/frames";
import { connectionsOf } from "./connections";

const engine = await Engine.of(readFileSync(new URL("../../engine/momentree.wasm", import.meta.url)));
const scenario = (name: string) => readFileSync(new URL(`../../../scenarios/${name}.toml`, import.meta.url), "utf8");

function world(text: string) {
  const world = engine.world();
  expect(world.load(text).scenario).not.toBeNull();
  const model = modelOf(world.model() as ModelFile);
  const list = () => {
    const run = new LiveRecording(model, world.topology(), frameOf(world));
    return connectionsOf(model, run.topology, phaseAt(run, run.last.time), run.last.poses);
  };
  return { world, list };
}

describe("the list of loops, springs and couplings", () => {
  it("has a loop joint until it is broken, and a weld that closes another", () => {
    const { world: w, list } = world(scenario("two_arms_hold_a_bar"));
    expect(list()).toEqual([{ kind: "loop", name: "right grip", text: "revolute, left/bar to right/fore" }]);
    expect(w.act({ weld: { body: "left/upper", to: "left/bar" } }).message).toBe("");
    expect(list().map(({ text }) => text)).toContain("weld, left/upper to left/bar");
    w.act({ break: "right grip" });
    expect(list()).toHaveLength(1);
  });

  it("has the tension of springs, and says which broke", () => {
    const { world: w, list } = world(scenario("guyed_mast"));
    w.run(0.5);
    const before = list();
    expect(before.map(({ name }) => name)).toEqual(["west guy", "north guy", "south guy"]);
    for (const { text } of before) expect(text).toMatch(/^rope, mast\/pole to the ground: (slack|[\d.e]+ N)( of [\d.e]+ N)?$/);
    w.run(3);
    expect(list().find(({ over }) => over)).toMatchObject({ name: "west guy", text: "broken, mast/pole to the ground" });
  });

  it("lists the couplings that the engine reports", () => {
    const { world: w } = world(scenario("four_bar"));
    const topology = {
      ...w.topology(),
      couplings: [
        { joint: "a", follows: "b", ended: false },
        { joint: "c", follows: "", ended: true },
      ],
    };
    const model = modelOf(w.model() as ModelFile);
    const run = new LiveRecording(model, topology, frameOf(w));
    expect(connectionsOf(model, run.topology, run.phases[0], run.last.poses).slice(-2)).toEqual([
      { kind: "coupling", name: "a", text: "follows b" },
      { kind: "coupling", name: "c", text: "followed a fixed value", over: true },
    ]);
  });
});
