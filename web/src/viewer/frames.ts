// Poses of a recording at any time: frames are found by bisection, poses between two frames are interpolated.
import type { Joint, Phase, Motion } from "../recording";

/** The last index of `count` ordered numbers that does not exceed `time`; 0 if all exceed it. */
export function lastNotAfter(count: number, at: (index: number) => number, time: number): number {
  let low = 0;
  let high = count;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (at(middle) <= time) low = middle;
    else high = middle;
  }
  return low;
}

export const frameAt = (run: Motion, time: number) => lastNotAfter(run.frames, (frame) => run.time(frame), time);

export const phaseAt = (run: Motion, time: number): Phase =>
  run.phases[lastNotAfter(run.phases.length, (index) => run.phases[index].from, time)];

/** By body, its inboard joint: joints that close loops are in addition to those. */
export const inboardJoints = <J extends Pick<Joint, "child" | "loop">>(joints: readonly J[]): Map<number, J> =>
  new Map(joints.filter(({ loop }) => !loop).map((joint) => [joint.child, joint]));

export const startTime = (run: Motion) => (run.frames > 0 ? run.time(0) : 0);
export const endTime = (run: Motion) => (run.frames > 0 ? run.time(run.frames - 1) : 0);

/**
 * A body that rotates by more than this from a frame to the next (rad) may as well have rotated in the opposite
 * direction.
 */
const farthestTurn = 2.6;

/** Whether interpolation between a frame and the next would be misleading: the poses are then those of the frame. */
export function isGap(run: Motion, frame: number): boolean {
  if (frame + 1 >= run.frames) return false;
  if (run.gapAfter?.(frame)) return true;
  const [a, b] = [run.poses(frame), run.poses(frame + 1)];
  const least = Math.cos(0.5 * farthestTurn);
  for (let i = 3; i < a.length; i += 7)
    if (Math.abs(a[i] * b[i] + a[i + 1] * b[i + 1] + a[i + 2] * b[i + 2] + a[i + 3] * b[i + 3]) < least) return true;
  return false;
}

/**
 * Poses at a time, between the two frames around it: positions on a line, rotations on the shorter arc. They are
 * continuous.
 */
export function posesAt(run: Motion, time: number, out: Float64Array): Float64Array {
  if (run.frames === 0) return out;
  const frame = frameAt(run, time);
  const a = run.poses(frame);
  const next = Math.min(frame + 1, run.frames - 1);
  const span = run.time(next) - run.time(frame);
  const share = span > 0 ? Math.min(Math.max((time - run.time(frame)) / span, 0), 1) : 0;
  if (share === 0 || (share < 1 && isGap(run, frame))) {
    out.set(a);
    return out;
  }
  const b = run.poses(next);
  for (let i = 0; i < out.length; i += 7) {
    for (let k = 0; k < 3; k++) out[i + k] = a[i + k] + share * (b[i + k] - a[i + k]);
    let along = 0;
    for (let k = 3; k < 7; k++) along += a[i + k] * b[i + k];
    const sign = along < 0 ? -1 : 1;
    // For nearby frames the normalised line is as good as the arc; for distant ones the rotation is uniform on the arc.
    const angle = Math.acos(Math.min(Math.abs(along), 1));
    const small = angle < 1e-3;
    const wa = small ? 1 - share : Math.sin((1 - share) * angle) / Math.sin(angle);
    const wb = sign * (small ? share : Math.sin(share * angle) / Math.sin(angle));
    let size = 0;
    for (let k = 3; k < 7; k++) {
      out[i + k] = wa * a[i + k] + wb * b[i + k];
      size += out[i + k] * out[i + k];
    }
    size = Math.sqrt(size) || 1;
    for (let k = 3; k < 7; k++) out[i + k] /= size;
  }
  return out;
}

/** A point of a body in the world. */
export function pointOf(poses: ArrayLike<number>, body: number, point: ArrayLike<number>): [number, number, number] {
  const i = 7 * body;
  const [w, x, y, z] = [poses[i + 3], poses[i + 4], poses[i + 5], poses[i + 6]];
  const tx = 2 * (y * point[2] - z * point[1]);
  const ty = 2 * (z * point[0] - x * point[2]);
  const tz = 2 * (x * point[1] - y * point[0]);
  return [
    poses[i] + point[0] + w * tx + y * tz - z * ty,
    poses[i + 1] + point[1] + w * ty + z * tx - x * tz,
    poses[i + 2] + point[2] + w * tz + x * ty - y * tx,
  ];
}
