// Play button, slider, speed, and events as marks: a click on a mark goes to its time.
import { impulseOf, isContact, textOf } from "../contacts";
import type { Motion, RunEvent } from "../recording";
import { endTime, startTime } from "../viewer/frames";
import { h } from "./dom";
import { instant } from "./numbers";

/**
 * The events on the line that have marks; those closer to another mark than `apart` of the line could not be told apart. Contacts
 * have marks where there is room between those of other events, hard impacts first.
 */
export function marked(events: readonly RunEvent[], from: number, to: number, apart = 0.008): number[] {
  const at = (index: number) => (events[index].time - from) / (to - from || 1);
  const all = events.map((_event, index) => index).filter((index) => at(index) >= -1e-9);
  const indices: number[] = [];
  let last = -Infinity;
  for (const index of all) {
    if (isContact(events[index]) || at(index) - last < apart) continue;
    last = at(index);
    indices.push(index);
  }
  // By cells that are as wide as a mark: only the marks of three of them can be too close.
  const cells = new Map<number, number[]>();
  const cell = (index: number) => Math.floor(at(index) / apart);
  const put = (index: number) => cells.set(cell(index), [...(cells.get(cell(index)) ?? []), index]);
  for (const index of indices) put(index);
  const contacts = all.filter((index) => isContact(events[index]));
  contacts.sort((a, b) => impulseOf(events[b]) - impulseOf(events[a]) || a - b);
  for (const index of contacts) {
    const near = [-1, 0, 1].flatMap((k) => cells.get(cell(index) + k) ?? []);
    if (near.some((other) => Math.abs(at(other) - at(index)) < apart)) continue;
    put(index);
    indices.push(index);
  }
  return indices.sort((a, b) => a - b);
}

/** What a timeline shows and controls. */
export interface Clock {
  readonly time: number;
  readonly playing: boolean;
  toggle(): void;
  pause(): void;
  seek(time: number): void;
  set speed(factor: number);
  /** Calls back when the time or the playing state has changed. */
  listen(listener: () => void): void;
}

interface TimelineOptions {
  readonly speeds: readonly number[];
  /** Called when an event's mark is clicked. */
  readonly choose: (event: number) => void;
  /** The clock shows the decimals that a run of at least this length needs (s). */
  readonly shortest?: number;
  /** An additional button next to the play button. */
  readonly button?: HTMLElement;
}

export class Timeline {
  readonly element: HTMLElement;
  private readonly play: HTMLButtonElement;
  private readonly slider: HTMLInputElement;
  private readonly clockText = h("output", { class: "clock" });
  private readonly marks = h("div", { class: "marks" });
  private shown: { events: readonly RunEvent[]; count: number; end: number } | null = null;

  /** `run`: called each time, because another one may take its place; null: there is none yet. */
  constructor(
    private readonly run: () => Motion | null,
    private readonly clock: Clock,
    private readonly options: TimelineOptions,
  ) {
    this.play = h("button", { class: "play", type: "button", "aria-label": "Play", onclick: () => clock.toggle() });
    this.slider = h("input", {
      type: "range",
      min: 0,
      max: 1000,
      step: "any",
      value: 0,
      "aria-label": "Time",
      oninput: () => {
        const [from, to] = this.range();
        const time = from + (Number(this.slider.value) / 1000) * (to - from);
        clock.pause(); // this moves the slider back to the clock's time
        clock.seek(time);
      },
    });
    this.slider.addEventListener("pointerup", (event) => this.snap(event));
    const speed = h("select", {
      "aria-label": "Speed",
      title: "Speed",
      onchange: () => (clock.speed = Number(speed.value)),
    });
    for (const factor of options.speeds) speed.append(h("option", { value: factor, selected: factor === 1 }, `${factor}×`));
    this.element = h(
      "div",
      { class: "timeline", role: "group", "aria-label": "Timeline" },
      this.play,
      options.button,
      h("div", { class: "line" }, this.marks, this.slider),
      this.clockText,
      speed,
    );
    clock.listen(() => this.show());
  }

  /** Fingers can't hit a mark: a tap on the slider near one is a tap on it. */
  private snap(event: PointerEvent) {
    if (event.pointerType !== "touch") return;
    const near = [...this.marks.children]
      .map((mark, i) => ({ i, away: Math.abs(mark.getBoundingClientRect().left + 8 - event.clientX) }))
      .sort((a, b) => a.away - b.away)[0];
    const run = this.run();
    if (!run || !near || near.away > 14) return;
    const [from, to] = this.range();
    this.options.choose(marked(run.events, from, to)[near.i]);
  }

  /** Whether there is something to play. */
  set playable(on: boolean) {
    this.play.disabled = !on;
  }

  private range(): [number, number] {
    const run = this.run();
    return run ? [startTime(run), endTime(run)] : [0, 0];
  }

  private instant(time: number): string {
    const [from, to] = this.range();
    return instant(time, Math.max(to - from, this.options.shortest ?? 0));
  }

  private show() {
    const run = this.run();
    const { time, playing } = this.clock;
    const [from, to] = this.range();
    if (run && (this.shown?.events !== run.events || this.shown.count !== run.events.length || this.shown.end !== to))
      this.showMarks(run, from, to);
    const label = playing ? "Pause" : "Play";
    if (this.play.getAttribute("aria-label") !== label) this.play.setAttribute("aria-label", label);
    this.play.dataset.playing = String(playing);
    const share = to > from ? (time - from) / (to - from) : 0;
    this.slider.value = String(1000 * share);
    this.slider.style.setProperty("--done", `${100 * share}%`);
    const text = this.instant(time);
    this.slider.setAttribute("aria-valuetext", text);
    this.clockText.textContent = text;
  }

  private showMarks(run: Motion, from: number, to: number) {
    this.shown = { events: run.events, count: run.events.length, end: to };
    this.marks.replaceChildren(
      ...marked(run.events, from, to).map((index) => {
        const event = run.events[index];
        const label = `${this.instant(event.time)}: ${textOf(event)}`;
        const mark = h("button", {
          type: "button",
          title: label,
          "aria-label": `Event at ${label}`,
          ...(isContact(event) && { class: "contact" }),
          onclick: () => this.options.choose(index),
        });
        mark.style.left = `${(100 * (event.time - from)) / (to - from || 1)}%`;
        return mark;
      }),
    );
  }
}
