// The picture with what stands on it: names of mechanisms in their colours, and what can be switched on and off.
import type { Recording } from "../recording";
import { mechanismColour } from "../viewer/colours";
import { endTime, phaseAt, posesAt, startTime } from "../viewer/frames";
import { Ghosts } from "../viewer/ghosts";
import type { Player } from "../viewer/player";
import { Stage } from "../viewer/stage";
import { Trails } from "../viewer/trails";
import { h } from "./dom";
import { count, instant } from "./numbers";

export class Picture {
  readonly element = h("section", { class: "picture", "aria-label": "Picture" });
  readonly stage: Stage;
  readonly ghosts: Ghosts;
  readonly trails: Trails;
  private readonly names = h("ul", { class: "names", "aria-label": "Mechanisms" });
  private readonly spoken = h("p", { class: "hidden-text", "aria-live": "polite" });
  private readonly poses: Float64Array;
  private named = "";

  /** `choose`: a body was clicked. `still`: there is no motion, and so no ghosts and no trails. */
  constructor(
    private readonly run: Recording,
    private readonly player: Player,
    private readonly choose: (body: number) => void,
    private readonly options: { readonly still?: boolean } = {},
  ) {
    const host = h("div", { class: "stage" });
    this.element.append(host);
    this.stage = new Stage(host, run.model);
    this.ghosts = new Ghosts(this.stage, run);
    this.trails = new Trails(this.stage, run);
    this.poses = new Float64Array(7 * run.model.bodies.length);
    host.append(h("div", { class: "over" }, this.names, this.tools()), this.spoken);
    this.stage.whenThemed(() => (this.named = ""));
    const { canvas } = this.stage;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.addEventListener("keydown", (event) => this.onKey(event));
    this.listenToClicks(canvas);
    player.listen((time) => this.show(time));
    this.stage.fit(run);
  }

  private switch(label: string, title: string, target: { visible: boolean }): HTMLButtonElement {
    const button = h("button", { type: "button", title, "aria-pressed": String(target.visible) }, label);
    button.addEventListener("click", () => {
      target.visible = !target.visible;
      button.setAttribute("aria-pressed", String(target.visible));
      this.show(this.player.time);
    });
    return button;
  }

  private readonly ghostSwitch = () =>
    this.switch("Ghosts", `Where it was, every ${instant(this.ghosts.every, this.ghosts.every * 10)} (G)`, this.ghosts);
  private readonly trailSwitch = () =>
    this.switch("Trails", "Paths of the ends and of a body that was clicked (T)", this.trails);

  private tools(): HTMLElement {
    const fit = h(
      "button",
      { type: "button", title: "All of the motion in the picture (F)", onclick: () => this.fit() },
      "Fit",
    );
    this.keys = new Map([["f", fit]]);
    if (this.options.still) return h("div", { class: "tools" }, fit);
    const [ghosts, trails] = [this.ghostSwitch(), this.trailSwitch()];
    this.keys.set("g", ghosts).set("t", trails);
    return h("div", { class: "tools" }, ghosts, trails, fit);
  }

  /** Buttons by the key that presses them. */
  keys = new Map<string, HTMLButtonElement>();

  /** How wide all of the motion is (m). */
  get size() {
    return this.stage.size;
  }

  fit() {
    this.stage.fit(this.run);
  }

  show(time: number) {
    const phase = phaseAt(this.run, time);
    this.ghosts.show(time);
    this.trails.show(time);
    this.stage.show(posesAt(this.run, time, this.poses), phase);
    this.showNames(phase.mechanism);
    if (!this.player.playing) this.describe(time);
  }

  private showNames(mechanism: ArrayLike<number>) {
    const there = [...new Set(Array.from(mechanism))].sort((a, b) => a - b);
    const key = there.join() + this.stage.theme.dark;
    if (key === this.named) return;
    this.named = key;
    const most = 6;
    this.names.replaceChildren(
      ...there.slice(0, most).map((m) => {
        const swatch = h("span", { class: "swatch" });
        swatch.style.background = mechanismColour(this.stage.theme, m);
        return h("li", {}, swatch, this.run.mechanisms[m]);
      }),
      ...(there.length > most ? [h("li", {}, `and ${there.length - most} more`)] : []),
    );
  }

  private describe(time: number) {
    const there = new Set(Array.from(phaseAt(this.run, time).mechanism)).size;
    const span = endTime(this.run) - startTime(this.run);
    const bodies = count(this.run.model.bodies.length, "body", "bodies");
    const text = `${bodies} in ${count(there, "mechanism", "mechanisms")} at ${instant(time, span)}`;
    this.stage.canvas.setAttribute(
      "aria-label",
      `3D picture: ${text}. Arrow keys turn it, plus and minus come nearer and go away.`,
    );
    this.spoken.textContent = text;
  }

  private onKey(event: KeyboardEvent) {
    const turns: Record<string, [number, number, number]> = {
      ArrowLeft: [-0.1, 0, 1],
      ArrowRight: [0.1, 0, 1],
      ArrowUp: [0, 0.1, 1],
      ArrowDown: [0, -0.1, 1],
      "+": [0, 0, 1 / 1.15],
      "-": [0, 0, 1.15],
    };
    const turn = turns[event.key];
    if (!turn || event.shiftKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    this.stage.turn(...turn);
  }

  /** A press that turned nothing is a click: it chooses a body, or none. */
  private listenToClicks(canvas: HTMLCanvasElement) {
    let [x, y] = [0, 0];
    canvas.addEventListener("pointerdown", (event) => ([x, y] = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (Math.hypot(event.clientX - x, event.clientY - y) > 4) return;
      const body = this.stage.pick(x, y)?.body ?? -1;
      this.stage.mechanisms.highlighted = body;
      this.trails.choose(body);
      this.show(this.player.time);
      if (body >= 0) this.choose(body);
    });
  }
}
