// A world that runs in real time, in the worker: frames, snapshots to go back to, branches. It has no clock: the caller
// passes the elapsed time to tick().
import { contactSize, jointSize, motionSize, status, type Engine, type Outcome, type World } from "../../../wasm/host.mjs";
import { isContact } from "../contacts";
import type { RunEvent } from "../recording";
import type { ModelFile } from "../result_files";
import { contactForceSize, loadSize, type Frame, type FromWorker, type ToWorker, type UserAction } from "./messages";

/** Interval of snapshots (s of simulated time), and frames per second of simulated time. */
const snapshotInterval = 0.25;
const framesPerSecond = 60;
/** The part of the page's frame time that the engine may use (s). */
const budget = 0.012;
/** A world that needs more than this for a thousandth of a frame makes no progress (s). */
const patience = 4;

interface TimedSnapshot {
  readonly time: number;
  readonly snapshot: number;
}

interface Branch {
  readonly world: World;
  readonly snapshots: TimedSnapshot[];
  /**
   * Frame times: a run that goes back and continues stops at the same instants as before, and so yields the same bits.
   */
  readonly times: number[];
}

/** Per body x, y, z, qw, qx, qy, qz. */
export function posesOf(motions: Float64Array): Float32Array {
  const bodies = motions.length / motionSize;
  const poses = new Float32Array(7 * bodies);
  for (let b = 0; b < bodies; b++) poses.set(motions.subarray(motionSize * b, motionSize * b + 7), 7 * b);
  return poses;
}

function contactForces(world: World): Float32Array {
  const rows = world.contacts();
  const count = rows.length / contactSize;
  const forces = new Float32Array(contactForceSize * count);
  for (let c = 0; c < count; c++) {
    forces.set(rows.subarray(contactSize * c + 2, contactSize * c + 5), contactForceSize * c);
    forces.set(rows.subarray(contactSize * c + 8, contactSize * c + 11), contactForceSize * c + 3);
  }
  return forces;
}

export function frameOf(world: World): Frame {
  const poses = posesOf(world.motions());
  const rows = world.joints(true);
  const count = rows.length / jointSize;
  const loads = new Float32Array(loadSize * count);
  for (let j = 0; j < count; j++) {
    const row = rows.subarray(jointSize * j, jointSize * (j + 1));
    const [fx, fy, fz] = row.subarray(21, 24);
    loads.set(row[0] < 0 ? [NaN, NaN, 1, NaN, NaN, NaN] : [row[27], Math.hypot(fx, fy, fz), row[28], fx, fy, fz], loadSize * j);
  }
  return { time: world.time, poses, loads, totals: world.totals(), contacts: contactForces(world) };
}

export class Session {
  private world: World;
  private snapshots: TimedSnapshot[] = [];
  private times: number[] = [];
  /** Branches that were left, by number; null: continued. */
  private branches: (Branch | null)[] = [];
  private speed = 1;
  private playing = false;
  /** Simulated time that is due (s). */
  private due = 0;
  private step = 1e-3;
  private revision = -1;
  private eventsPosted = 0;
  /** When the world last made progress: its time, and how long it has computed since (s). */
  private progress = { time: 0, seconds: 0 };

  constructor(
    private readonly engine: Engine,
    private readonly post: (message: FromWorker) => void,
  ) {
    this.world = engine.world();
  }

  handle(message: ToWorker) {
    switch (message.type) {
      case "module":
        return;
      case "load":
        return this.load(message.text, message.floor ?? false);
      case "check":
        return this.check(message.text);
      case "play":
        this.playing = message.on;
        this.due = 0;
        return;
      case "speed":
        this.speed = message.factor;
        return;
      case "act":
        return this.change(() => this.act(message.action));
      case "gravity":
        return this.change(() => this.world.setGravity(message.value));
      case "damping":
        return this.change(() => this.world.setDamping(message.factor, message.offset));
      case "strength":
        return this.change(() => this.world.limitStrength(message.force));
      case "grab":
        return this.change(() => {
          const outcome = this.world.grab(message.body, message.point);
          this.world.pull(message.target);
          return outcome;
        });
      case "pull":
        return this.world.pull(message.target);
      case "release":
        return this.world.releaseGrip();
      case "rewind":
        return this.rewind(message.time);
      case "undo":
        return this.undo(message.event);
      case "set": {
        const { joint, damping, stiffness } = message;
        return this.change(() =>
          this.world.set(joint, { ...(damping !== undefined && { damping }), ...(stiffness !== undefined && { stiffness }) }),
        );
      }
      case "branch":
        return this.resume(message.branch);
      case "slider":
      case "stop":
        return; // only programs have them
    }
  }

  /** `seconds` of wall-clock time have passed. */
  tick(seconds: number) {
    if (!this.playing) return;
    // Computation that was not finished in time is not caught up on: the simulation is slower then.
    this.due = Math.min(this.due + seconds * this.speed, 2 / framesPerSecond);
    const frame = Math.min(1, this.speed) / framesPerSecond;
    if (this.due < 0.999 * frame) return;
    const began = performance.now();
    // Stops at whole steps, so that the run is the same as without a page.
    const from = this.world.time;
    const target =
      Math.max(Math.floor((from + this.due) / this.step + 1e-6), Math.floor(from / this.step + 1e-6) + 1) * this.step;
    const outcome = this.world.run(target, budget);
    this.due = outcome.status === status.interrupted ? 0 : Math.max(0, this.due - (this.world.time - from));
    const used = (performance.now() - began) / 1000;
    this.report(used);
    if (outcome.status === status.diverged || outcome.status === status.refused) return this.stop(outcome.message);
    this.progress.seconds += used;
    if (this.world.time < this.progress.time || this.world.time > this.progress.time + 1e-3 * frame)
      this.progress = { time: this.world.time, seconds: 0 };
    if (this.progress.seconds > patience) {
      this.progress.seconds = 0;
      this.stop(`No progress at t = ${this.world.time.toPrecision(6)} s: too much happens at once. Go back, or restart.`);
    }
  }

  private load(text: string, floor: boolean) {
    const fresh = this.engine.world();
    const { scenario, diagnostics } = fresh.load(text, { floor });
    if (!scenario) {
      fresh.destroy();
      return this.post({ type: "loaded", diagnostics, world: null });
    }
    for (const world of [this.world, ...this.branches.map((branch) => branch?.world)]) world?.destroy();
    this.world = fresh;
    this.snapshots = [];
    this.times = [];
    this.branches = [];
    this.step = scenario.step;
    this.eventsPosted = 0;
    this.due = 0;
    this.revision = this.world.revision;
    this.takeSnapshot();
    const model = this.world.model() as ModelFile;
    const world = { scenario, model, topology: this.world.topology(), frame: frameOf(this.world) };
    this.post({ type: "loaded", diagnostics, world });
  }

  private check(text: string) {
    const other = this.engine.world();
    const { diagnostics } = other.load(text);
    other.destroy();
    this.post({ type: "checked", diagnostics });
  }

  private act(user: UserAction): Outcome {
    return user.action === "weld" ? this.world.weld(user.body, user.to) : this.world[user.action](user.joint);
  }

  private change(make: () => Outcome) {
    this.takeSnapshot();
    const outcome = make();
    if (outcome.status === status.refused) this.post({ type: "refused", message: outcome.message });
    this.report(0);
  }

  private takeSnapshot() {
    this.snapshots.push({ time: this.world.time, snapshot: this.world.snapshot() });
  }

  private report(seconds: number) {
    const { world } = this;
    const events = world.eventCount > this.eventsPosted ? (world.events(this.eventsPosted) as RunEvent[]) : [];
    if (world.revision !== this.revision) {
      this.revision = world.revision;
      // Contacts do not change the topology, and there may be many.
      if (events.length === 0 || !events.every(isContact))
        this.post({ type: "topology", time: world.time, topology: world.topology() });
    }
    if (events.length > 0) this.post({ type: "events", events });
    this.eventsPosted = world.eventCount;
    this.post({ type: "frame", frame: frameOf(world), seconds });
    if (world.time > (this.times[this.times.length - 1] ?? -1)) this.times.push(world.time);
    if (world.time >= this.snapshots[this.snapshots.length - 1].time + snapshotInterval) this.takeSnapshot();
  }

  private stop(message: string) {
    this.playing = false;
    this.post({ type: "playing", on: false });
    this.post({ type: "stopped", message });
  }

  /** The last snapshot that is not after a time, or the first one. */
  private snapshotBefore(time: number, strictly: boolean): number {
    const earlier = this.snapshots.filter((each) => (strictly ? each.time < time : each.time <= time));
    return (earlier[earlier.length - 1] ?? this.snapshots[0]).snapshot;
  }

  /** Keeps the present run as a separate branch; returns its number. */
  private keepBranch(): number {
    const branch = { world: this.world.branch(), snapshots: [...this.snapshots], times: [...this.times] };
    return this.branches.push(branch) - 1;
  }

  private reportRewound(savedAs: number) {
    const { time } = this.world;
    this.snapshots = this.snapshots.filter((each) => each.time <= time);
    this.times = this.times.filter((each) => each <= time);
    if (this.snapshots.length === 0) this.takeSnapshot();
    this.due = 0;
    this.eventsPosted = this.world.eventCount;
    this.post({ type: "rewound", time, events: this.eventsPosted, savedAs });
    this.report(0);
  }

  private rewind(time: number) {
    if (time >= this.world.time) return;
    const savedAs = this.keepBranch();
    this.world.restore(this.snapshotBefore(time, false));
    for (const each of this.times) if (each > this.world.time && each <= time) this.world.run(each);
    this.reportRewound(savedAs);
  }

  private undo(event: number) {
    const [undone] = this.world.events(event) as RunEvent[];
    const savedAs = this.keepBranch();
    if (this.world.undo(event).status === status.refused && undone) this.world.restore(this.snapshotBefore(undone.time, true));
    this.reportRewound(savedAs);
  }

  private resume(number: number) {
    const branch = this.branches[number];
    if (!branch) return;
    const savedAs = this.branches.push({ world: this.world, snapshots: this.snapshots, times: this.times }) - 1;
    this.world = branch.world;
    this.snapshots = branch.snapshots;
    this.times = branch.times;
    this.branches[number] = null;
    this.due = 0;
    this.eventsPosted = this.world.eventCount;
    this.post({ type: "resumed", branch: number, savedAs });
    this.report(0);
  }
}
