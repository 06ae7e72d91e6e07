// The playground: the engine's world in the worker, its recording here, and the reader's actions on it.
import type { Diagnostic, Topology } from "../../../wasm/host.mjs";
import { LiveRecording } from "../engine/live";
import type { Act, FromWorker, ToWorker } from "../engine/messages";
import type { Body, Model } from "../recording";
import { modelOf } from "../report/data";

type Changed = "world" | "frame" | "line" | "status";

/** Maximum number of frames of a recording: five minutes at 60 per second. */
const mostFrames = 18_000;

export class App {
  run: LiveRecording | null = null;
  scenario: NonNullable<Extract<FromWorker, { say: "loaded" }>["scenario"]> | null = null;
  text = "";
  playing = false;
  /** The frame that is shown; null: always the last one. */
  looking: number | null = null;
  notice = "";
  /** Time that the engine used for the last frame (s). */
  engineSeconds = 0;
  private listeners: ((changed: Changed) => void)[] = [];
  private wanted: string | null = null;
  private ready = false;
  onChecked: (diagnostics: readonly Diagnostic[]) => void = () => undefined;
  onDiagnostics: (message: Extract<FromWorker, { say: "loaded" }>) => void = () => undefined;

  constructor(
    private readonly worker: Worker,
    module: ArrayBuffer,
  ) {
    worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.hear(data);
    worker.onerror = (event) => this.say(`The engine can't start: ${event.message || "its worker is blocked"}`);
    worker.postMessage({ say: "module", bytes: module } satisfies ToWorker, [module]);
  }

  listen(listener: (changed: Changed) => void) {
    this.listeners.push(listener);
  }
  private tell(changed: Changed) {
    for (const listener of this.listeners) listener(changed);
  }
  send(message: ToWorker) {
    this.worker.postMessage(message);
  }

  load(text: string) {
    this.wanted = text;
    if (this.ready) this.send({ say: "load", text });
  }

  check(text: string) {
    if (this.ready) this.send({ say: "check", text });
  }

  get frame(): number {
    return this.run ? Math.min(this.looking ?? this.run.frames - 1, this.run.frames - 1) : -1;
  }
  get topology(): Topology | null {
    return this.run?.topology ?? null;
  }

  play(on: boolean) {
    if (on && this.looking !== null && this.run) this.goOnFrom(this.run.time(this.frame));
    this.playing = on;
    this.send({ say: "play", on });
    this.tell("status");
  }
  toggle() {
    this.play(!this.playing);
  }
  speed(factor: number) {
    this.send({ say: "speed", factor });
  }

  /** Shows a past instant; playing from there makes another branch. */
  look(time: number) {
    if (!this.run) return;
    if (this.playing) this.play(false);
    const { run } = this;
    let frame = run.frames - 1;
    while (frame > 0 && run.time(frame) > time + 1e-9) frame--;
    this.looking = frame === run.frames - 1 ? null : frame;
    this.tell("frame");
  }
  goOnFrom(time: number) {
    this.looking = null;
    this.send({ say: "rewind", time });
  }
  undo(event: number) {
    this.looking = null;
    this.send({ say: "undo", event });
  }
  goToBranch(branch: number) {
    this.looking = null;
    this.send({ say: "branch", branch });
  }

  act(act: Act) {
    if (this.looking !== null && this.run) this.goOnFrom(this.run.time(this.frame));
    this.notice = "";
    this.send({ say: "act", act });
  }

  private hear(message: FromWorker) {
    const { run } = this;
    switch (message.say) {
      case "ready":
        this.ready = true;
        if (this.wanted !== null) this.send({ say: "load", text: this.wanted });
        return;
      case "loaded":
        this.onDiagnostics(message);
        if (!message.scenario || !message.topology || !message.frame) {
          this.say(this.run ? `The scenario has errors: see the editor. This is still “${this.run.model.title}”.` : "");
          return;
        }
        this.scenario = message.scenario;
        this.text = this.wanted ?? "";
        this.run = new LiveRecording(modelFrom(message.model), message.topology, message.frame);
        this.looking = null;
        this.notice = "";
        return this.tell("world");
      case "checked":
        return this.onChecked(message.diagnostics);
      case "frame":
        if (!run) return;
        run.addFrame(message.frame);
        if (message.seconds > 0) this.engineSeconds = message.seconds;
        if (run.frames >= mostFrames && this.playing) {
          this.play(false);
          this.say("Five minutes are recorded: go back, or start again");
        }
        if (this.looking === null) this.tell("frame");
        return;
      case "topology":
        run?.addTopology(message.time, message.topology);
        return;
      case "events":
        run?.addEvents(message.events);
        return this.tell("line");
      case "went back":
        run?.goBack(message.time, message.events, message.left);
        this.looking = null;
        return this.tell("line");
      case "branched":
        run?.goOn(message.branch, message.left);
        this.looking = null;
        return this.tell("line");
      case "playing":
        this.playing = message.on;
        return this.tell("status");
      case "refused":
        return this.say(message.message);
      case "stopped":
        this.playing = false;
        return this.say(message.message);
      case "failed":
        this.playing = false;
        return this.say(`${message.message}${this.run ? ". Load a scenario to start again." : ""}`);
    }
  }

  say(notice: string) {
    this.notice = notice;
    this.tell("status");
  }
}

function modelFrom(file: unknown): Model {
  const model = file as Parameters<typeof modelOf>[0];
  return modelOf(model, Object.keys(model.bodies));
}

/** Of the bodies, for sliders that fit the scale of the mechanism. */
export const massOf = (bodies: readonly Body[]) => bodies.reduce((sum, body) => sum + body.mass, 0);
