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

template <PlacementShape S, bool Gravity>
long step_operations() {
  const LinkConstants link;
  const Counted c(1), s(0), p(0);
  Inboard<Counted> in{};
  RevoluteRecord<Counted> record{};
  Outboard<Counted> out{};
  Counted u(0), pdot(0);
  Counted::operations() = {};
  RevoluteSteps::inboard<S, Gravity, false, Children::one, false>(link, 2.0, 0.0, c, s, p, in, in, record, in);
  RevoluteSteps::outboard<S, Gravity, false>(link, c, s, record, p, false, out, u, pdot,
                                             static_cast<BodySweep<Counted>*>(nullptr));
  return Counted::operations().total();
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

TEST_CASE("Table 1: revolute joints in general position take no more than 316 n - 177 operations") {
  int tilted_links = 0;
  for (int n = 2; n <= 50; ++n) {
    CAPTURE(n);
    const Tree still = compile(general_chain(n, nothing)), falling = compile(general_chain(n, down));
    // If neighbouring axes are nearly parallel, their common normal is far away, and the link does not have the cheapest shape.
    long tilted = 0;
    for (int b = 1; b < n; ++b) tilted += still.link(b).shape == PlacementShape::tilted;
    const Operations operations = count_operations(still);
    if (tilted == 0) CHECK(operations.total() <= 316 * n - 177);
    CHECK(operations.total() == 316 * n - 354 + 41 * tilted);
    CHECK(operations.additions == 152 * n - 179 + 20 * tilted);
    CHECK(operations.divisions == n);
    CHECK(operations.sincos == n);
    CHECK(count_operations(falling).total() == 350 * n - 368 + 41 * tilted);
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
    Pose at;     ///< placement of a link of that shape after another one
    bool chain;  ///< false: occurs only after a branching body, or by chance
  };
  const double right = std::acos(0.0);
  const Budget budgets[] = {
      {PlacementShape::general, 435, 481, {}, false},
      {PlacementShape::tilted, 357, 391, {{0.1, 0.3, 0}, from_axis_angle(x_axis, 0.05)}, true},
      {PlacementShape::screw, 316, 350, link_place(0.7, 0.2, 0.3), true},
      {PlacementShape::screw_a, 288, 320, link_place(0.7, 0.2, 0), true},
      {PlacementShape::screw_d, 283, 316, link_place(0.7, 0, 0.3), true},
      {PlacementShape::right, 246, 268, link_place(right, 0.2, 0.3), true},
      {PlacementShape::right_a, 218, 238, link_place(right, 0.2, 0), true},
      {PlacementShape::right_d, 221, 242, link_place(right, 0, 0.3), true},
      {PlacementShape::right_meeting, 193, 212, link_place(right, 0, 0), true},
      {PlacementShape::parallel, 247, 269, link_place(0, 0.2, 0.3), true},
      {PlacementShape::parallel_a, 219, 239, link_place(0, 0.2, 0), true},
  };
  for (const Budget& b : budgets) {
    CAPTURE(static_cast<int>(b.shape));
    dispatch_shape(b.shape, [&](auto shape) {  // and θ0 is added to the angle
      CHECK(step_operations<shape(), false>() + 1 == b.still);
      CHECK(step_operations<shape(), true>() + 1 == b.falling);
    });
    if (!b.chain) continue;
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
    long plain, rotor, locked, reversed, reversed_locked;
  };
  const Budget budgets[] = {
      {Kind::ball, 538, 1387, 1387, 2196, 2196},
      {Kind::cylindrical, 402, 934, 934, 402, 934},
      {Kind::free, 489, 2549, 2549, 4024, 4024},
      {Kind::helical, 446, 706, 554, 446, 554},
      {Kind::planar, 572, 1372, 1372, 2035, 2035},
      {Kind::prismatic, 360, 703, 551, 360, 551},
      {Kind::revolute, 350, 403, 552, 350, 552},
      {Kind::universal, 636, 1148, 1148, 1821, 1821},
      {Kind::weld, 18, 18, 18, 18, 18},
  };
  CHECK(std::size(budgets) == all_kinds().size());
  for (const Budget& b : budgets) {
    CAPTURE(std::string(info(b.kind).name));
    CHECK(of_a_link(b.kind, Variant::plain, down) == b.plain);
    CHECK(of_a_link(b.kind, Variant::armature, down) == b.rotor);
    CHECK(of_a_link(b.kind, Variant::locked, down) == b.locked);
    CHECK(of_a_link(b.kind, Variant::reversed, down) == b.reversed);
    CHECK(of_a_link(b.kind, Variant::reversed_locked, down) == b.reversed_locked);
    if (b.kind == Kind::revolute) continue;  // only its steps omit gravity
    CHECK(of_a_link(b.kind, Variant::plain, nothing) == b.plain);
    CHECK(of_a_link(b.kind, Variant::reversed, nothing) == b.reversed);
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
    const long link = has_gravity ? 350 : 316,
               turned = has_gravity ? 481 : 435;  // the first link of every branch but the first is a general one
    // The root uses only two numbers of the branches' sum, and with gravity two of the first moment; but children other than the
    // first and the last still add up whole contributions.
    const auto sum = [&](int branches) { return branches > 2 ? 30 : has_gravity ? 4 : 2; };
    const long tip = has_gravity ? 46 : 43;  // nothing is added to its own mass, or subtracted from p; and the mass alone is
                                             // invariant under rotation
    CHECK(star(1, 4) - star(1, 3) == link);
    for (int branches = 2; branches < 5; ++branches)
      CHECK(star(branches, 4) - star(branches - 1, 4) == 3 * link + turned + sum(branches) - tip);
  }
}
