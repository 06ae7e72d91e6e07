#pragma once
// The classical Runge–Kutta method of order 4, as in the paper: fixed steps, four evaluations, reproducible.
#include <algorithm>

#include <momentree/integrate/integrator.hpp>

namespace momentree {

namespace detail {
// sum += weight·rate, stage = start + h·rate
inline void advance(int n, const double* start, const double* rate, double weight, double h, double* sum, double* stage) {
  for (int i = 0; i < n; ++i) {
    sum[i] += weight * rate[i];
    stage[i] = start[i] + h * rate[i];
  }
}
}  // namespace detail

class Rk4 final : public Integrator {
 public:
  static constexpr bool chooses_steps = false;
  // Stability limits of step times the rate of a damper, or the frequency of a spring (the furthest extent of the stability
  // region).
  static constexpr double damper_limit = 2.785, spring_limit = 2.97;
  Rk4(const Tree& tree, const StepControl& control);
  bool step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept override;

 private:
  std::unique_ptr<double[]> q_, p_;          // stage, then result
  std::unique_ptr<double[]> q_sum_, p_sum_;  // weighted rates
};

inline Rk4::Rk4(const Tree& tree, const StepControl& control)
    : Integrator(tree, control),
      q_(scratch(7 * tree.bodies())),
      p_(scratch(6 * tree.bodies())),
      q_sum_(scratch(7 * tree.bodies())),
      p_sum_(scratch(6 * tree.bodies())) {}

inline bool Rk4::step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept {
  const Workspace<double>& workspace = evaluate.workspace();
  require_ready(evaluate, state, h);
  const int nq = evaluate.tree().nq(), nv = evaluate.tree().nv();
  const double *q = state.q().data(), *p = state.p().data(), t = state.time();
  std::fill_n(q_sum_.get(), nq, 0.0);
  std::fill_n(p_sum_.get(), nv, 0.0);
  Power sum{};
  constexpr double weights[4] = {1, 2, 2, 1}, nodes[4] = {0.5, 0.5, 1, 0};
  for (int stage = 0; stage < 4; ++stage) {
    if (stage > 0) evaluate(t + nodes[stage - 1] * h, q_.get(), p_.get());
    const double w = weights[stage], to_next = nodes[stage] * h;
    detail::advance(nq, q, workspace.qdot.get(), w, to_next, q_sum_.get(), q_.get());
    detail::advance(nv, p, workspace.pdot.get(), w, to_next, p_sum_.get(), p_.get());
    sum.dissipated += w * workspace.power.dissipated;
    sum.work += w * workspace.power.work;
  }
  const double h6 = h / 6;
  for (int i = 0; i < nq; ++i) q_[static_cast<std::size_t>(i)] = q[i] + h6 * q_sum_[static_cast<std::size_t>(i)];
  for (int i = 0; i < nv; ++i) p_[static_cast<std::size_t>(i)] = p[i] + h6 * p_sum_[static_cast<std::size_t>(i)];
  end_step(evaluate.tree(), t + h, q_.get(), p_.get());
  if (!sound(evaluate.tree(), q, q_.get(), p_.get())) return false;
  take_stored(evaluate.tree(), q, q_.get(), ledger);
  const State::Edit edit = state.edit();
  std::copy_n(q_.get(), nq, edit.q.begin());
  std::copy_n(p_.get(), nv, edit.p.begin());
  edit.time += h;
  ledger.dissipated += h6 * sum.dissipated;
  ledger.work += h6 * sum.work;
  return true;
}

}  // namespace momentree
