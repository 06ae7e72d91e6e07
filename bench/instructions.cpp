// Runs one kernel a given number of times, and nothing else that depends on that number: for valgrind, which counts instructions
// (bench/record). Call it as `momentree-instructions KERNEL MODEL BODIES COUNT`.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <momentree/batch/stepper.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/change.hpp>
#include <string>
#include <vector>

#include "models.hpp"

namespace momentree::bench {
namespace {

struct Named {
  const char* name;
  Model (*make)(int);
};
constexpr Named models[] = {{"planar_chain", planar_chain},
                            {"spatial_chain", spatial_chain},
                            {"bushy_tree", bushy_tree},
                            {"binary_tree", binary_tree},
                            {"humanoid", humanoid}};

struct World {
  Tree tree;
  State state;
  Workspace<double> workspace;
  explicit World(const Model& model) : tree(compile(model)), state(start_state(model, tree)), workspace(tree) {}
};

void evaluate(World& w, long count) {
  for (long i = 0; i < count; ++i) evaluate_rates(w.tree, w.state.q().data(), w.state.p().data(), w.workspace);
}
void accelerate(World& w, long count) {
  for (long i = 0; i < count; ++i) {
    static_cast<void>(w.state.edit());  // clears cached results
    momentree::accelerate(w.tree, w.state, w.workspace);
  }
}
/// The world, newly built and evaluated, as before each change.
template <class Change>
void anew(World& w, long count, const Change& change) {
  const Tree tree = w.tree;
  const State state = w.state;
  for (long i = 0; i < count; ++i) {
    w.tree = tree;
    w.state = state;
    forward_dynamics(w.tree, w.state, w.workspace);
    change(w);
  }
}
void lanes(const World& w, long count, Precision precision) {
  const auto stepper = batch::make_stepper(Isa::avx2, precision, w.tree);
  const auto spread = [&](std::span<const double> of_one) {
    std::vector<double> all;
    for (const double x : of_one) all.insert(all.end(), static_cast<std::size_t>(stepper->lanes()), x);
    return all;
  };
  const auto q = spread(w.state.q()), p = spread(w.state.p());
  auto qdot = q, pdot = p, v = p;
  for (long i = 0; i < count; ++i) stepper->rates(w.tree, q.data(), p.data(), qdot.data(), pdot.data(), v.data());
}

/// At two fifths of the chain.
BodyId middle(const World& w) { return {w.tree.bodies() * 2 / 5}; }

struct Kernel {
  const char* name;
  std::function<void(World&, long)> repeat;
};
const Kernel kernels[] = {
    {"evaluate", evaluate},
    {"accelerate", accelerate},
    {"anew", [](World& w, long count) { anew(w, count, [](World&) {}); }},
    {"anew_and_break",
     [](World& w, long count) {
       anew(w, count, [](World& x) { apply(Break{x.tree.inboard_joint(middle(x))}, x.tree, x.state, x.workspace); });
     }},
    {"anew_and_lock",
     [](World& w, long count) {
       anew(w, count, [](World& x) { apply(Lock{x.tree.inboard_joint(middle(x))}, x.tree, x.state, x.workspace); });
     }},
    {"lanes_double", [](World& w, long count) { lanes(w, count, Precision::float64); }},
    {"lanes_float", [](World& w, long count) { lanes(w, count, Precision::float32); }},
};

template <class Entry, std::size_t n>
const Entry& named(const Entry (&entries)[n], const char* name) {
  for (const Entry& entry : entries)
    if (std::strcmp(entry.name, name) == 0) return entry;
  std::fprintf(stderr, "no such thing: %s; there are:", name);
  for (const Entry& entry : entries) std::fprintf(stderr, " %s", entry.name);
  std::fputc('\n', stderr);
  std::exit(2);
}

}  // namespace
}  // namespace momentree::bench

int main(int arguments, char** words) {
  using namespace momentree::bench;
  if (arguments != 5) return std::fprintf(stderr, "usage: %s KERNEL MODEL BODIES COUNT\n", words[0]), 2;
  const Kernel& kernel = named(kernels, words[1]);
  World world(named(models, words[2]).make(std::atoi(words[3])));
  kernel.repeat(world, std::atol(words[4]));
  return 0;
}
