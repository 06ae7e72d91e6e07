// The list of events: each with its certificate, and on a click the pair of pictures before and after it. Contacts in quick
// succession are one line, which opens when it is chosen.
import { groupsOf, groupText, impulseOf, isContact, pairText, textOf, type Group } from "../contacts";
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
    momentum("linear momentum (N\u00a0s)", before.linear, after.linear);
    momentum("angular momentum (N\u00a0m\u00a0s)", before.angular, after.angular);
    const loops = (name: string, of: (loops: NonNullable<Totals["loops"]>) => string) => {
      if (before.loops || after.loops) rows.push([name, ...[before, after].map((t) => (t.loops ? of(t.loops) : "–")), "", ""]);
    };
    loops("equations of loops", ({ rows: number }) => String(number));
    loops("independent of them", ({ rank }) => String(rank));
    loops("residual of loops", ({ residual }) => digits(residual, 2));
  }
  const notes: string[] = [];
  if (isContact(event) && event.point) {
    const at = event.point.map((x) => digits(Math.abs(x) < 1e-9 ? 0 : x, 4)).join(", ");
    notes.push(`${pairText(event)} at (${at}) m`);
    if (impulseOf(event) > 0) notes.push(`Impulse: ${digits(impulseOf(event))} N s`);
  }
  if (event.scaled !== undefined)
    notes.push(`Expansion reduced to ${digits(event.scaled, 3)} of its restitution: no energy gained`);
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

function titleOf(event: RunEvent): string {
  if (event.actions.length === 0) return textOf(event);
  const actions = event.actions.join("; ");
  return event.event.startsWith("#") ? actions : `${event.event}: ${actions}`;
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
  private groups: readonly Group[] = [];
  /** By event, those that have one at present. */
  private readonly buttons = new Map<number, HTMLButtonElement>();
  private readonly openers = new Map<Group, () => void>();

  constructor(
    private readonly run: Motion,
    private readonly stage: Stage | null,
    private readonly player: Player,
  ) {
    this.element = h("div", { class: "events" }, this.list, this.detail);
    this.refresh();
  }

  refresh() {
    const { events } = this.run;
    const most = 1000;
    this.groups = groupsOf(events, 0.01 * (endTime(this.run) - startTime(this.run)));
    this.buttons.clear();
    this.openers.clear();
    const shown = this.groups.slice(0, most);
    this.list.replaceChildren(...shown.map((group) => this.line(group)));
    const more = events.length - (shown[shown.length - 1]?.end ?? 0);
    if (more > 0) this.list.append(h("li", {}, `and ${count(more, "event", "events")} more, in events.jsonl`));
    this.list.hidden = this.run.events.length === 0;
    if (this.run.events.length === 0) this.detail.replaceChildren(h("p", { class: "nothing" }, "This run has no events."));
    else if (this.chosen < 0) this.detail.replaceChildren(h("p", { class: "nothing" }, "Choose an event to go there."));
  }

  private button(index: number, text: string, strength = ""): HTMLButtonElement {
    const span = endTime(this.run) - startTime(this.run);
    const button = h(
      "button",
      {
        type: "button",
        "aria-pressed": String(index === this.chosen),
        title: strength ? `${text}, ${strength}` : text,
        onclick: () => this.choose(index),
      },
      h("span", { class: "time" }, instant(this.run.events[index].time, span)),
      h("span", { class: "description" }, text),
      strength && h("span", { class: "strength" }, strength),
    );
    this.buttons.set(index, button);
    return button;
  }

  /** The line of a group: of several events, it opens the list of them and goes to the hardest impact. */
  private line(group: Group): HTMLLIElement {
    const { events } = this.run;
    const text = groupText(events, group);
    if (group.end - group.first === 1) return h("li", {}, this.button(group.first, text));
    const most = 200;
    const span = endTime(this.run) - startTime(this.run);
    const inside = h("ol", { class: "group" });
    const open = () => {
      if (inside.childElementCount > 0) return;
      for (let index = group.first; index < Math.min(group.end, group.first + most); index++) {
        const impulse = impulseOf(events[index]);
        const strength = impulse > 0 ? `${digits(impulse, 3)} N s` : "";
        inside.append(h("li", {}, this.button(index, textOf(events[index]), strength)));
      }
      const more = group.end - group.first - most;
      if (more > 0) inside.append(h("li", {}, `and ${count(more, "event", "events")} more, in events.jsonl`));
    };
    const details = h(
      "details",
      { ontoggle: () => details.open && open() },
      h(
        "summary",
        { title: text },
        h("span", { class: "time" }, instant(events[group.first].time, span)),
        h("span", { class: "description" }, text),
      ),
      inside,
    );
    this.openers.set(group, () => {
      details.open = true;
      open();
    });
    return h("li", {}, details);
  }

  /** Goes to the event, pauses there, and shows it from nearby. */
  choose(index: number) {
    this.chosen = index;
    const event = this.run.events[index];
    this.player.pause();
    this.player.seek(event.time);
    const group = this.groups.find(({ first, end }) => index >= first && index < end);
    if (group) this.openers.get(group)?.();
    this.buttons.get(index)?.scrollIntoView({ block: "nearest" });
    this.show();
  }

  /** The next or the previous event, relative to the clock; of contacts in quick succession, the hardest impact. */
  step(forward: boolean) {
    const now = this.player.time;
    const times = this.groups.map(({ main }) => this.run.events[main].time);
    const later = times.findIndex((time) => time > now + 1e-9);
    const earlier = times.filter((time) => time < now - 1e-9).length - 1;
    const next = this.groups[forward ? later : earlier];
    if (next) this.choose(next.main);
  }

  /** Redraws the chosen event after a change of colours or size. */
  show() {
    const changes = this.run.events.findIndex((each) => each.mechanisms.before.join() !== each.mechanisms.after.join());
    const index = this.chosen >= 0 ? this.chosen : Math.max(changes, 0);
    const event = this.run.events[index];
    if (!event) return;
    for (const [i, button] of this.buttons) button.setAttribute("aria-pressed", String(i === index));
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
        h("h2", {}, titleOf(event)),
        h("p", {}, `${before.length === 1 && after.length === 1 ? "Mechanism" : "Mechanisms"}: ${names}${timing}`),
        rows.length > 0 && table("Conservation", ["", "before", "after", "difference", "relative"], rows),
        notes.length > 0 && h("p", { class: "notes" }, notes.join(" · ")),
      ),
    ];
    this.detail.replaceChildren(...parts);
  }
}
