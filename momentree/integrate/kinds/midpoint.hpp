#pragma once
// The implicit midpoint rule, order 2: z1 = z0 + h f((z0 + z1)/2), by fixed-point iteration on the midpoint. Symplectic in
// momenta, for joints whose velocities are rates of coordinates (holonomic ones); not for ball and free joints, whose momenta
// refer to body axes, and not in velocities.
#include <cmath>

#include <momentree/integrate/integrator.hpp>

namespace momentree {

class Midpoint final : public Integrator {
 public:
  static constexpr bool chooses_steps = false, takes_velocities = true, supports_contact = false, steps_through_contacts = false;
  static constexpr Variables default_variables = Variables::momenta;
  // Above these the iteration does not converge.
  static constexpr double damper_limit = 2, spring_limit = 2;
  Midpoint(const Tree& tree, const StepControl& control);
  bool step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept override;

 private:
  static constexpr int most_iterations = 60;
  static constexpr double converged = 1e-13, stalled = 1e-10;
  std::unique_ptr<double[]> q_, y_;  // midpoint, then result
};

inline Midpoint::Midpoint(const Tree& tree, const StepControl& control)
    : Integrator(tree, control), q_(scratch(7L * tree.bodies())), y_(scratch(6L * tree.bodies())) {}

inline bool Midpoint::step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept {
  const Workspace<double>& workspace = evaluate.workspace();
  begin_step(evaluate, state, h);
  const int nq = evaluate.tree().nq(), nv = evaluate.tree().nv();
  const double *q = state.q().data(), *y = state.y().data();
  std::copy_n(q, nq, q_.get());
  const double* const ydot = evaluate.ydot();
  double change = HUGE_VAL;
  // If the midpoint moves by less than `converged`, its velocities are known to that over h/2; one more iteration carries this
  // accuracy over to the momenta. Round-off in long chains is larger than that, so an iteration that no longer improves is
  // accepted if the change is small.
  for (int i = 0, settled = 0; settled < 2; ++i) {
    if (i == most_iterations) return false;
    if (i > 0) evaluate(state.time() + h / 2, q_.get(), y_.get());
    double moved = 0;
    for (int k = 0; k < nq; ++k) {
      const double next = q[k] + h / 2 * workspace.qdot[static_cast<std::size_t>(k)];
      moved = std::max(moved, std::fabs(next - q_[static_cast<std::size_t>(k)]) / (1 + std::fabs(next)));
      q_[static_cast<std::size_t>(k)] = next;
    }
    for (int k = 0; k < nv; ++k) y_[static_cast<std::size_t>(k)] = y[k] + h / 2 * ydot[k];
    if (i > 0 && (moved <= converged || (moved <= stalled && moved >= change))) ++settled;
    change = moved;
  }
  for (int k = 0; k < nq; ++k) q_[static_cast<std::size_t>(k)] = 2 * q_[static_cast<std::size_t>(k)] - q[k];
  for (int k = 0; k < nv; ++k) y_[static_cast<std::size_t>(k)] = 2 * y_[static_cast<std::size_t>(k)] - y[k];
  end_step(evaluate.tree(), state.time() + h, q_.get(), y_.get());
  const Power power = workspace.power;  // closing loops evaluates, too
  if (!sound(evaluate.tree(), q, q_.get(), y_.get()) || !close(evaluate, state.time() + h, q_.get(), y_.get())) return false;
  take_stored(evaluate.tree(), q, q_.get(), ledger);
  const State::Edit edit = state.edit();
  std::copy_n(q_.get(), nq, edit.q.begin());
  std::copy_n(y_.get(), nv, edit.y.begin());
  edit.time += h;
  ledger.dissipated += h * power.dissipated;
  ledger.work += h * power.work;
  book_closing(evaluate, state, ledger);
  return true;
}

}  // namespace momentree
