// Unit quaternions w, x, y, z and vectors, as needed for kinematics.
import type { Pose, Quat, Vec3 } from "../recording";

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const scaled = (a: Vec3, s: number): Vec3 => [a[0] * s, a[1] * s, a[2] * s];

export const product = ([a, b, c, d]: Quat, [e, f, g, h]: Quat): Quat => [
  a * e - b * f - c * g - d * h,
  a * f + b * e + c * h - d * g,
  a * g - b * h + c * e + d * f,
  a * h + b * g - c * f + d * e,
];

export const conjugate = ([w, x, y, z]: Quat): Quat => [w, -x, -y, -z];

export function rotate([w, x, y, z]: Quat, [a, b, c]: Vec3): Vec3 {
  const t: Vec3 = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * t[0] + y * t[2] - z * t[1], b + w * t[1] + z * t[0] - x * t[2], c + w * t[2] + x * t[1] - y * t[0]];
}

/** The rotation by an angle (rad) about a unit axis. */
export function about(axis: Vec3, angle: number): Quat {
  const s = Math.sin(angle / 2);
  return [Math.cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]];
}

/** The rotation about a vector by its length (rad). */
export function exponential(turn: Vec3): Quat {
  const angle = Math.hypot(...turn);
  return angle > 0 ? about(scaled(turn, 1 / angle), angle) : [1, 0, 0, 0];
}

/** The shortest rotation vector whose exponential is the unit quaternion. */
export function logarithm([w, x, y, z]: Quat): Vec3 {
  const sign = w < 0 ? -1 : 1;
  const s = Math.hypot(x, y, z);
  const factor = s > 0 ? (2 * Math.atan2(s, sign * w) * sign) / s : 2;
  return [factor * x, factor * y, factor * z];
}

export const unit: Pose = { xyz: [0, 0, 0], quat: [1, 0, 0, 0] };

/** First b, then a. */
export const compose = (a: Pose, b: Pose): Pose => ({ xyz: add(a.xyz, rotate(a.quat, b.xyz)), quat: product(a.quat, b.quat) });

export function inverse(a: Pose): Pose {
  const quat = conjugate(a.quat);
  return { xyz: scaled(rotate(quat, a.xyz), -1), quat };
}
