// Two close-up pictures, just before and shortly after an event: Figure 1 of the paper.
import * as THREE from "three";
import type { Recording, RunEvent } from "../recording";
import { endTime, phaseAt, pointOf, posesAt, startTime } from "./frames";
import { typicalLength } from "./mechanisms";
import type { Stage } from "./stage";

export interface Pair {
  readonly before: HTMLCanvasElement;
  readonly after: HTMLCanvasElement;
  /** Delay of the second picture after the event (s). */
  readonly delay: number;
}

/**
 * Delay after which the effect of an event is visible: a fraction of the run, but not beyond the next event that
 * separates or joins bodies.
 */
export function delayAfter(run: Recording, event: RunEvent, share = 0.04): number {
  const next = run.phases.find((phase) => phase.from > event.time)?.from ?? endTime(run);
  const wanted = share * (endTime(run) - startTime(run));
  return Math.max(0, Math.min(wanted, Math.min(next, endTime(run)) - event.time));
}

/** Positions of the bodies affected by an event, with their surroundings. */
function surroundings(run: Recording, event: RunEvent, frames: readonly ArrayLike<number>[]): THREE.Box3 {
  const box = new THREE.Box3();
  const wide = 1.6 * typicalLength(run.model);
  const links = phaseAt(run, event.time - 1e-12).links;
  for (const body of event.bodies.length > 0 ? event.bodies : run.model.bodies.map((_body, b) => b))
    for (const poses of frames) {
      const link = links.find((each) => each.child === body);
      const ends = [pointOf(poses, body, link?.childAt ?? [0, 0, 0])];
      if (link && link.parent >= 0) ends.push(pointOf(poses, link.parent, link.at)); // the other side of the break
      for (const end of ends) {
        const at = new THREE.Vector3(...end);
        box.expandByPoint(at.clone().addScalar(wide)).expandByPoint(at.addScalar(-wide));
      }
    }
  return box;
}

/** Pictures of `width` by `height` CSS pixels, seen from the stage's direction. */
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
