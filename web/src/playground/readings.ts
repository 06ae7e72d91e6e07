// Numerical data of the running world: plots of energy and momentum, and the momenta at the instant shown.
import type { LiveRecording } from "../engine/live";
import { h } from "../panels/dom";
import { digits } from "../panels/numbers";
import { momentumScale, reachOf } from "../panels/scales";
import { massOf } from "../recording";
import type { Theme } from "../viewer/colours";
import { Chart } from "./chart";

/** Minimum time between two redraws while frames arrive (ms). */
const pause = 120;

/** The largest kinetic energy in these frames (J). */
function largestKinetic(run: LiveRecording, from: number, to: number): number {
  let kinetic = 0;
  for (let frame = from; frame <= to; frame++) kinetic = Math.max(kinetic, run.totals(frame).kinetic);
  return kinetic;
}

/** The scale of momenta in these frames (N s). */
const momentumIn = (run: LiveRecording, from: number, to: number) =>
  momentumScale(massOf(run.model.bodies), largestKinetic(run, from, to));

/**
 * The error of the energy balance, with a suggested remedy if it has grown by more than a thousandth of the kinetic energy since
 * the first frame: a page may be opened long after the start of a run.
 */
function balanceText(error: number, before: number, kinetic: number, potential: number): string {
  const growth = Math.abs(error - before);
  const share = growth > 1e-9 * Math.abs(potential) && kinetic > 0 ? growth / kinetic : 0;
  const text = digits(error, 3);
  return share > 1e-3 ? `${text}: ${digits(100 * share, 2)} % of the kinetic energy; use a smaller step` : text;
}

/** The components in one line; round-off relative to `scale` is shown as zero. */
const vector = (v: readonly number[], scale: number) =>
  v.map((x) => digits(Math.abs(x) <= 1e-12 * scale ? 0 : x, 5)).join("  ");

export class Readings {
  private readonly energy = new Chart(
    "Energy",
    "J",
    [
      { label: "kinetic", of: (t) => t.kinetic },
      { label: "potential", of: (t) => t.potential },
      { label: "total", of: (t) => t.kinetic + t.potential },
    ],
    () => 0,
  );
  private readonly momentum = new Chart(
    "Momentum",
    "N s",
    [
      { label: "x", of: (t) => t.linear[0] },
      { label: "y", of: (t) => t.linear[1] },
      { label: "z", of: (t) => t.linear[2] },
    ],
    momentumIn,
  );
  private readonly readout = h("dl", { class: "readout", "aria-label": "Momentum" });
  readonly element = h("div", { class: "plots" }, this.energy.element, this.momentum.element, this.readout);
  private drawn = 0;

  setTheme(theme: Theme) {
    this.energy.setTheme(theme);
    this.momentum.setTheme(theme);
  }

  /** Updates up to a frame; without `immediately`, at most as often as a reader can follow. */
  show(run: LiveRecording, frame: number, immediately: boolean) {
    const now = performance.now();
    if (!immediately && now - this.drawn < pause) return;
    this.drawn = now;
    this.energy.show(run, frame);
    this.momentum.show(run, frame);
    const { linear, angular, balance, potential } = run.totals(frame);
    const kinetic = largestKinetic(run, 0, frame);
    const size = momentumScale(massOf(run.model.bodies), kinetic);
    const rows: [string, string][] = [
      ["Linear momentum (N s)", vector(linear, size)],
      ["Angular momentum (N m s)", vector(angular, size * reachOf(run.model, run.poses(frame)))],
      ["Energy balance, error (J)", balanceText(balance.error, run.totals(0).balance.error, kinetic, potential)],
      ...(balance.projection === 0 ? [] : [["By loops, overlaps (J)", digits(balance.projection, 3)] as [string, string]]),
    ];
    this.readout.replaceChildren(...rows.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
  }
}
