// The motion of a world that runs: it grows, can be truncated, and has branches.
import type { Topology, WorldTotals } from "../../../wasm/host.mjs";
import { textOf } from "../contacts";
import type { ContactForce, Model, Motion, Phase, RunEvent } from "../recording";
import { lastNotAfter } from "../viewer/frames";
import { withHistory } from "../viewer/joints";
import { contactForceSize, type Frame } from "./messages";

interface BranchData {
  frames: Frame[];
  events: RunEvent[];
  phases: Phase[];
}

/** A branch that was left, by the number that the session gave it. */
export interface OtherBranch {
  readonly number: number;
  readonly end: number;
  /** The first action of the last event in it. */
  readonly lastAction: string;
}

export class LiveRecording implements Motion {
  readonly mechanisms: string[] = [];
  private current: BranchData = { frames: [], events: [], phases: [] };
  private readonly others = new Map<number, BranchData>();

  constructor(
    readonly model: Model,
    public topology: Topology,
    first: Frame,
  ) {
    this.addTopology(first.time, topology);
    this.addFrame(first);
  }

  get frames() {
    return this.current.frames.length;
  }
  get events() {
    return this.current.events;
  }
  get phases() {
    return this.current.phases;
  }
  get last(): Frame {
    return this.frame(this.frames - 1);
  }
  get otherBranches(): OtherBranch[] {
    return [...this.others].map(([number, { frames, events }]) => ({
      number,
      end: frames[frames.length - 1].time,
      lastAction: events.length > 0 ? (events[events.length - 1].actions[0] ?? textOf(events[events.length - 1])) : "no events",
    }));
  }

  frame(number: number): Frame {
    return this.current.frames[number];
  }
  time(frame: number) {
    return this.frame(frame).time;
  }
  poses(frame: number) {
    return this.frame(frame).poses;
  }
  contacts(frame: number): ContactForce[] {
    const numbers = this.frame(frame).contacts;
    return Array.from({ length: numbers.length / contactForceSize }, (_, c) => {
      const [x, y, z, fx, fy, fz] = numbers.subarray(contactForceSize * c);
      return { point: [x, y, z], force: [fx, fy, fz] };
    });
  }
  totals(frame: number): WorldTotals {
    return this.frame(frame).totals;
  }

  addFrame(frame: Frame) {
    const { frames } = this.current;
    // At the instant of a change, the recording shows the state after it.
    if (frames.length > 0 && frames[frames.length - 1].time >= frame.time) frames.pop();
    frames.push(frame);
  }

  /** Shows nothing before a frame: what was there is too old to go on from. */
  beginAt(frame: Frame) {
    this.addFrame(frame);
    this.forget(this.frames - 1);
  }

  /** Removes the oldest frames. */
  forget(frames: number) {
    const { current } = this;
    current.frames.splice(0, frames);
    const from = current.frames[0].time;
    while (current.phases.length > 1 && current.phases[1].from <= from) current.phases.shift();
  }

  addTopology(time: number, topology: Topology) {
    this.topology = topology;
    const mechanism = new Int32Array(this.model.bodies.length).fill(-1);
    for (const { name, bodies } of topology.mechanisms) {
      let number = this.mechanisms.indexOf(name);
      if (number < 0) number = this.mechanisms.push(name) - 1;
      for (const body of bodies) mechanism[body] = number;
    }
    const joints = topology.joints.map(({ at, child_at, locked, ...joint }) => ({
      ...joint,
      at: at.xyz,
      childAt: child_at.xyz,
      locked: locked !== 0,
    }));
    const { phases } = this.current;
    const before = phases[phases.length - 1]?.joints ?? [];
    while (phases.length > 0 && phases[phases.length - 1].from >= time) phases.pop();
    const broken = topology.broken_springs ?? [];
    const springs = (this.model.springs ?? []).filter(({ name }) => !broken.includes(name));
    phases.push({ from: time, mechanism, joints: withHistory(joints, before), springs });
  }

  addEvents(events: readonly RunEvent[]) {
    this.current.events.push(...events);
  }

  /** Removes everything after `time`, and all but the first `events`; it remains in the branch with that number. */
  rewind(time: number, events: number, savedAs: number) {
    this.others.set(savedAs, this.current);
    const { frames, phases } = this.current;
    this.current = {
      frames: frames.slice(0, lastNotAfter(frames.length, (i) => frames[i].time, time) + 1),
      phases: phases.filter((phase, i) => i === 0 || phase.from <= time),
      events: this.current.events.slice(0, events),
    };
  }

  /** Continues a branch; the present one gets a number. */
  resume(branch: number, savedAs: number) {
    const data = this.others.get(branch);
    if (!data) return;
    this.others.delete(branch);
    this.others.set(savedAs, this.current);
    this.current = data;
  }
}
