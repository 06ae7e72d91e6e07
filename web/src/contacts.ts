// Events of contacts, of which there can be hundreds in a moment: what is shown of them, and in which groups.
import type { RunEvent, Vec3 } from "./recording";

export const isContact = (event: Pick<RunEvent, "bodies">) => event.bodies !== undefined;

const size = (v: Vec3 | undefined) => (v ? Math.hypot(v[0], v[1], v[2]) : 0);

/** The size of an impact's impulse (N s); 0 of other events. */
export const impulseOf = (event: RunEvent) => (isContact(event) ? size(event.impulse) : 0);

const named = (body: string) => (body === "ground" ? "the ground" : body);

/** The bodies of a contact: "box and the ground". */
export const pairText = (event: RunEvent) => (event.bodies ?? []).map(named).join(" and ");

/** "impact: box and the ground", with a reason if there is one; of other events their actions, or their name with its reason. */
export const textOf = (event: RunEvent) =>
  isContact(event)
    ? `${event.event}: ${pairText(event)}${event.reason ? `, ${event.reason}` : ""}`
    : event.actions.join("; ") || (event.reason ? `${event.event}: ${event.reason}` : event.event);

/** Events that are one line of a list: an event that is no contact, or contacts in quick succession. */
export interface Group {
  /** Of the events, from the first to before the end. */
  readonly first: number;
  readonly end: number;
  /** The event with the largest impulse. */
  readonly main: number;
}

/** Contacts that follow each other within `span` (s) are a group. */
export function groupsOf(events: readonly RunEvent[], span: number): Group[] {
  const groups: { first: number; end: number; main: number }[] = [];
  for (const [index, event] of events.entries()) {
    const last = groups[groups.length - 1];
    const joins = last && isContact(event) && isContact(events[last.first]) && event.time - events[last.first].time <= span;
    if (!joins) {
      groups.push({ first: index, end: index + 1, main: index });
      continue;
    }
    last.end = index + 1;
    if (impulseOf(event) > impulseOf(events[last.main])) last.main = index;
  }
  return groups;
}

/** What a group of contacts consists of: "12 impacts, rest, 2 slips: box and the ground". */
export function groupText(events: readonly RunEvent[], { first, end }: Group): string {
  if (end - first === 1) return textOf(events[first]);
  const counts = new Map<string, number>();
  const pairs = new Set<string>();
  for (const event of events.slice(first, end)) {
    const kind = event.event.split(" ")[0];
    counts.set(kind, (counts.get(kind) ?? 0) + 1);
    pairs.add(pairText(event));
  }
  const kinds = [...counts].map(([kind, count]) => (count === 1 ? kind : `${count} × ${kind}`)).join(", ");
  return `${kinds}: ${pairs.size === 1 ? [...pairs][0] : `${pairs.size} pairs of bodies`}`;
}

/** Where an impact is marked, how strong it was (N s), and how long ago (a share of the time for which it is marked). */
export interface Mark {
  readonly point: Vec3;
  readonly normal: Vec3;
  readonly impulse: number;
  readonly age: number;
}

/** Impacts of at least `least` (N s) within `lasts` (s) before a time; the last ones if there are more than `most`. */
export function marksAt(events: readonly RunEvent[], time: number, lasts: number, least: number, most = 64): Mark[] {
  let [low, high] = [0, events.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (events[middle].time <= time + 1e-12) low = middle + 1;
    else high = middle;
  }
  const marks: Mark[] = [];
  for (let i = low - 1; i >= 0 && events[i].time > time - lasts && marks.length < most; i--) {
    const { point, normal } = events[i];
    const impulse = impulseOf(events[i]);
    if (point && normal && impulse >= least && impulse > 0)
      marks.push({ point, normal, impulse, age: Math.max(0, time - events[i].time) / lasts });
  }
  return marks;
}
