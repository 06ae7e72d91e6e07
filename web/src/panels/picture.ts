// The picture with its overlays: names of mechanisms in their colours, and switches. If the browser can't draw it, a
// message and the names are shown instead.
import type { Joint, Motion } from "../recording";
import { mechanismColour, themeOf, type Theme } from "../viewer/colours";
import { endTime, phaseAt, posesAt, startTime } from "../viewer/frames";
import { Ghosts } from "../viewer/ghosts";
import { Impacts } from "../viewer/impacts";
import type { Player } from "../viewer/player";
import { typicalLength } from "../viewer/mechanisms";
import type { Stage } from "../viewer/stage";
import { Trails } from "../viewer/trails";
import { h } from "./dom";
import { count, instant } from "./numbers";
import { mountStage, ownColoursTitle } from "./mount_stage";
import { Hover } from "./hover";
import { Save } from "./save";
import { Strays } from "./strays";
import { Vectors } from "./vectors";
import { turnByKeys } from "./turn_by_keys";
import { viewMenu } from "./view_menu";

/** The drawing, and the parts of it that can be switched on and off. */
interface Drawn {
  readonly stage: Stage;
  readonly ghosts: Ghosts;
  readonly trails: Trails;
  readonly vectors: Vectors;
  readonly impacts: Impacts;
}

/** At a time, the force of a joint on its child, in the child's axes; null: unknown. */
export type Forces = (time: number) => (joint: Joint) => readonly number[] | null;

export class Picture {
  readonly element = h("section", { class: "picture", "aria-label": "Picture" });
  private readonly drawn: Drawn | null;
  private theme: Theme = themeOf(false);
  private readonly names = h("ul", { class: "names", "aria-label": "Mechanisms" });
  private readonly description = h("p", { class: "hidden-text", "aria-live": "polite" });
  private readonly poses: Float64Array;
  private shownNames = "";

  /** `choose`: called when a body is clicked. `static`: there is no motion, and therefore no ghosts and no trails. */
  constructor(
    private readonly run: Motion,
    private readonly player: Player,
    private readonly choose: (body: number) => void,
    private readonly options: {
      readonly static?: boolean;
      readonly forces?: Forces;
      readonly alternatives: readonly (Node | string)[];
    },
  ) {
    const host = h("div", { class: "stage" });
    this.element.append(host);
    this.poses = new Float64Array(7 * run.model.bodies.length);
    const stage = mountStage(host, run.model, options.alternatives);
    this.drawn = stage && {
      stage,
      ghosts: new Ghosts(stage, run),
      trails: new Trails(stage, run),
      vectors: new Vectors(stage),
      impacts: new Impacts(stage, Math.min(0.3, 0.1 * (endTime(run) - startTime(run)))),
    };
    host.append(h("div", { class: "over" }, this.names, this.drawn && this.tools(this.drawn)), this.description);
    if (stage) {
      const now = () => ({ poses: this.poses, phase: phaseAt(run, player.time), names: run.mechanisms });
      host.append(new Strays(stage, now).element, new Hover(stage, now).element, this.drawn!.vectors.legend);
    }
    if (this.drawn) this.listenTo(this.drawn.stage.canvas);
    player.listen((time) => this.show(time));
    stage?.fit(run);
  }

  /** null if the browser can't draw it. */
  get stage(): Stage | null {
    return this.drawn?.stage ?? null;
  }

  setTheme(theme: Theme) {
    this.theme = theme;
    this.stage?.setTheme(theme);
    this.shownNames = "";
    this.show(this.player.time);
  }

  private toggle(label: string, title: string, key: string, target: { visible: boolean }): HTMLButtonElement {
    const button = h("button", { type: "button", title: `${title} (${key})`, "aria-pressed": String(target.visible) }, label);
    button.addEventListener("click", () => {
      target.visible = !target.visible;
      button.setAttribute("aria-pressed", String(target.visible));
      this.show(this.player.time);
    });
    this.keys.set(key.toLowerCase(), button);
    return button;
  }

  private tools({ stage, ghosts, trails, vectors }: Drawn): HTMLElement {
    const fit = h("button", { type: "button", title: "Show the whole motion (F)", onclick: () => this.fit() }, "Fit");
    this.keys.set("f", fit);
    const own = {
      get visible() {
        return stage.ownColours;
      },
      set visible(visible: boolean) {
        stage.ownColours = visible;
      },
    };
    const buttons: HTMLElement[] = [];
    if (stage.shapes.coloured) buttons.push(this.toggle("Own colours", ownColoursTitle, "O", own));
    if (!this.options.static)
      buttons.push(
        this.toggle("Ghosts", `Earlier poses, every ${instant(ghosts.every, ghosts.every * 10)}`, "G", ghosts),
        this.toggle("Arrows", "Momenta of bodies, forces of joints and of contacts", "V", vectors),
        this.followButton(stage),
        this.toggle("Trails", "Paths of the outermost bodies and of the selected body", "T", trails),
      );
    const save = this.save(stage);
    this.keys.set("p", h("button", { onclick: () => save.savePicture() }));
    const menu = viewMenu(...buttons, fit, save.element);
    stage.roomAbove = menu.room;
    return menu.element;
  }

  /** A video shows the run from its start to its end. */
  private save(stage: Stage): Save {
    const { player, run } = this;
    return new Save({
      stage: () => stage,
      title: () => run.model.title,
      play: () => {
        player.seek(startTime(run));
        player.play();
      },
      ended: () => !player.playing,
      report: (message) => (this.description.textContent = message),
    });
  }

  private followButton(stage: Stage): HTMLButtonElement {
    const target = {
      get visible() {
        return stage.following;
      },
      set visible(on: boolean) {
        stage.following = on;
      },
    };
    const button = this.toggle("Follow", "The camera follows what moves", "M", target);
    stage.onFollowChange((on) => button.setAttribute("aria-pressed", String(on)));
    return button;
  }

  /** Buttons by the key that presses them. */
  readonly keys = new Map<string, HTMLButtonElement>();

  /** Width of the whole motion (m). */
  get size() {
    return this.stage?.size ?? 4 * typicalLength(this.run.model);
  }

  fit() {
    this.stage?.fit(this.run);
  }

  show(time: number) {
    const phase = phaseAt(this.run, time);
    if (this.drawn) {
      this.drawn.ghosts.show(time);
      this.drawn.trails.show(time);
      this.drawn.stage.show(posesAt(this.run, time, this.poses), phase);
      this.drawn.impacts.show(this.run, time);
      this.drawn.vectors.show(this.run, time, this.poses, this.options.forces?.(time) ?? (() => null));
    }
    this.showNames(phase.mechanism);
    if (!this.player.playing) this.describe(time);
  }

  private showNames(mechanism: ArrayLike<number>) {
    const present = [...new Set(Array.from(mechanism))].sort((a, b) => a - b);
    const key = present.join() + this.theme.dark;
    if (key === this.shownNames) return;
    this.shownNames = key;
    const most = 6;
    this.names.replaceChildren(
      ...present.slice(0, most).map((m) => {
        const swatch = h("span", { class: "swatch" });
        swatch.style.background = mechanismColour(this.theme, m);
        return h("li", {}, swatch, this.run.mechanisms[m]);
      }),
      ...(present.length > most ? [h("li", {}, `and ${present.length - most} more`)] : []),
    );
  }

  private describe(time: number) {
    const present = new Set(Array.from(phaseAt(this.run, time).mechanism)).size;
    const span = endTime(this.run) - startTime(this.run);
    const bodies = count(this.run.model.bodies.length, "body", "bodies");
    const text = `${bodies} in ${count(present, "mechanism", "mechanisms")} at ${instant(time, span)}`;
    this.stage?.canvas.setAttribute("aria-label", `3D picture: ${text}. Arrow keys rotate it, plus and minus zoom.`);
    this.description.textContent = text;
  }

  /** Keys rotate the view; a press without rotation is a click: it selects a body, or none. */
  private listenTo(canvas: HTMLCanvasElement) {
    if (this.stage) turnByKeys(this.stage);
    let [x, y] = [0, 0];
    canvas.addEventListener("pointerdown", (event) => ([x, y] = [event.clientX, event.clientY]));
    canvas.addEventListener("pointerup", (event) => {
      if (!this.drawn || Math.hypot(event.clientX - x, event.clientY - y) > 4) return;
      const body = this.drawn.stage.pick(x, y)?.body ?? -1;
      this.drawn.stage.mechanisms.highlighted = body;
      this.drawn.trails.choose(body);
      this.show(this.player.time);
      if (body >= 0) this.choose(body);
    });
  }
}
