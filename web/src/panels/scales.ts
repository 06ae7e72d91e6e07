// Typical sizes of the quantities in a run: a plot that contains only round-off is drawn as a flat line, not as noise.
import type { Column, JointQuantity, Model, Recording, WorldQuantity } from "../recording";
import { typicalLength } from "../viewer/mechanisms";

/** Relative to the scale: for doubles that are sums over bodies and steps. */
const roundOff = 1e-12;

export interface Range {
  readonly low: number;
  readonly high: number;
  /** All values shown are zero, or the same number, to round-off. */
  readonly flat: "zero" | "constant" | null;
}

const largest = (values: ArrayLike<number>) => {
  let most = 0;
  for (let i = 0; i < values.length; i++)
    if (Math.abs(values[i]) > most && Number.isFinite(values[i])) most = Math.abs(values[i]);
  return most;
};
const largestOf = (columns: readonly Column[]) => Math.max(0, ...columns.map(({ values }) => largest(values)));

/**
 * The range of the value axis. `scale`: typical size of the quantity; `precision`: relative precision of the values.
 */
export function rangeOf(columns: readonly ArrayLike<number>[], scale: number, precision = 0): Range {
  let [low, high] = [Infinity, -Infinity];
  for (const values of columns)
    for (let i = 0; i < values.length; i++)
      if (Number.isFinite(values[i])) {
        if (values[i] < low) low = values[i];
        if (values[i] > high) high = values[i];
      }
  if (low > high) return { low: -1, high: 1, flat: null };
  const size = Math.max(Math.abs(low), Math.abs(high));
  const noise = Math.max(roundOff * Math.max(scale, size), precision * size);
  if (high - low > noise) return { low, high, flat: null };
  const middle = 0.5 * (low + high);
  if (Math.abs(middle) <= noise) return { low: -(scale || 1), high: scale || 1, flat: "zero" };
  return { low: Math.min(0, 2 * middle), high: Math.max(0, 2 * middle), flat: "constant" };
}

/** A value of a plot as its legend shows it: 0 if it is round-off of the others, or for this scale. */
export const withoutNoise = (value: number, scale: number, { low, high }: Range) =>
  Math.abs(value) < roundOff * Math.max(scale, Math.abs(low), Math.abs(high)) ? 0 : value;

/** The largest momentum that bodies with this total mass and kinetic energy can have. */
export const momentumScale = (mass: number, kinetic: number) => Math.sqrt(2 * mass * Math.max(kinetic, 0));

/** The largest distance of a body from the origin in these poses, or the size of a body if that is larger. */
export function reachOf(model: Model, poses: ArrayLike<number>): number {
  let most = typicalLength(model);
  for (let i = 0; i < poses.length; i += 7) most = Math.max(most, Math.hypot(poses[i], poses[i + 1], poses[i + 2]) || 0);
  return most;
}

/** The same over the whole run. */
function farthest(run: Recording): number {
  const step = Math.max(1, Math.floor(run.frames / 40));
  let most = 0;
  for (let frame = 0; frame < run.frames; frame += step) most = Math.max(most, reachOf(run.model, run.poses(frame)));
  return most;
}

/** The scales of one run, computed when they are needed. */
export class Scales {
  private readonly known = new Map<string, number>();

  constructor(private readonly run: Recording) {}

  world(quantity: WorldQuantity): number {
    return this.once(quantity, () => {
      const energies = this.run.world("energy");
      if (quantity === "energy" || quantity === "balance") return largestOf(energies);
      const mass = this.run.model.bodies.reduce((sum, body) => sum + body.mass, 0);
      const linear = momentumScale(mass, largestOf(energies.filter(({ label }) => label === "kinetic")));
      return quantity === "linear" ? linear : linear * farthest(this.run);
    });
  }

  /** One radian for angles, otherwise the largest value of that quantity in any joint. */
  joint(quantity: JointQuantity, unit: string): number {
    if (quantity === "q") return unit === "m" ? typicalLength(this.run.model) : 1;
    return this.once(`${quantity} ${unit}`, () => {
      const alike = (joint: string) => this.run.joint(joint, quantity).filter((column) => column.unit === unit);
      return this.run.joints.reduce((most, joint) => Math.max(most, largestOf(alike(joint))), 0);
    });
  }

  private once(key: string, compute: () => number): number {
    let value = this.known.get(key);
    if (value === undefined) this.known.set(key, (value = compute()));
    return value;
  }
}
