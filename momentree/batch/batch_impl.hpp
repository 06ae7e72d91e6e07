#pragma once
// Implementation of Batch. Included only by the files of this folder.
#include <momentree/batch/batch.hpp>

#include <algorithm>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <momentree/batch/group.hpp>
#include <momentree/batch/pool.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/simulate/simulation.hpp>
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
  const Model model;
  const Tree declared;
  const std::uint64_t fingerprint = declared.topology().model;
  Isa isa;
  Precision precision;
  Variables variables;
  std::unordered_multimap<std::size_t, std::unique_ptr<Group>> groups;  // by the topology's key
  std::vector<Seat> seats;                                              // by world
  std::vector<std::vector<batch::ExtraEffort>> efforts;                 // by world
  std::vector<std::unique_ptr<batch::Stepper>> steppers;                // by thread
  std::vector<Task> tasks;                                              // of the current step
  int capacity = 0, lanes = 0;
  batch::Pool pool;
  Out out;
  bool editing = false;
  /// Names of a world that differ from the model's, as of its last action, and the number of its events.
  struct Named {
    std::vector<std::pair<int, std::string>> joints, mechanisms;
    std::vector<int> free;  // joints that breaks had made
    std::size_t events = 0;
  };
  std::unordered_map<int, Named> named;  // only worlds in which actions happened
  std::unique_ptr<Simulation> scratch;   // for actions
  bool numbered = false;                 // the groups' numbers are valid
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
  std::vector<Scratch> scratches;
  std::vector<double> converted;    // rows of the current call, in the batch's variables
  std::vector<int> rows;            // of the current call, in the order of slots
  std::vector<std::size_t> firsts;  // by task, its first place in `rows`

  Impl(const Model& the_model, const BatchOptions& options, int threads)
      : model(the_model),
        declared(model),
        isa(batch::best_isa(options.widest)),
        precision(options.precision),
        variables(options.variables),
        pool(threads) {
    out.state = State(declared, variables);
  }

  // Ensures scratch memory for trees of that size.
  void make_room(const Tree& tree) {
    if (tree.bodies() <= capacity) return;
    steppers.clear();
    scratches.clear();
    scratches.resize(static_cast<std::size_t>(pool.threads()));
    for (int i = 0; i < pool.threads(); ++i) steppers.push_back(batch::make_stepper(isa, precision, tree, variables));
    capacity = tree.bodies();
    lanes = steppers[0]->lanes();
  }

  Group& group_of(const Tree& tree) {
    Topology topology = tree.topology();
    MT_REQUIRE(topology.model == fingerprint, "after the edit, the tree still belongs to the batch's model");
    batch::simplify(topology, declared);
    const std::size_t key = batch::key_of(topology);
    const auto [begin, end] = groups.equal_range(key);
    for (auto i = begin; i != end; ++i)
      if (batch::same(i->second->topology(), topology)) return *i->second;
    make_room(tree);
    return *groups.emplace(key, std::make_unique<Group>(std::move(topology), tree, lanes, variables))->second;
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
    tasks.clear();
    for (const auto& [key, group] : groups)
      for (int i = 0; i < group->blocks(); ++i) tasks.push_back({group.get(), i});
    pool.run(static_cast<int>(tasks.size()), [this](int thread, int i) {
      const Task& task = tasks[static_cast<std::size_t>(i)];
      steppers[static_cast<std::size_t>(thread)]->step(task.group->tree(), task.group->plan(), task.group->block(task.block));
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
  /// The world's present names that differ from the model's.
  Named names_now(int world) const;
};

}  // namespace momentree
