// Two close-up pictures, just before and shortly after an event: Figure 1 of the paper.
import * as THREE from "three";
import type { Motion, RunEvent } from "../recording";
import { cornersOf } from "./camera";
import { endTime, phaseAt, pointOf, posesAt, startTime } from "./frames";
import { typicalLength } from "./mechanisms";
import type { Stage } from "./stage";

export interface BeforeAfter {
  readonly before: HTMLCanvasElement;
  readonly after: HTMLCanvasElement;
  /** Delay of the second picture after the event (s). */
  readonly delay: number;
}

/**
 * Delay after which the effect of an event is visible: a fraction of the run, but not beyond the next event that
 * separates or joins bodies.
 */
export function delayAfter(run: Motion, event: RunEvent, share = 0.04): number {
  const next = run.phases.find((phase) => phase.from > event.time)?.from ?? endTime(run);
  const preferred = share * (endTime(run) - startTime(run));
  return Math.max(0, Math.min(preferred, Math.min(next, endTime(run)) - event.time));
}

/** Bodies affected by an event: those that touch, that it pushed or joined, and the children of joints that it changed. */
export function affectedBodies(run: Motion, event: RunEvent): number[] {
  const joints = [...phaseAt(run, event.time - 1e-12).joints, ...phaseAt(run, event.time).joints];
  const numbered = (name: string) => {
    const number = run.model.bodies.findIndex((body) => body.name === name);
    return number < 0 ? [] : [number];
  };
  const changed = event.changes.flatMap(({ body, joint, skipped }) => {
    if (skipped !== undefined) return [];
    if (body === undefined) return joints.find(({ name }) => name === joint)?.child ?? [];
    return numbered(body);
  });
  return [...(event.bodies ?? []).flatMap(numbered), ...changed];
}

/** Joints and shapes of the bodies affected by an event, with their surroundings. `bounds`: of a body's shapes, in its frame. */
function surroundings(
  run: Motion,
  event: RunEvent,
  frames: readonly ArrayLike<number>[],
  bounds: (body: number) => THREE.Box3,
): THREE.Box3 {
  const box = new THREE.Box3();
  const length = typicalLength(run.model);
  const { joints } = phaseAt(run, event.time - 1e-12);
  const affected = affectedBodies(run, event);
  for (const body of affected.length > 0 ? affected : run.model.bodies.map((_body, b) => b)) {
    const shapes = bounds(body);
    const shown = affected.length > 0 && !shapes.isEmpty();
    const wide = (shown ? 0.5 : 1.6) * length;
    for (const poses of frames) {
      const own = joints.filter((each) => each.child === body);
      const ends = own.length > 0 ? own.map(({ childAt }) => pointOf(poses, body, childAt)) : [pointOf(poses, body, [0, 0, 0])];
      // The other side of the break.
      for (const { parent, at } of own) if (parent >= 0) ends.push(pointOf(poses, parent, at));
      for (const end of ends) {
        const at = new THREE.Vector3(...end);
        box.expandByPoint(at.clone().addScalar(wide)).expandByPoint(at.addScalar(-wide));
      }
      if (shown)
        for (const { x, y, z } of cornersOf(shapes)) box.expandByPoint(new THREE.Vector3(...pointOf(poses, body, [x, y, z])));
    }
  }
  return box;
}

/** Pictures of `width` by `height` CSS pixels, seen from the stage's direction. */
export function drawBeforeAfter(stage: Stage, run: Motion, event: RunEvent, width: number, height: number): BeforeAfter {
  const delay = delayAfter(run, event);
  const size = 7 * run.model.bodies.length;
  const early = Math.max(startTime(run), event.time - 1e-9 * Math.max(1, Math.abs(event.time)));
  const first = posesAt(run, event.time, new Float64Array(size));
  const second = posesAt(run, event.time + delay, new Float64Array(size));
  const box = surroundings(run, event, [first, second], (body) => stage.shapes.bounds(body));
  const before = phaseAt(run, early);
  const view = { box, centre: box.getCenter(new THREE.Vector3()) };
  const draw = (poses: Float64Array, phase: typeof before) => stage.snapshot(poses, phase, view, width, height);
  return { before: draw(first, before), after: draw(second, phaseAt(run, event.time + delay)), delay };
}
