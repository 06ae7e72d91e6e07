#pragma once
// The classical Runge–Kutta method of order 4, as in the paper: fixed steps, four evaluations, reproducible.
#include <algorithm>

#include <momentree/integrate/integrator.hpp>
#include <momentree/integrate/rk4_stages.hpp>

namespace momentree {

class Rk4 final : public Integrator {
 public:
  static constexpr bool chooses_steps = false, takes_velocities = true, supports_contact = true, steps_through_contacts = false;
  static constexpr Variables default_variables = Variables::momenta;
  // Stability limits of step times the rate of a damper, or the frequency of a spring (the furthest extent of the stability
  // region).
  static constexpr double damper_limit = 2.785, spring_limit = 2.97;
  Rk4(const Tree& tree, const StepControl& control);
  bool step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept override;
  bool is_that_of_lanes() const override { return true; }

 private:
  std::unique_ptr<double[]> q_, y_;          // stage, then result
  std::unique_ptr<double[]> q_sum_, y_sum_;  // weighted rates
};

inline Rk4::Rk4(const Tree& tree, const StepControl& control)
    : Integrator(tree, control),
      q_(scratch(7 * tree.bodies())),
      y_(scratch(6 * tree.bodies())),
      q_sum_(scratch(7 * tree.bodies())),
      y_sum_(scratch(6 * tree.bodies())) {}

inline bool Rk4::step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept {
  const Workspace<double>& workspace = evaluate.workspace();
  begin_step(evaluate, state, h);
  const int nq = evaluate.tree().nq(), nv = evaluate.tree().nv();
  const double *q = state.q().data(), *y = state.y().data(), t = state.time();
  Power sum{};
  rk4_stages<double>(h, {nq, q, workspace.qdot.get(), q_.get(), q_sum_.get()}, {nv, y, evaluate.ydot(), y_.get(), y_sum_.get()},
                     [&](double node, double weight, const double* stage_q, const double* stage_y) {
                       if (node > 0) evaluate(t + node * h, stage_q, stage_y);  // the start is already evaluated
                       sum.dissipated += weight * workspace.power.dissipated;
                       sum.work += weight * workspace.power.work;
                     });
  end_step(evaluate.tree(), t + h, q_.get(), y_.get());
  if (!sound(evaluate.tree(), q, q_.get(), y_.get()) || !close(evaluate, t + h, q_.get(), y_.get())) return false;
  take_stored(evaluate.tree(), q, q_.get(), ledger);
  const State::Edit edit = state.edit();
  std::copy_n(q_.get(), nq, edit.q.begin());
  std::copy_n(y_.get(), nv, edit.y.begin());
  edit.time += h;
  ledger.dissipated += h / 6 * sum.dissipated;
  ledger.work += h / 6 * sum.work;
  book_closing(evaluate, state, ledger);
  return true;
}

}  // namespace momentree
