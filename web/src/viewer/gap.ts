// How far apart two bodies are, by what is drawn of them: an estimate that says whether they seem to touch.
import type { Body, Model, Shape, Vec3 } from "../recording";
import { pointOf } from "./frames";

export type Line = readonly [Vec3, Vec3];

export const minus = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const along = (a: Vec3, b: Vec3, share: number): Vec3 => [
  a[0] + share * (b[0] - a[0]),
  a[1] + share * (b[1] - a[1]),
  a[2] + share * (b[2] - a[2]),
];
const dot = (a: Vec3, b: Vec3) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** The lines of a body in the world; if it has none, its centre of mass. */
export function linesOf(model: Model, body: number, poses: ArrayLike<number>): Line[] {
  const { extent, com } = model.bodies[body];
  const lines: readonly Line[] = extent.length > 0 ? extent : [[com, com]];
  return lines.map(([from, to]) => [pointOf(poses, body, from), pointOf(poses, body, to)]);
}

/** The point of lines that is nearest to a point. */
export function nearestOn(lines: readonly Line[], point: Vec3): Vec3 {
  let best = lines[0][0];
  let least = Infinity;
  for (const [from, to] of lines) {
    const line = minus(to, from);
    const length = dot(line, line);
    const near = along(from, to, length > 0 ? Math.min(Math.max(dot(minus(point, from), line) / length, 0), 1) : 0);
    const distance = Math.hypot(...minus(point, near));
    if (distance < least) [best, least] = [near, distance];
  }
  return best;
}

/** How far a shape reaches from its middle (m), or from its long axis. */
function reachOf({ kind, size = [0, 0, 0], radius = 0, length = 0, scale = [1, 1, 1], parts = [] }: Shape, axis: boolean) {
  if (kind === "box") return axis ? Math.min(...size) / 2 : Math.hypot(...size) / 2;
  if (kind !== "mesh" && parts.length === 0) return axis ? radius : radius + length / 2;
  const farthest = parts.map(({ positions }) => positions.reduce((most, x) => Math.max(most, Math.abs(x)), 0));
  return Math.max(0, ...farthest) * Math.max(...scale.map(Math.abs));
}

/** How far the shapes of a body reach from its lines (m). */
function thicknessOf({ shapes, extent, com }: Body): number {
  const axis = extent.length > 0;
  return Math.max(0, ...shapes.map((shape) => reachOf(shape, axis) + (axis ? 0 : Math.hypot(...minus(shape.at.xyz, com)))));
}
const thicknesses = new WeakMap<Body, number>();

function thickness(body: Body): number {
  const known = thicknesses.get(body) ?? thicknessOf(body);
  thicknesses.set(body, known);
  return known;
}

const longest = (lines: readonly Line[]) => Math.max(...lines.map(([from, to]) => Math.hypot(...minus(from, to))));

/** Whether there is a gap between two bodies, in proportion to their lengths. */
export function areApart(model: Model, a: number, b: number, poses: ArrayLike<number>): boolean {
  const [first, second] = [linesOf(model, a, poses), linesOf(model, b, poses)];
  let [from, to] = [first[0][0], second[0][0]];
  for (let n = 0; n < 8; n++) {
    to = nearestOn(second, from);
    from = nearestOn(first, to);
  }
  const distance = Math.hypot(...minus(from, to)) - thickness(model.bodies[a]) - thickness(model.bodies[b]);
  return distance > Math.max(1e-6, 0.25 * Math.max(longest(first), longest(second)));
}
