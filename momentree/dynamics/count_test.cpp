// Operation budgets: the cost of an evaluation by the kernels themselves. The figures are exact, so that any change of a kernel
// shows its cost or saving here.
#include <momentree/dynamics/count.hpp>

#include <cmath>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/topology/change.hpp>

using namespace momentree;

namespace {

constexpr Vec3 down{0.3, -0.2, -9.81}, nothing{};

long operations(const Model& model) { return count_operations(compile(model)).total(); }

BodySpec body(int k, BodyId parent, const Pose& at, const JointSpec& joint) {
  return {.name = "b/" + std::to_string(k),
          .mass = 1.25,
          .com = {0.1, -0.05, 0.2},
          .inertia = {0.05, 0.06, 0.07, 0.004, -0.003, 0.002},
          .parent = parent,
          .at = at,
          .joint = joint};
}

Pose general_place(std::mt19937& random) {
  const auto draw = [&random] { return -1 + 2e-9 * static_cast<double>(random() % 1000000001u); };
  Pose at;
  at.position.x = draw(), at.position.y = draw(), at.position.z = draw();
  at.rotation.x = draw(), at.rotation.y = draw(), at.rotation.z = draw(), at.rotation.w = 1 + draw() * draw();
  at.rotation = normalized(at.rotation);
  return at;
}

/// Revolute joints in general position.
Model general_chain(int bodies, const Vec3& gravity) {
  std::mt19937 random(static_cast<unsigned>(bodies));
  Model model({.gravity = gravity});
  BodyId last = ground;
  for (int k = 0; k < bodies; ++k) last = model.add(body(k, last, general_place(random), Revolute{}));
  return model;
}

/// Twist about x (rad) and lengths (m) of a link (Denavit and Hartenberg).
Pose link_place(double alpha, double a, double d) {
  return {{a, -d * std::sin(alpha), d * std::cos(alpha)}, from_axis_angle(x_axis, alpha)};
}
/// Two revolute joints that prevent a plane mechanism, and `links` links of one shape.
Model shaped_chain(int links, const Pose& at, const Vec3& gravity) {
  Model model({.gravity = gravity});
  BodyId last = model.add(body(0, ground, {}, Revolute{}));
  last = model.add(body(1, last, link_place(0.7, 0.2, 0.3), Revolute{}));
  for (int k = 0; k < links; ++k) last = model.add(body(k + 2, last, at, Revolute{}));
  return model;
}

/// Operations of one more body with this kind and variant.
long of_a_link(Kind kind, Variant variant, const Vec3& gravity) {
  const bool turned = variant == Variant::reversed || variant == Variant::reversed_locked;
  const bool locked = variant == Variant::locked || variant == Variant::reversed_locked;
  const auto count = [&](int links) {
    std::mt19937 random(5);
    JointSpec joint;
    joint.kind = kind, joint.axis = {0.1, 0.2, 0.9};
    if (kind == Kind::universal) joint.axis2 = {1, 0.1, 0.3};
    if (kind == Kind::helical) joint.pitch = 0.1;
    if (variant == Variant::armature) joint.parameters.armature = 0.1;
    Model model({.gravity = gravity});
    // Welds to the ground cost nothing.
    const JointSpec base = turned ? JointSpec(Free{}) : kind == Kind::weld ? JointSpec(Revolute{}) : JointSpec(Weld{});
    BodyId last = model.add(body(0, ground, {}, base));
    for (int k = 1; k <= links; ++k) last = model.add(body(k, last, general_place(random), joint));
    Tree tree = compile(model);
    State state = start_state(model, tree);
    Workspace<double> workspace(tree);
    if (turned) {
      forward_dynamics(tree, state, workspace);
      apply(Reroot{last}, tree, state, workspace);
    }
    for (int b = 0; locked && b < tree.bodies(); ++b) {
      if (tree.kind(b) != kind || tree.parent(b) < 0) continue;
      forward_dynamics(tree, state, workspace);
      apply(Lock{tree.inboard_joint({b})}, tree, state, workspace);
    }
    return count_operations(tree).total();
  };
  const long step = count(6) - count(5);
  CHECK(step == count(9) - count(8));
  return step;
}

}  // namespace

TEST_CASE("Table 1: revolute joints in general position take 315 n - 434 operations") {
  int tilted_links = 0;
  for (int n = 2; n <= 50; ++n) {
    CAPTURE(n);
    const Tree still = compile(general_chain(n, nothing)), falling = compile(general_chain(n, down));
    // If neighbouring axes are nearly parallel, their common normal is far away, and the link does not have the cheapest shape.
    long tilted = 0;
    for (int b = 1; b < n; ++b) tilted += still.link(b).shape == PlacementShape::tilted;
    const Operations operations = count_operations(still);
    CHECK(operations.total() == 315 * n - 434 + 37 * tilted);
    CHECK(operations.additions == 155 * n - 224 + 20 * tilted);
    CHECK(operations.divisions == n - 1);  // the inertia of a leaf about its axis is constant
    CHECK(operations.sincos == n);
    CHECK(count_operations(falling).total() == 350 * n - 465 + 39 * tilted);
    tilted_links += static_cast<int>(tilted);
  }
  CHECK(tilted_links < 20);  // of 1274
}

TEST_CASE("an addition or a multiplication by a constant counts, a change of sign does not") {
  Counted::operations() = {};
  Counted x(2), s(0), c(0);
  x = -x * 3.0 + (Counted(1) - x) / 4.0;
  x += 1;
  sincos(x, s, c);
  CHECK(Counted::operations().additions == 3);
  CHECK(Counted::operations().multiplications == 1);
  CHECK(Counted::operations().divisions == 1);
  CHECK(Counted::operations().sincos == 1);
  CHECK(x.value() == doctest::Approx(-6 - 0.25 + 1));
}

TEST_CASE("operation counts by the shape of a link") {
  struct Budget {
    PlacementShape shape;
    long still, falling;
    Pose at;  ///< placement of a link of that shape after another one
  };
  const double right = std::acos(0.0);
  const Budget budgets[] = {
      {PlacementShape::tilted, 319, 354, {{0.1, 0.3, 0}, from_axis_angle(x_axis, 0.05)}},
      {PlacementShape::screw, 315, 350, link_place(0.7, 0.2, 0.3)},
      {PlacementShape::screw_a, 286, 319, link_place(0.7, 0.2, 0)},
      {PlacementShape::screw_d, 282, 315, link_place(0.7, 0, 0.3)},
      {PlacementShape::right, 249, 272, link_place(right, 0.2, 0.3)},
      {PlacementShape::right_a, 220, 241, link_place(right, 0.2, 0)},
      {PlacementShape::right_d, 225, 246, link_place(right, 0, 0.3)},
      {PlacementShape::right_meeting, 196, 215, link_place(right, 0, 0)},
      {PlacementShape::parallel, 248, 271, link_place(0, 0.2, 0.3)},
      {PlacementShape::parallel_a, 219, 240, link_place(0, 0.2, 0)},
  };
  for (const Budget& b : budgets) {
    CAPTURE(static_cast<int>(b.shape));
    const Tree tree = compile(shaped_chain(5, b.at, down));
    for (int k = 3; k + 1 < tree.bodies(); ++k) CHECK(tree.link(k).shape == b.shape);
    CHECK(operations(shaped_chain(9, b.at, nothing)) - operations(shaped_chain(8, b.at, nothing)) == b.still);
    CHECK(operations(shaped_chain(9, b.at, down)) - operations(shaped_chain(8, b.at, down)) == b.falling);
  }
}

TEST_CASE("operation counts of planar mechanisms") {
  const auto chain = [](int links, const Vec3& gravity) {
    Model model({.gravity = gravity});
    BodyId last = ground;
    for (int k = 0; k < links; ++k) last = model.add(body(k, last, link_place(0, 0.2, 0.1), Revolute{}));
    return operations(model);
  };
  for (int n = 2; n <= 50; n += 6) {
    CAPTURE(n);
    CHECK(chain(n, nothing) == 67 * n - 24);
    CHECK(chain(n, down) == 77 * n - 28);
  }
}

TEST_CASE("operation counts by the kind of a joint: plain, with armature, locked, reversed") {
  struct Budget {
    Kind kind;
    long plain, rotor, locked, reversed, reversed_locked, still;  ///< `still`: plain, without gravity
  };
  const Budget budgets[] = {
      {Kind::ball, 541, 1387, 1387, 2196, 2196, 490},
      {Kind::cylindrical, 403, 934, 934, 403, 934, 364},
      {Kind::free, 489, 2549, 2549, 4024, 4024, 432},
      {Kind::helical, 447, 706, 554, 447, 554, 408},
      {Kind::planar, 572, 1372, 1372, 2035, 2035, 513},
      {Kind::prismatic, 361, 407, 551, 361, 551, 326},
      {Kind::revolute, 350, 404, 552, 350, 552, 315},
      {Kind::universal, 639, 1148, 1148, 1821, 1821, 580},
      {Kind::weld, 0, 0, 0, 0, 0, 0},
  };
  CHECK(std::size(budgets) == all_kinds().size());
  for (const Budget& b : budgets) {
    CAPTURE(std::string(info(b.kind).name));
    CHECK(of_a_link(b.kind, Variant::plain, down) == b.plain);
    CHECK(of_a_link(b.kind, Variant::armature, down) == b.rotor);
    CHECK(of_a_link(b.kind, Variant::locked, down) == b.locked);
    CHECK(of_a_link(b.kind, Variant::reversed, down) == b.reversed);
    CHECK(of_a_link(b.kind, Variant::reversed_locked, down) == b.reversed_locked);
    CHECK(of_a_link(b.kind, Variant::plain, nothing) == b.still);
  }
}

TEST_CASE("counts of mechanisms add up; a branch costs its own count and the sum at the branching body") {
  for (const Vec3& gravity : {nothing, down}) {
    CAPTURE(gravity.z);
    Model both = general_chain(7, gravity);
    const Model other = shaped_chain(4, link_place(0.7, 0, 0.3), gravity);
    for (int k = 0; k < other.size(); ++k) {
      BodySpec spec = other[{k}];
      spec.name = "c/" + std::to_string(k), spec.joint_name.clear();
      spec.parent = k == 0 ? ground : BodyId{spec.parent.index + 7};
      both.add(spec);
    }
    CHECK(operations(both) == operations(general_chain(7, gravity)) + operations(other));

    // A trunk with isomorphic branches, in general position.
    const auto star = [&](int branches, int links) {
      Model model({.gravity = gravity});
      const BodyId trunk = model.add(body(0, ground, {}, Revolute{}));
      for (int branch = 0, k = 1; branch < branches; ++branch) {
        BodyId last = trunk;
        const Pose first{{0.3, 0.1 + 0.1 * branch, -0.2}, normalized(Quat{0.9, 0.2 * branch, 0.4, 0.1})};
        for (int i = 0; i < links; ++i) last = model.add(body(k++, last, i == 0 ? first : link_place(0.7, 0.2, 0.3), Revolute{}));
      }
      return operations(model);
    };
    const bool has_gravity = gravity.z != 0;
    CHECK(star(1, 4) - star(1, 3) == (has_gravity ? 350 : 315));
    // Three links, the first one of the branch, which is a general one, and the sum at the trunk.
    for (int branches = 2; branches < 6; ++branches)
      CHECK(star(branches, 4) - star(branches - 1, 4) == (has_gravity ? 1415 : 1278));
  }
}
