// The list of events: each with its certificate, and on a click the pair of pictures before and after it.
import type { Motion, RunEvent, Totals, Vec3 } from "../recording";
import { drawBeforeAfter } from "../viewer/before_after";
import type { Player } from "../viewer/player";
import type { Stage } from "../viewer/stage";
import { endTime, startTime } from "../viewer/frames";
import { h, table } from "./dom";
import { count, digits, duration, instant } from "./numbers";

const size = (v: Vec3) => Math.hypot(v[0], v[1], v[2]);
const between = (a: Vec3, b: Vec3) => Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
const relative = (change: number, of: number) => (change === 0 ? "0" : of > 0 ? digits(change / of, 2) : "–");

/** Energy and momenta before and after, and explanations of the differences. */
export function certificate(event: RunEvent): { rows: string[][]; notes: string[] } {
  const rows: string[][] = [];
  const { before, after } = event;
  if (before && after) {
    const energy = (t: typeof before) => t.kinetic + t.potential;
    const change = energy(after) - energy(before);
    const scale = Math.max(Math.abs(energy(before)), before.kinetic);
    rows.push([
      "energy (J)",
      digits(energy(before), 6),
      digits(energy(after), 6),
      digits(change, 2),
      relative(Math.abs(change), scale),
    ]);
    const momentum = (name: string, a: Vec3, b: Vec3) => {
      const jump = between(a, b);
      rows.push([name, digits(size(a), 6), digits(size(b), 6), digits(jump, 2), relative(jump, Math.max(size(a), size(b)))]);
    };
    momentum("linear momentum (N s)", before.linear, after.linear);
    momentum("angular momentum (N m s)", before.angular, after.angular);
    const loops = (name: string, of: (loops: NonNullable<Totals["loops"]>) => string) => {
      if (before.loops || after.loops) rows.push([name, ...[before, after].map((t) => (t.loops ? of(t.loops) : "–")), "", ""]);
    };
    loops("equations of loops", ({ rows: number }) => String(number));
    loops("independent of them", ({ rank }) => String(rank));
    loops("residual of loops", ({ residual }) => digits(residual, 2));
  }
  const notes: string[] = [];
  const least = before ? 1e-14 * Math.max(Math.abs(before.kinetic + before.potential), before.kinetic) : 0;
  const significant = (energy: number) => Math.abs(energy) > least; // otherwise it is round-off
  if (significant(event.lost)) notes.push(`Lost in the impact: ${digits(event.lost)} J`);
  const what = event.changes.some(({ spring }) => spring) ? "what broke" : "removed degrees of freedom";
  if (significant(event.released)) notes.push(`Released by ${what}: ${digits(event.released)} J`);
  if (significant(event.work)) notes.push(`Work of the event: ${digits(event.work)} J`);
  const momenta = [before, after].flatMap((t) => (t ? [t] : []));
  const exceeds = (impulse: number, of: "linear" | "angular") =>
    impulse > 1e-12 * Math.max(0, ...momenta.map((t) => size(t[of])));
  // Otherwise it is round-off: a weld of bodies that do not move relative to each other.
  if (event.hardest && (exceeds(event.hardest.linear, "linear") || exceeds(event.hardest.angular, "angular"))) {
    const { joint, linear, angular } = event.hardest;
    notes.push(`Largest impulse: ${digits(linear)} N s, ${digits(angular)} N m s, through ${joint}`);
  }
  return { rows, notes };
}

const mechanismsText = (names: readonly string[]) =>
  names.length > 6 ? `${names.slice(0, 6).join(", ")}, … (${names.length})` : names.join(", ");

export class EventList {
  readonly element: HTMLElement;
  private readonly list = h("ol", { class: "list" });
  private readonly detail = h("div", {
    class: "detail",
    role: "group",
    "aria-label": "Event",
    "aria-live": "polite",
    tabindex: 0,
  });
  private chosen = -1;

  constructor(
    private readonly run: Motion,
    private readonly stage: Stage | null,
    private readonly player: Player,
  ) {
    this.element = h("div", { class: "events" }, this.list, this.detail);
    this.refresh();
  }

  refresh() {
    const span = endTime(this.run) - startTime(this.run);
    const most = 1000;
    this.list.replaceChildren(
      ...this.run.events
        .slice(0, most)
        .map((event, index) =>
          h(
            "li",
            {},
            h(
              "button",
              { type: "button", "aria-pressed": String(index === this.chosen), onclick: () => this.choose(index) },
              h("span", { class: "time" }, instant(event.time, span)),
              h("span", { class: "description" }, event.actions.join("; ") || event.event),
            ),
          ),
        ),
    );
    const more = this.run.events.length - most;
    if (more > 0) this.list.append(h("li", {}, `and ${count(more, "event", "events")} more, in events.jsonl`));
    this.list.hidden = this.run.events.length === 0;
    if (this.run.events.length === 0) this.detail.replaceChildren(h("p", { class: "nothing" }, "This run has no events."));
    else if (this.chosen < 0) this.detail.replaceChildren(h("p", { class: "nothing" }, "Choose an event to go there."));
  }

  /** Goes to the event, pauses there, and shows it from nearby. */
  choose(index: number) {
    this.chosen = index;
    const event = this.run.events[index];
    this.player.pause();
    this.player.seek(event.time);
    [...this.list.querySelectorAll("button")].forEach((button, i) => button.setAttribute("aria-pressed", String(i === index)));
    this.list.querySelectorAll("button")[index]?.scrollIntoView({ block: "nearest" });
    this.show();
  }

  /** The next or the previous event, relative to the clock. */
  step(forward: boolean) {
    const now = this.player.time;
    const { events } = this.run;
    const later = events.findIndex((event) => event.time > now + 1e-9);
    const earlier = events.filter((event) => event.time < now - 1e-9).length - 1;
    const next = forward ? later : earlier;
    if (next >= 0) this.choose(next);
  }

  /** Redraws the chosen event after a change of colours or size. */
  show() {
    const changes = this.run.events.findIndex((each) => each.mechanisms.before.join() !== each.mechanisms.after.join());
    const event = this.run.events[this.chosen >= 0 ? this.chosen : Math.max(changes, 0)];
    if (!event) return;
    const { rows, notes } = certificate(event);
    const pair = this.stage && !this.stage.lost && drawBeforeAfter(this.stage, this.run, event, 220, 150);
    const figure = (canvas: HTMLCanvasElement, text: string) => {
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", text);
      return h("figure", {}, canvas, h("figcaption", {}, text));
    };
    const { before, after } = event.mechanisms;
    const names =
      before.join() === after.join() ? mechanismsText(after) : `${mechanismsText(before)} → ${mechanismsText(after)}`;
    const timing = event.duration_ns > 0 ? ` · the change took ${duration(event.duration_ns * 1e-9)}` : "";
    const pictures =
      pair &&
      h(
        "div",
        { class: "pair" },
        figure(pair.before, "before"),
        figure(pair.after, pair.delay > 0 ? `${duration(pair.delay)} after` : "after"),
      );
    const parts = [
      ...(pictures ? [pictures] : []),
      h(
        "div",
        { class: "certificate" },
        h("h2", {}, event.event.startsWith("#") ? event.actions.join("; ") : `${event.event}: ${event.actions.join("; ")}`),
        h("p", {}, `${before.length === 1 && after.length === 1 ? "Mechanism" : "Mechanisms"}: ${names}${timing}`),
        rows.length > 0 && table("Conservation", ["", "before", "after", "difference", "relative"], rows),
        notes.length > 0 && h("p", { class: "notes" }, notes.join(" · ")),
      ),
    ];
    this.detail.replaceChildren(...parts);
  }
}
