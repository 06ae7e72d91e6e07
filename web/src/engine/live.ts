// A recording that grows while the engine runs, can be truncated, and has branches.
import type { Topology, WorldTotals } from "../../../wasm/host.mjs";
import type { Column, JointKind, Link, Model, Phase, Recording, RunEvent, WorldQuantity } from "../recording";
import { lastNotAfter } from "../viewer/frames";
import type { Frame } from "./messages";

interface Line {
  frames: Frame[];
  events: RunEvent[];
  phases: Phase[];
}

/** A branch that was left, by the number that the worker gave it. */
export interface Left {
  readonly number: number;
  readonly end: number;
  /** The last event in it. */
  readonly last: string;
}

const cut = /^(?:break|free|lock|unlock|change|set) (\S+)/;

export class LiveRecording implements Recording {
  revision = 0;
  readonly mechanisms: string[] = [];
  readonly summary = null;
  readonly joints: readonly string[] = [];
  private line: Line = { frames: [], events: [], phases: [] };
  private readonly saved = new Map<number, Line>();
  private present: Topology;

  constructor(
    readonly model: Model,
    topology: Topology,
    first: Frame,
  ) {
    this.present = topology;
    this.addTopology(first.time, topology);
    this.addFrame(first);
  }

  get frames() {
    return this.line.frames.length;
  }
  get events() {
    return this.line.events;
  }
  get phases() {
    return this.line.phases;
  }
  get topology() {
    return this.present;
  }
  get last(): Frame {
    return this.line.frames[this.line.frames.length - 1];
  }
  get left(): Left[] {
    return [...this.saved].map(([number, line]) => ({
      number,
      end: line.frames[line.frames.length - 1].time,
      last: line.events[line.events.length - 1]?.actions[0] ?? "nothing happened",
    }));
  }

  frame(number: number): Frame {
    return this.line.frames[number];
  }
  time(frame: number) {
    return this.line.frames[frame].time;
  }
  poses(frame: number) {
    return this.line.frames[frame].poses;
  }

  addFrame(frame: Frame) {
    const { frames } = this.line;
    // At the instant of a change, the recording shows the state after it.
    if (frames.length > 0 && frames[frames.length - 1].time >= frame.time) frames.pop();
    frames.push(frame);
  }

  addTopology(time: number, topology: Topology) {
    this.present = topology;
    const mechanism = new Int32Array(this.model.bodies.length).fill(-1);
    for (const { name, bodies } of topology.mechanisms) {
      let place = this.mechanisms.indexOf(name);
      if (place < 0) place = this.mechanisms.push(name) - 1;
      for (const body of bodies) mechanism[body] = place;
    }
    const links: Link[] = topology.joints.map((joint) => ({
      joint: joint.name,
      kind: joint.kind as JointKind,
      parent: joint.parent,
      child: joint.child,
      at: joint.at.xyz,
      childAt: joint.child_at.xyz,
      locked: joint.locked !== 0,
    }));
    const { phases } = this.line;
    while (phases.length > 0 && phases[phases.length - 1].from >= time) phases.pop();
    phases.push({ from: time, mechanism, links });
  }

  addEvents(events: readonly Record<string, unknown>[]) {
    const bodies = new Map(this.model.bodies.map((body, b) => [body.name, b]));
    const children = new Map(this.model.joints.map((joint) => [joint.name, joint.child]));
    for (const file of events) {
      const event = file as unknown as RunEvent & { event: string; duration_ns: number };
      const about = event.actions.flatMap((action) => {
        const joint = cut.exec(action)?.[1];
        const child = joint === undefined ? undefined : (children.get(joint) ?? bodies.get(joint));
        const joined = /^(?:weld|attach) (\S+) to (\S+)/.exec(action)?.slice(1) ?? [];
        return [child, ...joined.map((name) => bodies.get(name))].filter((b): b is number => b !== undefined);
      });
      this.line.events.push({ ...event, name: event.event, durationNs: event.duration_ns, bodies: about });
    }
  }

  /** Removes everything after `time`; `left`: it is kept under that number. */
  goBack(time: number, events: number, left: number) {
    const { line } = this;
    this.saved.set(left, line);
    const frames = line.frames.slice(0, lastNotAfter(line.frames.length, (i) => line.frames[i].time, time) + 1);
    const phases = line.phases.filter((phase, i) => i === 0 || phase.from <= time);
    this.line = { frames, phases, events: line.events.slice(0, events) };
    this.revision++;
  }

  goOn(branch: number, left: number) {
    const line = this.saved.get(branch);
    if (!line) return;
    this.saved.delete(branch);
    this.saved.set(left, this.line);
    this.line = line;
    this.revision++;
  }

  totals(frame: number): WorldTotals {
    return this.line.frames[frame].totals;
  }

  world(quantity: WorldQuantity): Column[] {
    const column = (label: string, unit: string, of: (totals: WorldTotals) => number): Column => ({
      label,
      unit,
      values: this.line.frames.map((frame) => of(frame.totals)),
    });
    const axes = (unit: string, of: "linear" | "angular") =>
      ["x", "y", "z"].map((axis, k) => column(axis, unit, (t) => t[of][k]));
    switch (quantity) {
      case "energy":
        return [
          column("kinetic", "J", (t) => t.kinetic),
          column("potential", "J", (t) => t.potential),
          column("total", "J", (t) => t.kinetic + t.potential),
        ];
      case "balance":
        return [column("error", "J", (t) => t.balance.error)];
      case "linear":
        return axes("N s", "linear");
      case "angular":
        return axes("N m s", "angular");
    }
  }

  joint(): readonly Column[] {
    return [];
  }
}
