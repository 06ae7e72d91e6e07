// The world of an engine, its recording here, and the reader's actions on it.
import type { Diagnostic, ScenarioInfo, Topology } from "../../../wasm/host.mjs";
import { LiveRecording } from "../engine/live";
import type { EnginePort, FromWorker, SliderInfo, ToWorker, UserAction } from "../engine/messages";
import type { Meshes } from "../meshes";
import type { Clock } from "../panels/timeline";
import { modelOf } from "../result_files";

type Changed = "world" | "frame" | "branch" | "status" | "sliders";

/** A frame that is later than this after the first that a program tells is the first of the record (s). */
const longestStart = 0.5;

/** Maximum number of frames of a recording: five minutes at 60 per second. */
const mostFrames = 18_000;

export class App implements Clock {
  run: LiveRecording | null = null;
  scenario: ScenarioInfo | null = null;
  text = "";
  playing = false;
  /** The frame that is shown; null: the last one. */
  shownFrame: number | null = null;
  notice = "";
  /** The name of the joint that was last clicked in the picture. */
  chosenJoint: string | null = null;
  private listeners: ((changed: Changed) => void)[] = [];
  private requested: string | null = null;
  /** Whether the world has the floor of this page, or is about to have it. */
  floor = false;
  private playsWhenLoaded = false;
  private ready = false;
  /** Whether the program that has the world has ended: only what was recorded can be shown. */
  ended = false;
  onChecked: (diagnostics: readonly Diagnostic[]) => void = () => undefined;
  onDiagnostics: (diagnostics: readonly Diagnostic[]) => void = () => undefined;

  /** Of the program, on the page of a live view. */
  sliders: readonly SliderInfo[] = [];

  /** `live`: the world is that of a program, which cannot go back. */
  constructor(
    private readonly engine: EnginePort,
    private readonly meshes?: Meshes,
    readonly live = false,
  ) {
    engine.onmessage = ({ data }: MessageEvent<FromWorker>) => this.handle(data);
  }

  listen(listener: (changed: Changed) => void) {
    this.listeners.push(listener);
  }
  private notify(changed: Changed) {
    for (const listener of this.listeners) listener(changed);
  }
  send(message: ToWorker) {
    if (this.ended) return;
    this.engine.postMessage(message);
  }

  /** `play`: whether it starts to move as soon as it is loaded. */
  load(text: string, play = false, floor = false) {
    this.requested = text;
    this.playsWhenLoaded = play;
    this.floor = floor;
    if (this.ready) this.send({ type: "load", text, floor });
    this.notify("status");
  }

  check(text: string) {
    if (this.ready) this.send({ type: "check", text });
  }

  get frame(): number {
    return this.run ? Math.min(this.shownFrame ?? this.run.frames - 1, this.run.frames - 1) : -1;
  }
  get topology(): Topology | null {
    return this.run?.topology ?? null;
  }

  /** Called when the program has ended (true), and when it is there again. */
  end(ended: boolean) {
    this.ended = ended;
    if (ended) this.playing = false;
    this.notify("status");
  }

  play(on: boolean) {
    if (this.ended) return;
    if (on && this.shownFrame !== null && this.run) this.continueFrom(this.run.time(this.frame));
    this.playing = on;
    this.send({ type: "play", on });
    this.notify("status");
  }
  toggle() {
    this.play(!this.playing);
  }
  set speed(factor: number) {
    this.send({ type: "speed", factor });
  }

  pause() {
    if (this.playing) this.play(false);
  }

  get time() {
    return this.run ? this.run.time(this.frame) : 0;
  }
  /** Shows a past instant; playing from there makes another branch. */
  seek(time: number) {
    if (!this.run) return;
    this.pause();
    const { run } = this;
    let frame = run.frames - 1;
    while (frame > 0 && run.time(frame) > time + 1e-9) frame--;
    this.shownFrame = frame === run.frames - 1 ? null : frame;
    this.notify("frame");
  }
  /** Continues from a past instant; a program, which cannot go back, continues from the present. */
  continueFrom(time: number) {
    this.shownFrame = null;
    if (!this.live) this.send({ type: "rewind", time });
  }
  undo(event: number) {
    this.shownFrame = null;
    this.send({ type: "undo", event });
  }
  resumeBranch(branch: number) {
    this.shownFrame = null;
    this.send({ type: "branch", branch });
  }

  act(action: UserAction) {
    if (this.shownFrame !== null && this.run) this.continueFrom(this.run.time(this.frame));
    this.notice = "";
    this.send({ type: "act", action });
  }

  /** What the engine tells. */
  handle(message: FromWorker) {
    const { run } = this;
    switch (message.type) {
      case "ready":
        this.ready = true;
        if (this.requested !== null) this.send({ type: "load", text: this.requested, floor: this.floor });
        return;
      case "loaded": {
        this.onDiagnostics(message.diagnostics);
        if (!message.world) {
          this.floor = this.scenario?.floor ?? false;
          this.showNotice(this.run ? `The scenario has errors: see the editor. This is still “${this.run.model.title}”.` : "");
          return;
        }
        this.scenario = message.world.scenario;
        const asked = this.floor;
        this.floor = this.scenario.floor;
        this.text = this.requested ?? "";
        this.run = new LiveRecording(
          modelOf(message.world.model, undefined, this.meshes),
          message.world.topology,
          message.world.frame,
        );
        this.shownFrame = null;
        this.notice = asked && !this.floor ? "All bodies of this scenario touch its own floor already" : "";
        this.notify("world");
        if (this.playsWhenLoaded) this.play(true);
        this.playsWhenLoaded = false;
        return;
      }
      case "checked":
        return this.onChecked(message.diagnostics);
      case "frame":
        if (!run) return;
        // What a program tells first is its world after the last event: a page that is opened later begins with the present.
        if (this.live && run.frames === 1 && message.frame.time > run.last.time + longestStart) run.beginAt(message.frame);
        else run.addFrame(message.frame);
        if (this.live && run.frames >= mostFrames) {
          run.forget(mostFrames / 4);
          if (this.shownFrame !== null) this.shownFrame = Math.max(0, this.shownFrame - mostFrames / 4);
        } else if (run.frames >= mostFrames && this.playing) {
          this.play(false);
          this.showNotice("The recording is full after five minutes: go back, or restart");
        }
        if (this.shownFrame === null) this.notify("frame");
        return;
      case "topology":
        run?.addTopology(message.time, message.topology);
        return;
      case "events":
        run?.addEvents(message.events);
        return this.notify("branch");
      case "rewound":
        run?.rewind(message.time, message.events, message.savedAs);
        this.shownFrame = null;
        return this.notify("branch");
      case "resumed":
        run?.resume(message.branch, message.savedAs);
        this.shownFrame = null;
        return this.notify("branch");
      case "gravity":
        if (this.scenario) this.scenario = { ...this.scenario, gravity: message.value };
        return this.notify("sliders");
      case "sliders":
        this.sliders = message.sliders;
        return this.notify("sliders");
      case "playing":
        this.playing = message.on;
        if (message.on && this.live) this.shownFrame = null;
        return this.notify("status");
      case "refused":
        return this.showNotice(message.message);
      case "stopped":
        this.playing = false;
        return this.showNotice(message.message);
      case "failed":
        this.playing = false;
        return this.showNotice(`${message.message}${this.run ? ". Load a scenario to start again." : ""}`);
    }
  }

  showNotice(notice: string) {
    this.notice = notice;
    this.notify("status");
  }
}
