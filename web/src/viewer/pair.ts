// Just before and a little after an event, from nearby: Figure 1 of the paper.
import * as THREE from "three";
import type { Recording, RunEvent } from "../recording";
import { endTime, phaseAt, pointOf, posesAt, startTime } from "./frames";
import { typicalLength } from "./mechanisms";
import type { Stage } from "./stage";

export interface Pair {
  readonly before: HTMLCanvasElement;
  readonly after: HTMLCanvasElement;
  /** How long after the event the second one is (s). */
  readonly delay: number;
}

/** How long after an event what it did is seen: a share of the run, but not beyond the next event that parts or joins. */
export function delayAfter(run: Recording, event: RunEvent, share = 0.04): number {
  const next = run.phases.find((phase) => phase.from > event.time)?.from ?? endTime(run);
  const wanted = share * (endTime(run) - startTime(run));
  return Math.max(0, Math.min(wanted, Math.min(next, endTime(run)) - event.time));
}

/** Where bodies that an event was about are, with what is around them. */
function surroundings(run: Recording, event: RunEvent, frames: readonly ArrayLike<number>[]): THREE.Box3 {
  const box = new THREE.Box3();
  const wide = 1.6 * typicalLength(run.model);
  const links = phaseAt(run, event.time - 1e-12).links;
  for (const body of event.bodies.length > 0 ? event.bodies : run.model.bodies.map((_body, b) => b))
    for (const poses of frames) {
      const link = links.find((each) => each.child === body);
      const ends = [pointOf(poses, body, link?.childAt ?? [0, 0, 0])];
      if (link && link.parent >= 0) ends.push(pointOf(poses, link.parent, link.at)); // the other side of what breaks
      for (const end of ends) {
        const at = new THREE.Vector3(...end);
        box.expandByPoint(at.clone().addScalar(wide)).expandByPoint(at.addScalar(-wide));
      }
    }
  return box;
}

/** Pictures of `width` by `height` pixels of the page, seen from where the stage is looked at. */
export function drawPair(stage: Stage, run: Recording, event: RunEvent, width: number, height: number): Pair {
  const delay = delayAfter(run, event);
  const size = 7 * run.model.bodies.length;
  const early = Math.max(startTime(run), event.time - 1e-9 * Math.max(1, Math.abs(event.time)));
  const first = posesAt(run, event.time, new Float64Array(size));
  const second = posesAt(run, event.time + delay, new Float64Array(size));
  const box = surroundings(run, event, [first, second]);
  const before = phaseAt(run, early);
  const view = { box, centre: box.getCenter(new THREE.Vector3()) };
  const draw = (poses: Float64Array, phase: typeof before) => stage.snapshot(poses, phase, view, width, height);
  return { before: draw(first, before), after: draw(second, phaseAt(run, event.time + delay)), delay };
}
