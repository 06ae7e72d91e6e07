#pragma once
// The forces at simultaneous contacts: unilateral normals and Coulomb friction, (C1) and (C2) of docs/theory.md. The same system
// gives impulses from velocities and forces from accelerations.
//
// Of each point i the unknowns are r_i = (N, t1, t2), and w = b + A r are the relative velocities (or accelerations) along the
// same directions, where A = J M⁻¹ Jᵀ is symmetric and positive semidefinite. The law of a point:
//
//   N ≥ N0,  w_n ≥ 0,  (N − N0) w_n = 0,
//   |t| ≤ μ N,  and t = −μ N w_t/|w_t| unless w_t = 0.
//
// N0 is zero except in the expansion of an impact. A point that slips already has a given direction s: t = −μ N s.
// With friction at several points the solution need not be unique; the solver starts from `r`, and equal input gives equal
// output.
#include <array>
#include <cstddef>
#include <vector>

#include <momentree/contact/law_newton.hpp>

namespace momentree::contact {

/// The law of one point.
struct PointLaw {
  double friction = 0;                ///< μ
  double least = 0;                   ///< N0
  bool slipping = false;              ///< in the direction `direction`
  std::array<double, 2> direction{};  ///< unit vector s in the tangent plane
};

/// How a point of a solution behaves.
enum class PointState : unsigned char { open, stick, slip };

class System {
 public:
  /// Makes room for that many points; A, b and r are then zero, laws are without friction.
  void resize(std::size_t points);
  std::size_t points() const { return laws.size(); }
  std::size_t unknowns() const { return 3 * laws.size(); }

  double& element(std::size_t row, std::size_t column) { return A[row * unknowns() + column]; }
  double element(std::size_t row, std::size_t column) const { return A[row * unknowns() + column]; }

  /// Finds r, from the present one. Returns false if no solution was found: r is then the best one that was. `acceptable`: the
  /// residual of a solution that cannot be improved, such as where redundant rows contradict each other by rounding.
  [[nodiscard]] bool solve(double acceptable = 1e-11);

  /// w_i of all unknowns at the present r.
  void velocities(std::vector<double>& w) const;
  /// Largest violation of the law at r, as a velocity relative to the largest one of the problem.
  double residual();
  PointState state(std::size_t point) const;
  /// ½ rᵀA r + bᵀr: the change of kinetic energy by impulses r.
  double energy_change() const;

  std::vector<double> A, b;  ///< A row by row
  std::vector<double> r;
  std::vector<PointLaw> laws;

 private:
  double velocity(std::size_t row) const;
  double scale() const;
  bool moves(std::size_t point) const { return element(3 * point, 3 * point) > 0; }
  void prepare();
  double prepared_residual();

  LawNewton newton_;
  std::vector<double> impulses_;  // of the points that move
};

}  // namespace momentree::contact
