// The implementations of one evaluation against each other, on random trees: derived steps, as machine code and carried out
// operation by operation, and the pass over plane mechanisms (stages); the generic functions (motions); with armatures.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/counted.hpp>
#include <momentree/topology/test_support.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

extern template void evaluate_rates<Counted>(const Tree&, const Counted*, const Counted*, Workspace<Counted>&) noexcept;

namespace {

using namespace test;

JointSpec random_joint(Random& random) {
  const int draw = random.below(18);
  const bool simple = random.chance(0.5);
  if (draw == 12) return Planar{};
  if (draw == 13)
    return simple ? Universal{.axis = x_axis, .axis2 = y_axis} : Universal{.axis = {1, 0.1, 0.2}, .axis2 = {0, 1, 0}};
  if (draw == 14) return Helical{.axis = simple ? z_axis : Vec3{0.3, 0, 1}, .pitch = 0.4};
  if (draw == 15) return Cylindrical{.axis = simple ? z_axis : Vec3{0, 0.3, 1}};
  if (draw == 16) return Free{};
  if (draw == 17) return Prismatic{};
  if (draw == 0) return Prismatic{.axis = {0.2, 0.4, 1}};
  if (draw == 1) return Ball{};
  if (draw == 2) return Weld{};
  if (draw < 6) return Revolute{.axis = {0.3, 0, 1}, .armature = random.between(0.01, 0.1)};
  return Revolute{.damping = 1};  // not part of evaluate_rates, but joints with parameters can take armature
}

/// One to three mechanisms, some of them grounded and plane.
Model random_model(Random& random, bool gravity) {
  Model model({.gravity = gravity ? random.vector(10) : Vec3{}});
  const int mechanisms = 1 + random.below(3);
  for (int m = 0; m < mechanisms; ++m) {
    const bool flat = random.chance(0.3), chain = random.chance(0.5);
    const int first = model.size(), bodies = 1 + random.below(12);
    for (int k = 0; k < bodies; ++k) {
      BodySpec body{.name = "m" + std::to_string(m) + "/" + std::to_string(k), .mass = random.between(0.5, 2)};
      body.com = random.vector(0.2);
      body.inertia = diagonal(random.between(0.06, 0.1), random.between(0.06, 0.1), random.between(0.06, 0.1));
      const int outer = chain ? k - 1 : random.below(k + 1) - 1;
      body.parent = k == 0 ? ground : BodyId{first + std::max(outer, 0)};
      body.at = random_place(random);
      if (random.chance(0.3)) body.at.rotation = random.chance(0.5) ? Quat{} : from_axis_angle(z_axis, random.between(-1, 1));
      if (flat) body.at = {random.vector(0.4), k == 0 ? body.at.rotation : from_axis_angle(z_axis, random.between(-1, 1))};
      body.joint = flat                           ? JointSpec(Revolute{.damping = 1})
                   : k == 0 && random.chance(0.3) ? JointSpec(Free{})
                                                  : random_joint(random);
      model.add(body);
    }
  }
  return model;
}

/// Counts the cases that occurred, so that none passes untested.
struct Seen {
  std::array<int, 11> shapes{};
  std::array<std::array<int, 4>, 9> places{};  ///< of bodies with joints as declared, by kind
  int flat = 0, forks = 0, reversed = 0, rotors = 0;
  double worst = 0;

  void note(const Tree& tree) {
    for (const KernelRun& s : tree.tables().runs)
      for (int i = s.begin; i < s.end; ++i) {
        const int b = tree.order()[static_cast<std::size_t>(i)];
        forks += (tree.tables().node_flags[static_cast<std::size_t>(i)] & node::branching) != 0;
        reversed += tree.reversed(b);
        const auto kind = static_cast<std::size_t>(s.kind);
        const unsigned flags = tree.tables().node_flags[static_cast<std::size_t>(i)];
        if (s.variant == Variant::plain)
          ++places[kind][((flags & node::leaf) != 0 ? 1u : 0u) + ((flags & node::root) != 0 ? 2u : 0u)];
        if (s.planar)
          ++flat;
        else if (s.kind == Kind::revolute && s.variant == Variant::armature)
          ++rotors;
        else if (s.kind == Kind::revolute && s.variant == Variant::plain && tree.parent(b) >= 0)
          ++shapes[static_cast<std::size_t>(tree.link(b).shape)];
      }
  }
};

std::vector<double> values(const Counted* a, int n) {
  std::vector<double> x;
  for (int i = 0; i < n; ++i) x.push_back(a[i].value());
  return x;
}

void compare(const Tree& tree, const State& state, Seen& seen) {
  seen.note(tree);
  const auto q = state.q(), p = state.p();
  const int nq = tree.nq(), nv = tree.nv();
  Workspace<double> stage(tree), motions(tree);
  poison(tree, stage), poison(tree, motions);
  use_generic_functions(tree, motions);
  evaluate_rates(tree, q.data(), p.data(), stage);
  evaluate_motions(tree, q.data(), p.data(), motions);
  Workspace<Counted> early(tree);
  early.table(Passes::stage_momenta) = detail::make_step_table(detail::counting_scalar());
  const std::vector<Counted> cq(q.begin(), q.end()), cp(p.begin(), p.end());
  evaluate_rates(tree, cq.data(), cp.data(), early);
  Tree with_rotors, in_pieces = tree;
  with_rotors.edit().copy_with_armatures(tree), in_pieces.edit().use_generic_kernels();
  Workspace<double> rotors(with_rotors), pieces(in_pieces);
  poison(with_rotors, rotors), poison(in_pieces, pieces);
  evaluate_rates(with_rotors, q.data(), p.data(), rotors);
  evaluate_rates(in_pieces, q.data(), p.data(), pieces);
  const auto near = [&](const double* a, const double* b, int n) {
    const double x = difference(a, b, n);
    seen.worst = std::max(seen.worst, x);
    return x < 5e-12;  // the worst is 3e-13
  };
  CHECK(near(stage.v.get(), motions.v.get(), nv));
  CHECK(near(stage.qdot.get(), motions.qdot.get(), nq));
  CHECK(near(stage.pdot.get(), motions.pdot.get(), nv));
  CHECK(near(pieces.v.get(), motions.v.get(), nv));
  CHECK(near(pieces.qdot.get(), motions.qdot.get(), nq));
  CHECK(near(pieces.pdot.get(), motions.pdot.get(), nv));
  CHECK(near(rotors.v.get(), motions.v.get(), nv));
  CHECK(near(rotors.qdot.get(), motions.qdot.get(), nq));
  CHECK(near(rotors.pdot.get(), motions.pdot.get(), nv));
  CHECK(near(values(early.v.get(), nv).data(), motions.v.get(), nv));
  CHECK(near(values(early.qdot.get(), nq).data(), motions.qdot.get(), nq));
  CHECK(near(values(early.pdot.get(), nv).data(), motions.pdot.get(), nv));
}

}  // namespace

TEST_CASE("derived steps, planar kernels and generic functions give the same rates, whatever changes") {
  Seen seen;
  for (unsigned seed = 0; seed < 500; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Model model = random_model(random, seed % 3 != 0);
    Tree tree = compile(model);
    State state = start_state(model, tree);
    Workspace<double> workspace(tree);
    for (int change = 0; change < 4; ++change) {
      CAPTURE(change);
      for (int again = 0; again < 2; ++again) {
        put_at_random(tree, state, random);
        compare(tree, state, seen);
      }
      change_at_random(tree, state, workspace, random, 0.5);
    }
  }
  CHECK(seen.worst < 5e-12);
  for (std::size_t i = 0; i < seen.shapes.size(); ++i) CHECK_MESSAGE(seen.shapes[i] > 20, "shape ", i, ": ", seen.shapes[i]);
  for (const KindInfo& kind : all_kinds())
    dispatch(kind.kind, [&](auto tag) {
      if constexpr (decltype(tag)::type::info.nv > 0) {
        CAPTURE(std::string(kind.name));
        for (const int n : seen.places[static_cast<std::size_t>(kind.kind)]) CHECK(n > 3);
      }
    });
  CHECK(seen.rotors > 1000);
  CHECK(seen.flat > 100);
  CHECK(seen.forks > 100);
  CHECK(seen.reversed > 100);
}

}  // namespace momentree
