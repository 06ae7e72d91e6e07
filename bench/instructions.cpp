// Runs one kernel a given number of times, and nothing else that depends on that number: for valgrind, which counts instructions
// (bench/record). Call it as `momentree-instructions KERNEL MODEL BODIES COUNT`.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <momentree/batch/stepper.hpp>
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/integrate/integrator.hpp>
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
/// All kinds of joint, one after the other, on a free body.
Model every_kind(int bodies) {
  Model model;
  BodySpec spec = spatial_chain(1).bodies()[0];
  for (int b = 0; b < bodies; ++b) {
    spec.name = "b/" + std::to_string(b);
    spec.joint_name.clear();
    spec.joint = {};
    const KindInfo& kind = all_kinds()[static_cast<std::size_t>(b) % all_kinds().size()];
    spec.joint.kind = b == 0 ? Kind::free : kind.kind;
    spec.joint.axis = {0.6, 0, 0.8}, spec.joint.pitch = kind.pitch ? 0.1 : 0.0;
    if (kind.axis2) spec.joint.axis2 = {0, 1, 0};
    spec.q = spec.v = {};
    for (int i = 0; i < info(spec.joint.kind).nv; ++i) spec.v.push_back(0.1 * (i + 1));
    spec.parent = model.size() == 0 ? ground : BodyId{model.size() - 1};
    spec.at = {{0.1, 0.2, 0.3}, normalized(Quat{0.9, 0.2, 0.1, 0.3})};
    model.add(spec);
  }
  return model;
}
constexpr Named models[] = {{"planar_chain", planar_chain},
                            {"floating_chain", floating_chain},
                            {"twisted_chain", twisted_chain},
                            {"arm", arm},
                            {"every_kind", every_kind},
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
void evaluate_velocities(World& w, long count) {
  std::vector<double> u(static_cast<std::size_t>(w.tree.nv()));
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = 0.1 + 0.01 * static_cast<double>(i % 7);
  for (long i = 0; i < count; ++i) evaluate_velocity_stage(w.tree, 0, w.state.q().data(), u.data(), w.workspace);
}
/// Steps of RK4, each from the evaluated start. Reads the clock, which valgrind counts, too.
void step(World& w, long count, Variables variables) {
  std::vector<double> y(static_cast<std::size_t>(w.tree.nv()), 0.1);
  const State start = w.state;
  State state(w.tree, variables);
  state.assign(0, start.q(), y, w.tree);
  const auto method = make_integrator("rk4", w.tree, {.step = 1e-4});
  Evaluator evaluate(w.tree, w.workspace);
  EnergyLedger ledger;
  for (long i = 0; i < count; ++i) {
    evaluate(state);
    method->step(evaluate, state, ledger, 1e-4);
  }
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
  const batch::TopologyPlan plan(w.tree, stepper->scalars());
  for (long i = 0; i < count; ++i) stepper->rates(w.tree, plan, q.data(), p.data(), qdot.data(), pdot.data(), v.data());
}

/// At two fifths of the chain.
BodyId middle(const World& w) { return {w.tree.bodies() * 2 / 5}; }

struct Kernel {
  const char* name;
  std::function<void(World&, long)> repeat;
};
const Kernel kernels[] = {
    {"evaluate", evaluate},
    {"evaluate_velocities", evaluate_velocities},
    {"step", [](World& w, long count) { step(w, count, Variables::momenta); }},
    {"step_velocities", [](World& w, long count) { step(w, count, Variables::velocities); }},
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
