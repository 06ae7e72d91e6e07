// Play button, slider, speed, and events as marks: a click on a mark goes to its time.
import type { Recording, RunEvent } from "../recording";
import { endTime, startTime } from "../viewer/frames";
import type { Player } from "../viewer/player";
import { h } from "./dom";
import { instant } from "./numbers";

const speeds = [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5];

/** Marks closer to the previous one than this fraction of the line are left out: they could not be distinguished. */
export function marked(events: readonly RunEvent[], from: number, to: number, apart = 0.008): number[] {
  const kept: number[] = [];
  let last = -Infinity;
  events.forEach((event, index) => {
    const at = (event.time - from) / (to - from || 1);
    if (at - last < apart) return;
    last = at;
    kept.push(index);
  });
  return kept;
}

export class Timeline {
  readonly element: HTMLElement;
  private readonly play: HTMLButtonElement;
  private readonly slider: HTMLInputElement;
  private readonly clock: HTMLOutputElement;
  private readonly marks: HTMLElement;
  private shown = { events: -1, end: Number.NaN };

  /** `choose`: called when an event's mark is clicked. */
  constructor(
    private readonly run: Recording,
    private readonly player: Player,
    private readonly choose: (event: number) => void,
  ) {
    this.play = h("button", { class: "play", type: "button", "aria-label": "Play", onclick: () => player.toggle() });
    this.slider = h("input", {
      type: "range",
      min: 0,
      max: 1000,
      step: "any",
      "aria-label": "Time",
      oninput: () => {
        const [from, to] = this.range();
        const wanted = from + (Number(this.slider.value) / 1000) * (to - from);
        player.pause(); // this moves the slider back to the clock's time
        player.seek(wanted);
      },
    });
    this.clock = h("output", { class: "clock" });
    this.marks = h("div", { class: "marks" });
    const pace = h("select", { "aria-label": "Speed", title: "Speed", onchange: () => (player.speed = Number(pace.value)) });
    for (const speed of speeds) pace.append(h("option", { value: speed, selected: speed === 1 }, `${speed}×`));
    this.element = h(
      "div",
      { class: "timeline", role: "group", "aria-label": "Timeline" },
      this.play,
      h("div", { class: "line" }, this.marks, this.slider),
      this.clock,
      pace,
    );
    player.listen((time) => this.show(time));
  }

  private range(): [number, number] {
    return [startTime(this.run), endTime(this.run)];
  }

  private show(time: number) {
    const [from, to] = this.range();
    if (this.shown.events !== this.run.events.length || this.shown.end !== to) this.showMarks(from, to);
    const label = this.player.playing ? "Pause" : "Play";
    if (this.play.getAttribute("aria-label") !== label) this.play.setAttribute("aria-label", label);
    this.play.dataset.playing = String(this.player.playing);
    this.slider.value = String(to > from ? (1000 * (time - from)) / (to - from) : 0);
    this.slider.style.setProperty("--done", `${to > from ? (100 * (time - from)) / (to - from) : 0}%`);
    const text = instant(time, to - from);
    this.slider.setAttribute("aria-valuetext", text);
    this.clock.textContent = text;
  }

  private showMarks(from: number, to: number) {
    this.shown = { events: this.run.events.length, end: to };
    this.marks.replaceChildren(
      ...marked(this.run.events, from, to).map((index) => {
        const event = this.run.events[index];
        const says = `${instant(event.time, to - from)}: ${event.actions.join("; ") || event.name}`;
        const mark = h("button", {
          type: "button",
          title: says,
          "aria-label": `Event at ${says}`,
          onclick: () => this.choose(index),
        });
        mark.style.left = `${(100 * (event.time - from)) / (to - from || 1)}%`;
        return mark;
      }),
    );
  }
}
