#pragma once
// Rotational spring of ball and free joints: energy ½ Σ kᵢ φᵢ², φ = log(q0⁻¹ q) in child axes. With equal stiffnesses the torque
// is −k φ. In general it is −J_r(φ)⁻ᵀ K φ, the gradient of that energy: −K φ alone would not conserve it.
#include <momentree/math/vec.hpp>

namespace momentree {

inline double rotational_spring(const double* q, const double* q0, const double* stiffness, double* torque) {
  const Quat relative = conjugate(Quat{q0[0], q0[1], q0[2], q0[3]}) * Quat{q[0], q[1], q[2], q[3]};
  const Vec3 phi = log_rotation(relative);
  const Vec3 f{stiffness[0] * phi.x, stiffness[1] * phi.y, stiffness[2] * phi.z};
  // J_r(φ)⁻ᵀ f = f − ½ φ × f + b φ × (φ × f), b = (1 − (θ/2) cot(θ/2)) / θ²
  const double theta = norm(phi);
  const double half = 0.5 * theta;
  const double b = theta < 1e-4 ? 1.0 / 12 + theta * theta / 720 : (1 - half / std::tan(half)) / (theta * theta);
  const Vec3 n = cross(phi, f);
  const Vec3 t = f - 0.5 * n + b * cross(phi, n);
  torque[0] = -t.x, torque[1] = -t.y, torque[2] = -t.z;
  return 0.5 * dot(f, phi);
}

}  // namespace momentree
