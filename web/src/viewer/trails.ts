// The paths of some points up to now: of the ends of mechanisms, and of a selected body.
import { Line2 } from "three/examples/jsm/lines/Line2.js";
import { LineGeometry } from "three/examples/jsm/lines/LineGeometry.js";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { Color } from "three";
import type { Model, Motion, Vec3 } from "../recording";
import { mechanismColour, mixed, type Theme } from "./colours";
import { frameAt, inboardJoints, phaseAt, pointOf } from "./frames";
import type { Stage } from "./stage";

/** The point of a body that is farthest from its joint; of one that is held there by the ground, the joint. */
export function endOf(model: Model, body: number): Vec3 {
  const { extent, com } = model.bodies[body];
  const [from, to] = extent[extent.length - 1] ?? [com, com];
  const held = model.joints.some(
    ({ loop, parent, child, childAt }) => loop && parent < 0 && child === body && childAt.every((x, i) => x === to[i]),
  );
  return held ? from : to;
}

/** Leaf bodies; the ones farthest from the root first, at most `most`. */
export function leafBodies(model: Model, most = 6): number[] {
  const parents = new Map([...inboardJoints(model.joints)].map(([body, joint]) => [body, joint.parent]));
  const isParent = new Set(parents.values());
  const depth = (body: number): number => {
    let depth = 0;
    for (let at = parents.get(body) ?? -1; at >= 0 && depth <= model.bodies.length; at = parents.get(at) ?? -1) depth++;
    return depth;
  };
  return model.bodies
    .map((_body, b) => b)
    .filter((b) => !isParent.has(b))
    .map((b) => ({ b, depth: depth(b) }))
    .sort((x, y) => y.depth - x.depth)
    .slice(0, most)
    .map(({ b }) => b);
}

/** Lines from frame to frame. */
const pieces = 4;

/** A point on a smooth curve through four successive points, between the second and the third (Catmull and Rom). */
export function between([a, b, c, d]: readonly (readonly number[])[], share: number): number[] {
  const s = share;
  return [0, 1, 2].map(
    (k) =>
      0.5 *
      (2 * b[k] +
        (c[k] - a[k]) * s +
        (2 * a[k] - 5 * b[k] + 4 * c[k] - d[k]) * s * s +
        (3 * (b[k] - c[k]) + d[k] - a[k]) * s * s * s),
  );
}

/** The reflection of `b` at `a`. */
const mirrored = (a: readonly number[], b: readonly number[]) => a.map((x, k) => 2 * x - b[k]);

interface Trail {
  readonly body: number;
  readonly line: Line2;
}

export class Trails {
  private trails: Trail[] = [];
  private readonly material = new LineMaterial({ vertexColors: true, linewidth: 1.5, transparent: true, opacity: 0.75 });
  private chosen = -1;
  private shown = true;
  private frame = 0;
  private theme: Theme | null = null;

  constructor(
    private readonly stage: Stage,
    private readonly run: Motion,
  ) {
    stage.onThemeChange((theme) => {
      this.theme = theme;
      this.build();
    });
  }

  get visible() {
    return this.shown;
  }
  set visible(visible: boolean) {
    this.shown = visible;
    this.show(Number.NaN);
  }

  /** An additional body whose path is shown; −1: none. */
  choose(body: number) {
    this.chosen = body;
    this.build();
    this.show(Number.NaN);
  }

  private build() {
    if (!this.theme) return;
    for (const { line } of this.trails) {
      line.removeFromParent();
      line.geometry.dispose();
    }
    const bodies = new Set([...leafBodies(this.run.model), ...(this.chosen >= 0 ? [this.chosen] : [])]);
    const colours = this.run.mechanisms.map(
      (_name, m) => new Color(mixed(mechanismColour(this.theme!, m), this.theme!.ground, 0.25)),
    );
    this.trails = this.run.frames < 2 ? [] : [...bodies].map((body) => ({ body, line: this.lineOf(body, colours) }));
    for (const { line } of this.trails) this.stage.scene.add(line);
  }

  private lineOf(body: number, colours: readonly Color[]): Line2 {
    const point = endOf(this.run.model, body);
    const at = (frame: number) => pointOf(this.run.poses(Math.min(Math.max(frame, 0), this.run.frames - 1)), body, point);
    const positions: number[] = [];
    const shades: number[] = [];
    for (let frame = 0; frame < this.run.frames; frame++) {
      // Straight at a gap in the run, which must not bend the adjacent curve.
      const [here, next] = [at(frame), at(frame + 1)];
      const gap = this.run.gapAfter ?? (() => false);
      const around = gap(frame)
        ? [mirrored(here, next), here, next, mirrored(next, here)]
        : [
            gap(frame - 1) ? mirrored(here, next) : at(frame - 1),
            here,
            next,
            gap(frame + 1) ? mirrored(next, here) : at(frame + 2),
          ];
      const colour = colours[phaseAt(this.run, this.run.time(frame)).mechanism[body]];
      for (let k = 0; k < pieces; k++) {
        positions.push(...between(around, k / pieces));
        shades.push(colour.r, colour.g, colour.b);
      }
    }
    const geometry = new LineGeometry();
    geometry.setPositions(positions);
    geometry.setColors(shades);
    const line = new Line2(geometry, this.material);
    line.frustumCulled = false;
    return line;
  }

  /** Shows paths up to a time; NaN: up to the last time shown. */
  show(time: number) {
    if (!Number.isNaN(time)) this.frame = frameAt(this.run, time);
    for (const { line } of this.trails) {
      line.visible = this.shown && this.frame > 0;
      line.geometry.instanceCount = pieces * this.frame;
    }
    this.stage.draw();
  }
}
