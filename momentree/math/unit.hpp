#pragma once
// Unit vectors and quaternions from user input.
#include <cmath>
#include <limits>

#include <momentree/math/vec.hpp>

namespace momentree {

/// True if a length is 1 up to the rounding of a normalisation.
inline bool is_unit(double squared_length) { return std::fabs(squared_length - 1) <= 4 * std::numeric_limits<double>::epsilon(); }

/// As normalized(), but unit input keeps its bits, so that numbers that were written to a file read back unchanged.
inline Quat unit(const Quat& q) { return is_unit(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z) ? q : normalized(q); }
inline Vec3 unit(const Vec3& a) {
  if (is_unit(dot(a, a))) return a;
  const double largest = std::fmax(std::fabs(a.x), std::fmax(std::fabs(a.y), std::fabs(a.z)));
  return largest == 0 ? a : normalized((1 / largest) * a);  // first scaled, because the square of a very small or large vector
                                                            // may under- or overflow
}

inline bool is_finite(const Vec3& a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }
/// True if the length is 1 up to the rounding of long computations.
inline bool is_direction(const Vec3& a) { return std::fabs(dot(a, a) - 1) < 1e-6; }
inline bool is_rotation(const Quat& a) { return std::fabs(a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z - 1) < 1e-6; }
inline bool is_placement(const Pose& a) { return is_finite(a.position) && is_rotation(a.rotation); }

}  // namespace momentree
