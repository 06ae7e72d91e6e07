#pragma once
// Measures by which tests compare mechanisms with closed loops in momenta and in velocities.
#include <algorithm>
#include <cmath>

#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/loop_rows.hpp>

namespace momentree::oracle {

inline Vector as_vector(const double* numbers, int n) { return Eigen::Map<const Vector>(numbers, n); }
inline double largest(const Vector& x) { return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff(); }

// The derivative of f at 0 by central differences of order 8.
template <class F>
Vector derivative(const F& f, double h) {
  constexpr double weights[4] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  Vector sum = Vector::Zero(f(0.0).size());
  for (int k = 1; k <= 4; ++k) sum += weights[k - 1] / h * (f(k * h) - f(-k * h));
  return sum;
}

// How many digits a change of the momenta by rounding costs: the norm of H⁻¹ by its columns, times the largest momentum.
inline double amplification(const World& world, const Vector& p) {
  const int n = world.tree().nv();
  Matrix inverse(n, n);
  world.equations().inverse_mass_matrix(inverse.data());
  return largest(inverse.cwiseAbs() * p.cwiseAbs());
}

// Largest difference of poses and velocities of bodies.
inline double apart(const World& a, const World& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.motions().size(); ++i) {
    const BodyMotion &one = a.motions()[i], &two = b.motions()[i];
    most = std::max(
        {most, norm(one.pose.position - two.pose.position), norm(one.linear - two.linear), norm(one.angular - two.angular)});
  }
  return most;
}
inline double fastest(const World& world) {
  double most = 1;
  for (const BodyMotion& m : world.motions()) most = std::max({most, norm(m.linear), norm(m.angular)});
  return most;
}

inline Simulation run_of(const Model& model, const char* method, Variables variables, double step = 1e-3) {
  return Simulation(model, {.method = method, .variables = variables, .step = step, .rtol = 1e-11, .atol = 1e-13});
}

}  // namespace momentree::oracle
