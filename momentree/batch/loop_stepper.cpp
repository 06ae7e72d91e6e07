#include <momentree/batch/loop_stepper.hpp>

#include <algorithm>
#include <vector>

#include <momentree/dynamics/loop_system.hpp>

namespace momentree::batch {

void LoopStepper::fit(const Tree& tree) {
  if (rk4_ == nullptr || workspace_.capacity() < tree.bodies()) {
    workspace_ = Workspace<double>(tree);
    momenta_ = State(tree, Variables::momenta), velocities_ = State(tree, Variables::velocities);
    rk4_ = make_integrator("rk4", tree);
  }
  detail::loop_memory(tree, workspace_);
  const std::vector<Turns> turns(tree.loops().size());
  momenta_.set_turns(turns), velocities_.set_turns(turns);
}

void LoopStepper::step(const Tree& tree, Variables variables, const Block& block) noexcept {
  const double h = *block.h;
  if (h == 0) return;
  const auto nq = static_cast<std::size_t>(tree.nq()), nv = static_cast<std::size_t>(tree.nv());
  State& state = variables == Variables::momenta ? momenta_ : velocities_;
  state.assign(*block.time, {block.q, nq}, {block.y, nv}, tree);
  state.set_turns({block.turns, tree.loops().size()});
  detail::loop_memory(tree, workspace_).efforts = block.effort;
  Evaluator evaluate(tree, workspace_);
  evaluate(state);
  EnergyLedger ledger;
  if (!rk4_->step(evaluate, state, ledger, h)) {
    *block.ran_away = 1;
    return;
  }
  *block.time = state.time();
  std::copy(state.q().begin(), state.q().end(), block.q);
  std::copy(state.y().begin(), state.y().end(), block.y);
  std::copy(state.turns().begin(), state.turns().end(), block.turns);
}

}  // namespace momentree::batch
