#include <momentree/batch/loop_stepper.hpp>

#include <algorithm>
#include <vector>

#include <momentree/dynamics/loops/loop_system.hpp>

namespace momentree::batch {

void LoopStepper::fit(const Tree& tree) {
  if (rk4_ == nullptr || workspace_.capacity() < tree.bodies()) {
    workspace_ = Workspace<double>(tree);
    state_ = State(tree, Variables::momenta);
    rk4_ = make_integrator("rk4", tree);
  }
  detail::loop_memory(tree, workspace_);
  state_.set_turns(std::vector<Turns>(tree.loops().size()));
}

void LoopStepper::step(const Tree& tree, const Block& block) noexcept {
  const double h = *block.h;
  if (h == 0) return;
  const auto nq = static_cast<std::size_t>(tree.nq()), nv = static_cast<std::size_t>(tree.nv());
  state_.assign(*block.time, {block.q, nq}, {block.y, nv}, tree);
  state_.set_turns({block.turns, tree.loops().size()});
  detail::loop_memory(tree, workspace_).efforts = block.effort;
  Evaluator evaluate(tree, workspace_);
  evaluate(state_);
  EnergyLedger ledger;
  if (!rk4_->step(evaluate, state_, ledger, h)) {
    *block.diverged = 1;
    return;
  }
  *block.time = state_.time();
  std::copy(state_.q().begin(), state_.q().end(), block.q);
  std::copy(state_.y().begin(), state_.y().end(), block.y);
  std::copy(state_.turns().begin(), state_.turns().end(), block.turns);
}

}  // namespace momentree::batch
