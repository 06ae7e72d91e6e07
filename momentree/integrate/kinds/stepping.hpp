#pragma once
// Time stepping for many contacts at once, after Moreau and Jean: a step of the classical Runge–Kutta method without contacts,
// then the impulses of all contacts that the bodies have reached in it. Nothing is located within steps. Of order 4 while nothing
// touches, of order 1 otherwise.
#include <algorithm>
#include <cmath>

#include <momentree/integrate/integrator.hpp>
#include <momentree/integrate/rk4_stages.hpp>
#include <momentree/integrate/step_contacts.hpp>

namespace momentree {

class Stepping final : public Integrator {
 public:
  static constexpr bool chooses_steps = false, takes_velocities = true, supports_contact = true, steps_through_contacts = true;
  static constexpr Variables default_variables = Variables::velocities;
  static constexpr const char* other_name = "moreau";
  static constexpr double damper_limit = 2.785, spring_limit = 2.97;  // of rk4
  Stepping(const Tree& tree, const StepControl& control);
  bool step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept override;
  void use(StepContacts* contacts) override { contacts_ = contacts; }
  void note_start() override {
    if (contacts_ != nullptr) contacts_->note_start();
  }
  void return_to_start() override {
    if (contacts_ != nullptr) contacts_->return_to_start();
  }

 private:
  bool fly(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h, double end) noexcept;
  double longest_;                           // part of a step (s): StepControl::max_step
  std::unique_ptr<double[]> q_, y_;          // stage, then result
  std::unique_ptr<double[]> q_sum_, y_sum_;  // weighted rates
  StepContacts* contacts_ = nullptr;
  State before_;  // of a step of several parts
};

inline Stepping::Stepping(const Tree& tree, const StepControl& control)
    : Integrator(tree, control),
      longest_(control.max_step),
      q_(scratch(7 * tree.bodies())),
      y_(scratch(6 * tree.bodies())),
      q_sum_(scratch(7 * tree.bodies())),
      y_sum_(scratch(6 * tree.bodies())) {}

// The motion without contacts may take several shorter steps; contacts get one set of impulses at the end.
inline bool Stepping::step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept {
  const double end = state.time() + h;
  const int parts = h > longest_ ? static_cast<int>(std::ceil((1 - 1e-9) * h / longest_)) : 1;
  if (parts == 1) {
    if (!fly(evaluate, state, ledger, h, end)) return false;
  } else {
    const EnergyLedger books = ledger;
    before_ = state;
    for (int k = 0; k < parts; ++k) {
      if (k > 0) evaluate(state);
      const bool last = k + 1 == parts;
      const double part = last ? end - state.time() : h / parts;
      if (fly(evaluate, state, ledger, part, last ? end : state.time() + part)) continue;
      state = before_, ledger = books;
      return false;
    }
  }
  if (contacts_ != nullptr) contacts_->apply(state, ledger, h);
  return true;
}

// A step without contacts, of h seconds until `end`.
inline bool Stepping::fly(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h, double end) noexcept {
  const Workspace<double>& workspace = evaluate.workspace();
  begin_step(evaluate, state, h);
  const Tree& tree = evaluate.tree();
  const int nq = tree.nq(), nv = tree.nv();
  const double *q = state.q().data(), *y = state.y().data(), t = state.time();
  Power sum{};
  // The evaluation of the state has the forces of contacts in the last step: the first stage is evaluated without them.
  rk4_stages<double>(h, {nq, q, workspace.qdot.get(), q_.get(), q_sum_.get()}, {nv, y, evaluate.ydot(), y_.get(), y_sum_.get()},
                     [&](double node, double weight, const double* stage_q, const double* stage_y) {
                       evaluate(t + node * h, stage_q, stage_y);
                       sum.dissipated += weight * workspace.power.dissipated;
                       sum.work += weight * workspace.power.work;
                     });
  end_step(tree, t + h, q_.get(), y_.get());
  if (!sound(tree, q, q_.get(), y_.get()) || !close(evaluate, t + h, q_.get(), y_.get())) return false;
  take_stored(tree, q, q_.get(), ledger);
  {
    const State::Edit edit = state.edit();
    std::copy_n(q_.get(), nq, edit.q.begin());
    std::copy_n(y_.get(), nv, edit.y.begin());
    edit.time = end;
  }
  ledger.dissipated += h / 6 * sum.dissipated;
  ledger.work += h / 6 * sum.work;
  book_closing(evaluate, state, ledger);
  return true;
}

}  // namespace momentree
