#pragma once
// Problems of contact in the form of Siconos, and its solvers for them.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include <FrictionContactProblem.h>
#include <Friction_cst.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <NumericsVerbose.h>
#include <SolverOptions.h>
#include <fc3d_compute_error.h>

#include <momentree/contact/system.hpp>

namespace momentree::peers {

/// A system whose laws are Coulomb's, in units in which the largest element on the diagonal of A and the largest |b| are 1.
class Siconos {
 public:
  explicit Siconos(const contact::System& system) : A_(system.A), b_(system.b) {
    for (std::size_t i = 0; i < b_.size(); ++i) mobility_ = std::max(mobility_, system.element(i, i));
    for (const double x : b_) speed_ = std::max(speed_, std::fabs(x));
    for (double& x : A_) x /= mobility_;
    for (double& x : b_) x /= speed_;
    for (const contact::PointLaw& law : system.laws) friction_.push_back(law.friction);
    const int rows = static_cast<int>(b_.size());
    matrix_.reset(NM_create_from_data(NM_DENSE, rows, rows, A_.data()));  // symmetric: its order of elements does not matter
    problem_ = {3, rows / 3, matrix_.get(), b_.data(), friction_.data()};
    numerics_set_verbose(0);
  }
  ~Siconos() { matrix_->matrix0 = nullptr; }  // it belongs to A_
  Siconos(const Siconos&) = delete;
  Siconos& operator=(const Siconos&) = delete;

  /// How much impulses violate the law, by Siconos' own measure: |r − P(r − w − μ|w_t| n)|, P the projection on all cones.
  double error(const std::vector<double>& r) const {
    std::vector<double> scaled = to_scaled(r), w(r.size());
    return error_of(scaled, w);
  }

  struct Answer {
    std::vector<double> r, w;
    double error = HUGE_VAL;
  };
  /// Gauss–Seidel sweeps, then Newton's method of Alart and Curnier if that is better. `guess`: impulses to start from.
  Answer solve(std::vector<double> guess, int sweeps) const {
    std::vector<double> r = to_scaled(guess), w(r.size());
    solve_by(SICONOS_FRICTION_3D_NSGS, sweeps, r, w);
    double error = error_of(r, w);
    if (!(error <= 10 * accuracy)) {
      std::vector<double> refined = r, velocity(r.size());
      solve_by(SICONOS_FRICTION_3D_NSN_AC, 200, refined, velocity);
      if (const double other = error_of(refined, velocity); other < error) r = refined, w = velocity, error = other;
    }
    for (double& x : r) x *= speed_ / mobility_;
    for (double& x : w) x *= speed_;
    return {std::move(r), std::move(w), error};
  }

 private:
  static constexpr double accuracy = 1e-13;
  struct Free {
    void operator()(NumericsMatrix* matrix) const { NM_clear(matrix), std::free(matrix); }
  };

  std::vector<double> to_scaled(std::vector<double> r) const {
    for (double& x : r) x *= mobility_ / speed_;
    return r;
  }
  double error_of(std::vector<double>& r, std::vector<double>& w) const {
    double error = 0;
    fc3d_compute_error(&problem_, r.data(), w.data(), accuracy, nullptr, 1, &error);
    return std::isfinite(error) ? error : HUGE_VAL;
  }
  void solve_by(int solver, int iterations, std::vector<double>& r, std::vector<double>& w) const {
    SolverOptions* const options = solver_options_create(solver);
    options->dparam[SICONOS_DPARAM_TOL] = accuracy;
    options->iparam[SICONOS_IPARAM_MAX_ITER] = iterations;
    fc3d_driver(&problem_, r.data(), w.data(), options);
    solver_options_delete(options);
    std::free(options);
  }

  std::vector<double> A_, b_, friction_;
  double mobility_ = 0, speed_ = 0;
  std::unique_ptr<NumericsMatrix, Free> matrix_;
  mutable FrictionContactProblem problem_{};
};

}  // namespace momentree::peers
