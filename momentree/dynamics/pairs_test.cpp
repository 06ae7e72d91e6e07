// Pairs of isomorphic branches, processed two at once, against the same bodies processed one by one: on random mechanisms with
// limbs on a trunk, before and after changes that separate the pairs.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/topology/test_support.hpp>

namespace momentree {

namespace {

using namespace test;

/// One body of a limb.
struct Piece {
  int parent = -1;  // among the limb's bodies; −1: attached to the trunk
  bool weld = false, rotor = false;
};
std::vector<Piece> random_limb(Random& random) {
  std::vector<Piece> limb;
  const int bodies = 1 + random.below(9);
  const bool chain = random.chance(0.5);
  const double rotors = random.chance(0.5) ? random.between(0.3, 1) : 0;
  for (int k = 0; k < bodies; ++k) {
    const int parent = k == 0 ? -1 : chain ? k - 1 : random.below(k);
    limb.push_back({parent, random.chance(k == 0 ? 0.05 : 0.15), random.chance(rotors)});
  }
  return limb;
}
/// Placements and masses are random for each body, so those of paired limbs differ.
void add_limb(Model& model, const std::vector<Piece>& limb, BodyId at, Random& random) {
  const int first = model.size();
  for (const Piece& piece : limb) {
    BodySpec body{.name = std::to_string(model.size()), .mass = random.between(0.5, 2)};
    body.com = random.vector(0.2);
    body.inertia = diagonal(random.between(0.06, 0.1), random.between(0.06, 0.1), random.between(0.06, 0.1));
    body.parent = piece.parent < 0 ? at : BodyId{first + piece.parent};
    body.at = random_place(random);
    body.joint = Revolute{.damping = 1};
    if (piece.rotor) body.joint = Revolute{.damping = 1, .armature = random.between(0.01, 0.1)};
    if (piece.weld) body.joint = Weld{};
    model.add(body);
  }
}
/// A trunk with limbs of few kinds, some of them isomorphic, or mechanisms that are isomorphic as a whole.
Model random_model(Random& random, bool gravity) {
  Model model({.gravity = gravity ? random.vector(10) : Vec3{}});
  const std::vector<Piece> sorts[] = {random_limb(random), random_limb(random)};
  const bool whole = random.chance(0.2);
  const int trunk = whole ? 0 : 1 + random.below(3);
  for (int k = 0; k < trunk; ++k) {
    BodySpec body{.name = "trunk" + std::to_string(k), .mass = 2, .com = random.vector(0.1), .inertia = diagonal(0.2)};
    body.parent = k == 0 ? ground : BodyId{k - 1};
    body.at = random_place(random);
    body.joint = k == 0 && random.chance(0.6) ? JointSpec(Free{}) : JointSpec(Revolute{.damping = 1});
    model.add(body);
  }
  const int limbs = 2 + random.below(5);
  for (int k = 0; k < limbs; ++k) add_limb(model, sorts[random.below(2)], whole ? ground : BodyId{random.below(trunk)}, random);
  return model;
}

/// Counts the cases that occurred, so that none passes untested.
struct Seen {
  int pairs = 0, apart = 0, mechanisms = 0, forks = 0, welds = 0, rotors = 0, mixed = 0, single = 0;

  void note(const Tree& tree) {
    for (const KernelRun& s : tree.paired_runs()) {
      if (s.pair < 0) single += s.end - s.begin;
      if (s.pair <= s.begin) continue;
      pairs += s.branch;
      welds += s.kind == Kind::weld;
      rotors += s.variant == Variant::armature;
      const int first = tree.order()[static_cast<std::size_t>(s.begin)], other = tree.order()[static_cast<std::size_t>(s.pair)];
      mechanisms += s.branch && tree.parent(first) < 0;
      apart +=
          s.branch && tree.parent(first) >= 0 && (tree.first_child(tree.parent(first)) != first || tree.next_sibling(other) >= 0);
      for (int i = 0; i < s.end - s.begin; ++i) {
        forks += (tree.node_flags()[static_cast<std::size_t>(s.begin + i)] & node::branching) != 0;
        mixed += tree.link(tree.order()[static_cast<std::size_t>(s.begin + i)]).shape !=
                 tree.link(tree.order()[static_cast<std::size_t>(s.pair + i)]).shape;
      }
    }
  }
};

// In the user's frame of the body: the kernel frame of a floating body depends on its kernels.
std::vector<double> numbers(const KernelFrame& frame, const Motion<double>& a) {
  const Vec3 w = frame.R * a.w, v = frame.R * a.v + cross(frame.r, w);
  return {v.x, v.y, v.z, w.x, w.y, w.z};
}
std::vector<double> numbers(const KernelFrame& frame, const Force<double>& a) {
  const Force<double> f = to_user_frame(frame, a);
  return {f.l.x, f.l.y, f.l.z, f.h.x, f.h.y, f.h.z};
}

/// All body quantities of an accelerated workspace.
std::vector<double> of_bodies(const Tree& tree, const Workspace<double>& workspace) {
  std::vector<double> all;
  const auto add = [&](const std::vector<double>& some) { all.insert(all.end(), some.begin(), some.end()); };
  for (const int b : tree.order()) {
    const auto body = static_cast<std::size_t>(b);
    const KernelFrame& frame = tree.frame(b);
    add(numbers(frame, workspace.motions[body].velocity)), add(numbers(frame, workspace.motions[body].articulated));
    add(numbers(frame, workspace.inboard_accelerations[body])), add(numbers(frame, workspace.reduced_bias_wrenches[body]));
  }
  return all;
}

void compare(const Tree& tree, const State& state, Seen& seen) {
  seen.note(tree);
  const auto nv = tree.nv(), nq = tree.nq();
  Workspace<double> stage(tree), pairs(tree);
  poison(tree, stage), poison(tree, pairs);
  evaluate_rates(tree, state.q().data(), state.p().data(), stage);
  accelerate(tree, state, pairs);
  Tree in_pieces = tree;
  TestAccess::use_generic_kernels(in_pieces);  // which are not paired
  for (const KernelRun& s : in_pieces.paired_runs()) CHECK((s.pair < 0 || s.kind == Kind::weld));
  Workspace<double> generic(in_pieces);
  State of_pieces;
  of_pieces.assign(state.time(), state.q(), state.p(), in_pieces);
  accelerate(in_pieces, of_pieces, generic);
  const auto near = [](const double* a, const double* b, int n) { return difference(a, b, n) < 1e-12; };  // the worst is 4e-14
  CHECK(near(stage.v.get(), generic.v.get(), nv));
  CHECK(near(stage.qdot.get(), generic.qdot.get(), nq));
  CHECK(near(pairs.v.get(), generic.v.get(), nv));
  CHECK(near(pairs.qdot.get(), generic.qdot.get(), nq));
  CHECK(near(pairs.pdot.get(), generic.pdot.get(), nv));
  CHECK(near(pairs.a.get(), generic.a.get(), nv));
  const std::vector<double> a = of_bodies(tree, pairs), b = of_bodies(in_pieces, generic);
  CHECK(near(a.data(), b.data(), static_cast<int>(a.size())));
  add_joint_forces(tree, state.time(), state.q().data(), stage);  // as in `pairs`
  CHECK(near(stage.pdot.get(), pairs.pdot.get(), nv));
}

}  // namespace

TEST_CASE("paired branches move as they do one by one, whatever changes") {
  Seen seen;
  for (unsigned seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Model model = random_model(random, seed % 3 != 0);
    Tree tree = compile(model);
    State state = start_state(model, tree);
    Workspace<double> workspace(tree);
    for (int change = 0; change < 4; ++change) {
      CAPTURE(change);
      put_at_random(tree, state, random);
      compare(tree, state, seen);
      change_at_random(tree, state, workspace, random, 0.4);
    }
  }
  CHECK(seen.pairs > 500);
  CHECK(seen.apart > 100);
  CHECK(seen.mechanisms > 50);
  CHECK(seen.forks > 200);
  CHECK(seen.welds > 100);
  CHECK(seen.rotors > 100);
  CHECK(seen.mixed > 500);
  CHECK(seen.single > 1000);
}

}  // namespace momentree
