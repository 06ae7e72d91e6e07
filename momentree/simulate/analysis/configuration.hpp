#pragma once
// The joints of a world in other positions, at rest at its present time, without changing the world: for statics and inverse
// kinematics.
#include <functional>

#include <momentree/dynamics/tangent/acceleration_tangent.hpp>
#include <momentree/math/dense.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree::analysis {

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Configuration {
 public:
  explicit Configuration(const World& world);

  const Tree& tree() const { return *tree_; }
  const State& state() const { return state_; }
  Workspace<double>& workspace() { return workspace_; }
  int nv() const { return tree_->nv(); }
  Numbers q() const { return state_.q(); }
  /// Moves the joints by a displacement of nv numbers, and closes the loops again. False, with nothing moved, if they can't be,
  /// or if a loop joint would be beyond its hard stops.
  [[nodiscard]] bool displace(const std::vector<double>& step);
  /// Sets the coordinates (nq numbers), likewise.
  [[nodiscard]] bool set(const std::vector<double>& q);
  /// v̇ (nv numbers); zero for DoFs that are locked or have a prescribed motion.
  [[nodiscard]] std::vector<double> accelerations();
  /// Projects displacements (nv × nv) onto those that locks, prescribed motions and loops allow: the nearest ones in the metric
  /// of the mass matrix.
  [[nodiscard]] DenseMatrix projection();
  /// ∂v̇/∂q along the allowed displacements: exact, but with functions and with forces in loop joints by differences.
  [[nodiscard]] DenseMatrix slopes();
  /// Whether these are exact.
  [[nodiscard]] bool exact() const;
  /// The slopes of nv numbers along the columns of P, by central differences.
  /// Rounding and truncation are about equal at the default width.
  [[nodiscard]] DenseMatrix differences(const DenseMatrix& P, const std::function<std::vector<double>()>& f, double width = 1e-5);
  /// The mass matrix, in which locked DoFs and those with a prescribed motion have a one on the diagonal alone.
  [[nodiscard]] DenseMatrix mass();
  /// By DoF: true if it is locked or has a prescribed motion.
  [[nodiscard]] std::vector<bool> held() const;

 private:
  bool loops_within_limits(const double* q);

  const Tree* tree_;
  State state_;
  Workspace<double> workspace_;
};

/// Calls f(body, DoF, its place in arrays packed as p, its place in q) for the DoFs of joints whose velocities are rates of their
/// coordinates.
template <class F>
void each_coordinate(const Tree& tree, const F& f) {
  for (const int b : tree.order())
    if (info(tree.kind(b)).nq == info(tree.kind(b)).nv)
      for (int i = 0; i < info(tree.kind(b)).nv; ++i) f(b, i, tree.first_p(b) + i, tree.first_q(b) + i);
}
/// The limits of a DoF (rad, m); infinite without any. Soft stops are springs, not limits.
struct Bounds {
  double lower, upper;
};
Bounds bounds_of(const Tree& tree, int body, int dof);

}  // namespace momentree::analysis
