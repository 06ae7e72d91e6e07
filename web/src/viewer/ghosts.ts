// Earlier poses of the mechanisms at regular intervals up to now, faded: the picture of the paper's Figure 3 as it
// develops.
import type { Motion } from "../recording";
import type { Theme } from "./colours";
import { endTime, frameAt, phaseAt, posesAt, startTime } from "./frames";
import { MechanismsView } from "./mechanisms";
import type { Stage } from "./stage";

/** Interval of ghosts (s): 0.2 as in the paper, or a round number if that gives too few or too many of them. */
export function ghostSpacing(span: number): number {
  if (span >= 4 * 0.2 && span <= 60 * 0.2) return 0.2;
  for (let unit = 1e-9; unit < 1e9; unit *= 10)
    for (const step of [1, 2, 5]) if (span / (step * unit) <= 32) return step * unit;
  return span / 10;
}

/** Times of ghosts: only at frames of the run, the first one at or after each multiple of the interval. */
export function ghostTimes(run: Motion, every: number): number[] {
  const times: number[] = [];
  const [first, last] = [startTime(run), endTime(run)];
  for (let k = 0; first + k * every <= last + 1e-9 && k < 200; k++) {
    const target = first + k * every - 1e-9;
    const before = frameAt(run, target);
    const frame = run.time(before) < target ? Math.min(before + 1, run.frames - 1) : before;
    const time = run.time(frame);
    if (time !== times[times.length - 1]) times.push(time);
  }
  return times;
}

export class Ghosts {
  private readonly views: { time: number; view: MechanismsView }[] = [];
  private shown = true;
  private theme: Theme | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly run: Motion,
    readonly every: number = ghostSpacing(endTime(run) - startTime(run)),
  ) {
    for (const time of run.frames > 0 ? ghostTimes(run, this.every) : []) {
      const view = new MechanismsView(run.model, stage.shapes, { faded: 0.7, pixels: 2, joints: false });
      view.group.visible = false;
      stage.scene.add(view.group);
      this.views.push({ time, view });
    }
    stage.onThemeChange((theme) => this.place(theme));
    stage.onDraw((camera, height) => {
      for (const { view } of this.views) if (view.group.visible) view.fit(camera, height);
    });
  }

  get visible() {
    return this.shown;
  }
  set visible(visible: boolean) {
    this.shown = visible;
    if (!visible) for (const { view } of this.views) view.group.visible = false;
    this.stage.draw();
  }

  private place(theme: Theme) {
    this.theme = theme;
    for (const { time, view } of this.views) {
      const poses = new Float64Array(7 * this.run.model.bodies.length);
      view.ownColours = this.stage.ownColours;
      view.place(posesAt(this.run, time, poses), phaseAt(this.run, time), theme);
    }
  }

  /** Shows ghosts up to a time; one that coincides with the present bodies is omitted. */
  show(time: number) {
    if (!this.shown || !this.theme) return;
    for (const ghost of this.views) ghost.view.group.visible = ghost.time < time - 0.1 * this.every;
  }

  dispose() {
    for (const { view } of this.views) view.dispose();
  }
}
