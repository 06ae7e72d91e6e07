// Where the mechanisms were, at even times up to now, faded: the picture of the paper's Figure 3 as it comes about.
import type { Recording } from "../recording";
import type { Theme } from "./colours";
import { endTime, phaseAt, posesAt, startTime } from "./frames";
import { MechanismsView } from "./mechanisms";
import type { Stage } from "./stage";

/** Time between ghosts (s): 0.2 as in the paper, or a round number where that gives too few or too many of them. */
export function ghostSpacing(span: number): number {
  if (span >= 4 * 0.2 && span <= 60 * 0.2) return 0.2;
  for (let unit = 1e-9; unit < 1e9; unit *= 10)
    for (const step of [1, 2, 5]) if (span / (step * unit) <= 32) return step * unit;
  return span / 10;
}

export class Ghosts {
  private readonly views: { time: number; view: MechanismsView }[] = [];
  private shown = true;
  private theme: Theme | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly run: Recording,
    readonly every: number = ghostSpacing(endTime(run) - startTime(run)),
  ) {
    const first = startTime(run);
    for (let k = 0; first + k * this.every <= endTime(run) + 1e-9 && k < 200; k++) {
      const view = new MechanismsView(run.model, stage.shapes, { faded: 0.7, pixels: 2, joints: false });
      view.group.visible = false;
      stage.scene.add(view.group);
      this.views.push({ time: first + k * this.every, view });
    }
    stage.whenThemed((theme) => this.place(theme));
    stage.whenDrawn((camera, height) => {
      for (const { view } of this.views) if (view.group.visible) view.fit(camera, height);
    });
  }

  get visible() {
    return this.shown;
  }
  set visible(wanted: boolean) {
    this.shown = wanted;
    if (!wanted) for (const { view } of this.views) view.group.visible = false;
    this.stage.draw();
  }

  private place(theme: Theme) {
    this.theme = theme;
    for (const { time, view } of this.views) {
      const poses = new Float64Array(7 * this.run.model.bodies.length);
      view.place(posesAt(this.run, time, poses), phaseAt(this.run, time), theme);
    }
  }

  /** Those up to a time; one that is where the bodies are now is left out. */
  show(time: number) {
    if (!this.shown || !this.theme) return;
    for (const ghost of this.views) ghost.view.group.visible = ghost.time < time - 0.1 * this.every;
  }

  dispose() {
    for (const { view } of this.views) view.dispose();
  }
}
