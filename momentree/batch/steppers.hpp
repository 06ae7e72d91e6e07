#pragma once
// The steppers of a batch, one of each kind per thread, for trees of at most a given size.
#include <algorithm>
#include <memory>
#include <vector>

#include <momentree/batch/group.hpp>
#include <momentree/batch/loop_stepper.hpp>
#include <momentree/batch/stepper.hpp>

namespace momentree::batch {

struct Steppers {
  Isa isa;
  Precision precision;
  std::vector<std::unique_ptr<TreeStepper>> trees;     // by thread
  std::vector<LoopStepper> loops;                      // by thread, of worlds with loops in momenta
  std::vector<std::unique_ptr<LoopLanes>> loop_lanes;  // by thread, of worlds with loops in velocities
  int capacity = 0, lanes = 0, loop_capacity = 0;

  /// For trees of that size; `threads` 0: worlds are stepped one by one, without these.
  void make(const Tree& tree, Variables variables, int threads) {
    trees.clear();
    capacity = tree.bodies(), lanes = 1;
    for (int i = 0; i < threads; ++i) trees.push_back(make_stepper(isa, precision, tree, variables));
    if (threads > 0) lanes = trees[0]->lanes();
  }
  /// Lanes of worlds with loops in velocities.
  int lanes_with_loops(const Tree& tree, int threads) {
    if (loop_lanes.empty() || loop_capacity < tree.bodies()) {
      loop_lanes.clear();
      for (int i = 0; i < threads; ++i) loop_lanes.push_back(make_loop_lanes(isa, tree));
    }
    return loop_lanes[0]->lanes();
  }
  /// True if all groups with loops must be fitted again.
  bool prepare_loops(const Tree& tree, Variables variables, int threads) {
    const bool grows = tree.bodies() > loop_capacity;
    loop_capacity = std::max(loop_capacity, tree.bodies());
    loops.resize(static_cast<std::size_t>(threads));
    fit_loops(tree, variables);
    return grows;
  }
  void fit_loops(const Tree& tree, Variables variables) {
    for (LoopStepper& stepper : loops)
      if (variables == Variables::momenta) stepper.fit(tree);
    for (const auto& stepper : loop_lanes)
      if (variables == Variables::velocities) stepper->fit(tree);
  }

  void step(int thread, Group& group, const Block& block) {
    const auto own = static_cast<std::size_t>(thread);
    if (!group.tree().has_loops())
      trees[own]->step(group.tree(), group.plan(), block);
    else if (group.variables() == Variables::velocities)
      loop_lanes[own]->step(group.tree(), group.plan(), block);
    else
      loops[own].step(group.tree(), block);
  }
};

}  // namespace momentree::batch
