#pragma once
// Implementation of Batch. Included only by the files of this folder.
#include <momentree/batch/batch.hpp>

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <momentree/batch/group.hpp>
#include <momentree/batch/pool.hpp>
#include <momentree/batch/simulated_world.hpp>
#include <momentree/batch/steppers.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/simulate/names.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/tree/edit.hpp>
#include <momentree/tree/packed.hpp>

namespace momentree {

using batch::Group;

struct Batch::Impl {
  struct Seat {
    Group* group;
    int slot;
  };
  struct Task {
    Group* group;
    int block;
  };
  // What the batch was made of.
  struct Basis {
    Basis(const Model& the_model, const BatchOptions& options)
        : model(the_model),
          declared(model),
          integration(batch::integration_of(the_model, options)),
          variables(integration.state_variables(model)),
          loop_variables(model.has_contact() ? Variables::velocities : integration.loop_variables()),
          one_by_one(model.has_contact() || batch::unsupported(declared)) {}
    const Model model;
    const Tree declared;
    const Topology topology = declared.topology();
    Integration integration;              // of a simulation of one world
    Variables variables, loop_variables;  // of worlds without and with closed loops
    const bool one_by_one;                // each world is stepped by a simulation of its own
  };
  const Basis basis;
  batch::Steppers steppers;
  std::unordered_multimap<std::size_t, std::unique_ptr<Group>> groups;  // by the topology's key
  std::vector<Seat> seats;                                              // by world
  std::vector<std::unique_ptr<batch::SimulatedWorld>> simulated;        // by world; empty: worlds are stepped in lanes
  std::vector<std::vector<batch::ExtraEffort>> efforts;                 // by world
  bool had_loops = false;                                               // a world had a loop joint
  batch::Pool pool;
  Out out;
  State at_start;  // of each world
  bool editing = false;
  /// Names of a world that differ from the model's, as of its last action, and the number of its events.
  struct Named {
    std::vector<std::pair<int, std::string>> joints, mechanisms;
    std::vector<int> free;  // joints that breaks had made
    std::size_t events = 0;
  };
  std::unordered_map<int, Named> named;  // only worlds in which actions happened
  struct Trial {                         // the simulation in which actions are carried out
    std::unique_ptr<Simulation> simulation;
    bool is_used = false;  // its next loop joint may get a number that depends on earlier ones
  };
  Trial trial;
  bool numbered = false;  // the groups' numbers are valid
  // Scratch memory of arrays.cpp, by thread.
  struct Scratch {
    Workspace<double> workspace;
    ProjectionBuffers projection;
    std::vector<double> q, v, lanes;
    // Ensures room for a world with this tree.
    void fit(const Tree& tree) {
      if (workspace.capacity() < tree.bodies()) workspace = Workspace<double>(tree);
      q.resize(static_cast<std::size_t>(tree.nq())), v.resize(static_cast<std::size_t>(tree.nv()));
    }
  };
  struct Call {
    std::vector<Task> tasks;  // of the current step
    std::vector<Scratch> scratches;
    std::vector<double> converted;    // rows of the current call, in the batch's variables
    std::vector<int> rows;            // of the current call, in the order of slots
    std::vector<std::size_t> firsts;  // by task, its first place in `rows`
  };
  Call call;

  Impl(const Model& the_model, const BatchOptions& options, int threads)
      : basis(the_model, options), steppers{batch::best_isa(options.widest), options.precision, {}, {}, {}}, pool(threads) {
    out.state = State(basis.declared, basis.variables);
  }

  // Throws Error for features that the batch's worlds can't have.
  void check(const Tree& tree) const;

  Group& group_of(const Tree& tree) { return group_of(tree.topology(), tree); }
  // `tree` has this topology, or that and contacts, which groups do not have.
  Group& group_of(Topology topology, const Tree& tree) {
    MT_REQUIRE(topology.model == basis.topology.model, "after the edit, the tree still belongs to the batch's model");
    batch::simplify(topology, basis.declared);
    const std::size_t key = batch::key_of(topology);
    const auto [begin, end] = groups.equal_range(key);
    for (auto i = begin; i != end; ++i)
      if (batch::same(i->second->topology(), topology)) return *i->second;
    make_room(tree);
    Group& group = *groups.emplace(key, new_group(std::move(topology), tree))->second;
    if (tree.has_loops() && !basis.one_by_one) prepare_loops(group.tree());
    return group;
  }

  void sit(int world, Group& group) {
    numbered = false;
    seats[static_cast<std::size_t>(world)] = {&group, group.add(world)};
  }
  void leave(Seat seat) {
    numbered = false;
    const int moved = seat.group->remove(seat.slot);
    if (moved >= 0) seats[static_cast<std::size_t>(moved)].slot = seat.slot;
    if (seat.group->worlds() > 0) return;
    auto i = groups.equal_range(seat.group->key()).first;
    while (i->second.get() != seat.group) ++i;
    groups.erase(i);
  }

  void run() noexcept {
    call.tasks.clear();
    for (const auto& [key, group] : groups)
      for (int i = 0; i < group->blocks(); ++i) call.tasks.push_back({group.get(), i});
    pool.run(static_cast<int>(call.tasks.size()), [this](int thread, int i) {
      Group& group = *call.tasks[static_cast<std::size_t>(i)].group;
      const batch::Block block = group.block(call.tasks[static_cast<std::size_t>(i)].block);
      steppers.step(thread, group, block);
    });
  }
  const Seat& seat(int world) const {
    MT_REQUIRE(world >= 0 && world < static_cast<int>(seats.size()), "the batch has this world");
    return seats[static_cast<std::size_t>(world)];
  }

  /// The group of all these worlds, which are at least one; throws Error if there are several.
  Group& common(std::span<const int> worlds) const;
  /// The same, after writing `rows`: the numbers of the rows in the order of their worlds' slots.
  Group& common_rows(std::span<const int> worlds);
  JointNamer namer(int world) const;
  /// Momenta of velocities, or velocities of momenta, at coordinates q; of driven DoFs, y has and gets the rates, of locked ones
  /// zero. y and `to` may be the same.
  static void convert(const Tree& tree, Variables given, const double* q, const double* y, double* to, Scratch& own);
  void read_velocities(Group& group, std::span<const int> worlds, double* v);
  /// Sets the state of a world; converts one in the other variables.
  void set_state(const Seat& seat, const State& state);
  void write_closed(std::span<const int> worlds, Variables given, const std::function<double(std::size_t, Scratch&)>& take);
  /// Names in a world, whose tree may just have been changed.
  Names names_of(int world, const Tree& tree) const;
  /// The world's present names that differ from the model's.
  Named names_now(int world) const;
  /// Closes the loops of a state for a world; throws Error if one cannot be closed.
  void close(int world, const Tree& tree, State& state) const;
  /// After a change from tree `before` to `after`: ends the extra efforts of joints that are no longer the same.
  void drop_efforts(int world, const Tree& before, const Tree& after);
  /// The names in a simulation's world, which had the names `before`. `made_loops` becomes true if loop joints were made since
  /// the start of the model, even if they are no more.
  Named names_in(const World& world, Named before, bool& made_loops) const;
  /// A world, with its names, as a start for a simulation.
  WorldSnapshot snapshot_of(int world) const;

  // Of worlds that are stepped one by one: simulated_worlds.cpp.
  void make_simulations(std::span<const int> worlds);
  void step_simulations(const std::function<double(int)>& step_of) noexcept;
  /// Makes the simulation of a world ready to go on from the state of the batch.
  void prepare_simulation(int world, batch::SimulatedWorld::Use use);
  Event apply_in_simulation(int world, std::span<const Action> actions, std::string name);
  /// The batch changed the state or topology of a world, or its extra efforts.
  void changed(int world) {
    if (basis.one_by_one) simulated[static_cast<std::size_t>(world)]->changed();
  }
  void efforts_changed(int world) {
    if (basis.one_by_one) simulated[static_cast<std::size_t>(world)]->set_efforts(efforts[static_cast<std::size_t>(world)]);
  }

 private:
  Variables variables_of(const Tree& tree) const { return tree.has_loops() ? basis.loop_variables : basis.variables; }
  // Ensures scratch memory for trees of that size.
  void make_room(const Tree& tree) {
    if (tree.bodies() <= steppers.capacity) return;
    call.scratches.clear();
    call.scratches.resize(static_cast<std::size_t>(pool.threads()));
    steppers.make(tree, basis.variables, basis.one_by_one ? 0 : pool.threads());
  }
  std::unique_ptr<Group> new_group(Topology topology, const Tree& tree) {
    had_loops |= !tree.loops().empty();
    if (!had_loops && !basis.one_by_one) return new_group_of(std::move(topology), tree);
    Tree bare = basis.declared;  // later loop joints get numbers that do not depend on earlier ones
    if (had_loops || !batch::same(topology, basis.topology)) bare.edit().restore(topology);
    return new_group_of(std::move(topology), bare);
  }
  std::unique_ptr<Group> new_group_of(Topology topology, const Tree& tree) {
    const int worlds_at_once = lanes_of_group(tree);
    batch::PlanScalars scalars;
    if (!basis.one_by_one && !tree.has_loops())
      scalars = steppers.trees[0]->scalars();
    else if (!basis.one_by_one && variables_of(tree) == Variables::velocities)
      scalars = steppers.loop_lanes[0]->scalars();
    return std::make_unique<Group>(std::move(topology), tree, worlds_at_once, variables_of(tree), scalars);
  }
  // Worlds with loops in momenta are stepped one by one.
  int lanes_of_group(const Tree& tree) {
    if (!tree.has_loops() || basis.one_by_one) return steppers.lanes;
    return variables_of(tree) == Variables::momenta ? 1 : steppers.lanes_with_loops(tree, pool.threads());
  }
  // Memory of all threads, so that steps allocate nothing.
  void prepare_loops(const Tree& tree) {
    const bool grows = steppers.prepare_loops(tree, variables_of(tree), pool.threads());
    for (auto group = groups.begin(); grows && group != groups.end(); ++group)
      if (group->second->tree().has_loops()) steppers.fit_loops(group->second->tree(), group->second->variables());
  }
  void step_simulation(int world, double h) noexcept;
  /// Copies what its simulation did to the group; notes whether it belongs to another one now, and if so, moves it there.
  void copy_to_group(int world);
  void change_group(int world);
};

}  // namespace momentree
