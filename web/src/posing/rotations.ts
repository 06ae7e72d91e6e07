// Rotation vectors (rad) of unit quaternions w, x, y, z.
import type { Quat, Vec3 } from "../recording";

/** The rotation about a vector by its length. */
export function exponential(vector: Vec3): Quat {
  const angle = Math.hypot(...vector);
  const factor = angle > 0 ? Math.sin(angle / 2) / angle : 0.5;
  return [Math.cos(angle / 2), factor * vector[0], factor * vector[1], factor * vector[2]];
}

/** The shortest rotation vector whose exponential is the unit quaternion. */
export function logarithm([w, x, y, z]: Quat): Vec3 {
  const sign = w < 0 ? -1 : 1;
  const s = Math.hypot(x, y, z);
  const factor = s > 0 ? (2 * Math.atan2(s, sign * w) * sign) / s : 2;
  return [factor * x, factor * y, factor * z];
}
