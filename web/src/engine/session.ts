// A world that runs in real time, in the worker: frames, snapshots to go back to, branches. It has no clock: the caller
// of tick() says how much time has passed.
import { jointSize, motionSize, status, type Engine, type Outcome, type World } from "../../../wasm/host.mjs";
import type { Act, Frame, FromWorker, ToWorker } from "./messages";

/** Interval of snapshots (s of simulated time), and frames per second of simulated time. */
const snapshotEvery = 0.25;
const framesPerSecond = 60;
/** The part of the page's frame time that the engine may use (s). */
const budget = 0.012;

interface Kept {
  readonly time: number;
  readonly snapshot: number;
}

interface Branch {
  readonly world: World;
  readonly kept: Kept[];
  readonly times: number[];
}

export class Session {
  private world: World;
  private kept: Kept[] = [];
  /**
   * Frame times: a run that goes back and continues stops at the same instants as before, and so yields the same bits.
   */
  private times: number[] = [];
  private left: (Branch | null)[] = [];
  private speed = 1;
  private playing = false;
  private owed = 0;
  private step = 1e-3;
  private revision = -1;
  private told = 0;

  constructor(
    private readonly engine: Engine,
    private readonly tell: (message: FromWorker) => void,
  ) {
    this.world = engine.world();
  }

  get runs() {
    return this.playing;
  }

  hear(message: ToWorker) {
    switch (message.say) {
      case "module":
        return;
      case "load":
        return this.load(message.text);
      case "check":
        return this.check(message.text);
      case "play":
        this.playing = message.on;
        this.owed = 0;
        return;
      case "speed":
        this.speed = message.factor;
        return;
      case "act":
        return this.change(() => this.act(message.act));
      case "gravity":
        return this.change(() => this.world.setGravity(message.value));
      case "damping":
        return this.change(() => this.world.setDamping(message.factor, message.offset));
      case "grab":
        return this.change(() => {
          const outcome = this.world.grab(message.body, message.point);
          this.world.pull(message.target);
          return outcome;
        });
      case "pull":
        return this.world.pull(message.target);
      case "let go":
        return this.world.letGo();
      case "rewind":
        return this.rewind(message.time);
      case "undo":
        return this.undo(message.event);
      case "branch":
        return this.goOn(message.branch);
    }
  }

  /** `seconds` of wall-clock time have passed. */
  tick(seconds: number) {
    if (!this.playing) return;
    // Computation that was not finished in time is not caught up on: the simulation is slower then.
    this.owed = Math.min(this.owed + seconds * this.speed, 2 / framesPerSecond);
    const frame = Math.min(1, this.speed) / framesPerSecond;
    if (this.owed < 0.999 * frame) return;
    const began = performance.now();
    // Stops at whole steps, so that the run is the same as without a page.
    const from = this.world.time;
    const target =
      Math.max(Math.floor((from + this.owed) / this.step + 1e-6), Math.floor(from / this.step + 1e-6) + 1) * this.step;
    const outcome = this.world.run(target, budget);
    this.owed = outcome.status === status.interrupted ? 0 : Math.max(0, this.owed - (this.world.time - from));
    this.report((performance.now() - began) / 1000);
    if (outcome.status === status.diverged || outcome.status === status.refused) this.stop(outcome.message);
  }

  private load(text: string) {
    const fresh = this.engine.world();
    const { scenario, diagnostics } = fresh.load(text);
    if (!scenario) {
      fresh.destroy();
      this.tell({ say: "loaded", diagnostics, scenario, model: null, topology: null, frame: null });
      return;
    }
    for (const world of [this.world, ...this.left.map((branch) => branch?.world)]) world?.destroy();
    this.world = fresh;
    this.kept = [];
    this.times = [];
    this.left = [];
    this.step = scenario.step;
    this.told = 0;
    this.owed = 0;
    this.revision = this.world.revision;
    this.keep();
    const topology = this.world.topology();
    this.tell({ say: "loaded", diagnostics, scenario, model: this.world.model(), topology, frame: this.frame() });
  }

  private check(text: string) {
    const other = this.engine.world();
    const { diagnostics } = other.load(text);
    other.destroy();
    this.tell({ say: "checked", diagnostics });
  }

  private act(act: Act): Outcome {
    switch (act.do) {
      case "cut":
        return this.world.cut(act.joint);
      case "free":
        return this.world.free(act.joint);
      case "lock":
        return this.world.lock(act.joint);
      case "unlock":
        return this.world.unlock(act.joint);
      case "weld":
        return this.world.weld(act.body, act.to);
      case "change":
        return this.world.change(act.joint, act.kind);
    }
  }

  private change(make: () => Outcome) {
    this.keep();
    const outcome = make();
    if (outcome.status === status.refused) this.tell({ say: "refused", message: outcome.message });
    this.report(0);
  }

  private keep() {
    this.kept.push({ time: this.world.time, snapshot: this.world.snapshot() });
  }

  private frame(): Frame {
    const { world } = this;
    const bodies = world.bodies;
    const poses = new Float32Array(7 * bodies);
    const motions = world.motions();
    for (let b = 0; b < bodies; b++) for (let i = 0; i < 7; i++) poses[7 * b + i] = motions[motionSize * b + i];
    const loads = new Float32Array(2 * bodies);
    const rows = world.joints(true);
    for (let j = 0; j < bodies; j++) {
      const row = jointSize * j;
      loads[2 * j] = rows[row] < 0 ? NaN : rows[row + 27];
      loads[2 * j + 1] = rows[row] < 0 ? NaN : Math.hypot(rows[row + 21], rows[row + 22], rows[row + 23]);
    }
    return { time: world.time, poses, loads, totals: world.totals() };
  }

  private report(seconds: number) {
    const { world } = this;
    if (world.revision !== this.revision) {
      this.revision = world.revision;
      this.tell({ say: "topology", time: world.time, topology: world.topology() });
    }
    if (world.eventCount > this.told) this.tell({ say: "events", events: world.events(this.told) });
    this.told = world.eventCount;
    this.tell({ say: "frame", frame: this.frame(), seconds });
    if (world.time > (this.times[this.times.length - 1] ?? -1)) this.times.push(world.time);
    if (world.time >= this.kept[this.kept.length - 1].time + snapshotEvery) this.keep();
  }

  private stop(message: string) {
    this.playing = false;
    this.tell({ say: "playing", on: false });
    this.tell({ say: "stopped", message });
  }

  /** Keeps the present run as a separate branch; returns its number. */
  private leave(): number {
    return this.left.push({ world: this.world.branch(), kept: [...this.kept], times: [...this.times] }) - 1;
  }

  private wentBack(left: number) {
    const { time } = this.world;
    this.kept = this.kept.filter((kept) => kept.time <= time);
    this.times = this.times.filter((each) => each <= time);
    if (this.kept.length === 0) this.keep();
    this.owed = 0;
    this.told = this.world.eventCount;
    this.tell({ say: "went back", time, events: this.told, left });
    this.report(0);
  }

  private rewind(time: number) {
    if (time >= this.world.time) return;
    const from = [...this.kept].reverse().find((kept) => kept.time <= time) ?? this.kept[0];
    const left = this.leave();
    this.world.restore(from.snapshot);
    for (const each of this.times) if (each > this.world.time && each <= time) this.world.run(each);
    this.wentBack(left);
  }

  private undo(event: number) {
    const events = this.world.events(event);
    const left = this.leave();
    if (this.world.undo(event).status === status.refused && events.length > 0) {
      const time = Number(events[0].time);
      const from = [...this.kept].reverse().find((kept) => kept.time < time) ?? this.kept[0];
      this.world.restore(from.snapshot);
    }
    this.wentBack(left);
  }

  private goOn(number: number) {
    const branch = this.left[number];
    if (!branch) return;
    const left = this.left.push({ world: this.world, kept: this.kept, times: this.times }) - 1;
    this.world = branch.world;
    this.kept = branch.kept;
    this.times = branch.times;
    this.left[number] = null;
    this.owed = 0;
    this.told = this.world.eventCount;
    this.tell({ say: "branched", branch: number, left });
    this.report(0);
  }
}
