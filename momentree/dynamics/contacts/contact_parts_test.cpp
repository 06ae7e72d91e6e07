// Impulses carried from body to body through large trees, against rows of all degrees of freedom.
#include <momentree/dynamics/contacts/contact_parts.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/dynamics/test_support.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/topology/change.hpp>

using namespace momentree;

namespace {

JointSpec random_joint(test::Random& random) {
  const Vec3 axis = normalized(random.vector(1) + Vec3{0, 0, 1.8});
  const double armature = random.chance(0.3) ? 0.02 : 0;
  switch (random.below(9)) {
    case 0: return Prismatic{.axis = axis, .armature = armature};
    case 1: return Helical{.axis = axis, .pitch = 0.3};
    case 2: return Universal{.axis = {1, 0.2, 0}, .axis2 = {0, 1, 0.5}};
    case 3: return Cylindrical{.axis = axis};
    case 4: return Planar{};
    case 5: return Ball{};
    case 6: return Weld{};
    default: return Revolute{.axis = axis, .armature = armature};
  }
}

// Two large trees, one on a free root, and two small ones.
Model random_model(test::Random& random) {
  Model model({.gravity = {}});
  int roots[4];
  for (int tree = 0; tree < 4; ++tree) {
    roots[tree] = model.size();
    const int bodies = tree < 2 ? 70 : 3;
    for (int k = 0; k < bodies; ++k) {
      const int parent = roots[tree] + std::max(0, k - 1 - random.below(3));
      const JointSpec joint = k == 0 ? JointSpec(Free{}) : random_joint(random);
      model.add({.name = "b" + std::to_string(model.size()),
                 .mass = random.between(0.5, 2),
                 .com = random.vector(0.1),
                 .inertia = diagonal(random.between(0.04, 0.06), 0.05, 0.05),
                 .parent = k == 0 ? ground : BodyId{parent},
                 .at = test::random_place(random),
                 .joint = k == 0 && tree % 2 == 0 ? JointSpec(Revolute{.axis = {0, 1, 0}}) : joint,
                 .child_at = test::random_place(random)});
    }
  }
  return model;
}

std::vector<Contact> random_contacts(test::Random& random, int bodies, int count) {
  std::vector<Contact> contacts;
  for (int i = 0; i < count; ++i) {
    Contact c;
    c.features = {.pair = contact::FeaturePair::point_point, .point_a = random.vector(0.3), .point_b = random.vector(0.3)};
    c.a = random.below(bodies), c.b = random.chance(0.3) ? -1 : random.below(bodies);
    if (c.a == c.b) c.b = -1;
    if (random.chance(0.2)) std::swap(c.a, c.b);
    c.pair = i;
    contacts.push_back(c);
  }
  return contacts;
}

}  // namespace

TEST_CASE("contact parts: what impulses do in large trees is the same as by rows of all degrees of freedom") {
  for (unsigned seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    test::Random random(seed);
    const Model model = random_model(random);
    Tree tree = compile(model);
    State state = start_state(model, tree);
    test::put_at_random(tree, state, random);
    Workspace<double> workspace(tree);
    forward_dynamics(tree, state, workspace);
    for (int b = 0; b < tree.bodies(); ++b) {
      if (info(tree.kind(b)).nv == 0 || !random.chance(0.1)) continue;
      apply(Lock{{tree.joint_of(b)}, 1}, tree, state, workspace);
      forward_dynamics(tree, state, workspace);
    }
    locate_bodies(tree, state, workspace);
    const double* const q = state.q().data();
    const std::vector<Contact> contacts = random_contacts(random, tree.bodies(), 50);
    ContactRows rows;
    place_contacts(tree, workspace, contacts, rows);
    find_contact_mobility(tree, q, workspace, contacts, rows);

    ContactParts parts;
    contact::ManyPoints many;
    parts.begin(tree, many);
    REQUIRE(many.links.all.size() == 140);
    parts.add_points(tree, q, workspace, contacts, rows, many);
    const auto nv = static_cast<std::size_t>(tree.nv());
    std::vector<double> factors(many.points.size(), 1.0), expected(nv, 0.0), packed(nv, 0.0);
    for (std::size_t row = 0; row < 3 * contacts.size(); ++row) {
      many.r.push_back(random.between(-1, 1));
      rows.add_row(rows.Y, row, many.r.back(), expected.data());
    }
    for (const int b : tree.order())  // stops of some joints
      for (int i = 0; i < info(tree.kind(b)).nv; ++i) {
        if (!random.chance(0.1) || (tree.link(b).locked >> i & 1u) != 0) continue;
        const double sign = random.chance(0.5) ? 1 : -1, impulse = random.between(0, 1);
        parts.add_stop(tree, q, workspace, b, i, sign, many);
        many.r.insert(many.r.end(), {impulse, 0.0, 0.0});
        factors.push_back(1);
        std::vector<double> unit(nv, 0.0);
        unit[static_cast<std::size_t>(tree.first_p(b) + i)] = sign;
        solve_with_factors<double>(tree, q, workspace, unit.data());
        for (std::size_t k = 0; k < nv; ++k) expected[k] += impulse * unit[k];
      }
    contact::LinksMotion& motion = many.displacement(factors);
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      double along = 0;
      std::vector<double> J(nv, 0.0);
      rows.add_row(rows.J, 3 * i, 1, J.data());
      for (std::size_t k = 0; k < nv; ++k) along += J[k] * expected[k];
      worst = std::max(worst, std::fabs(many.along_normal(i, motion) - along)), largest = std::max(largest, std::fabs(along));
      const std::array<double, 9> block = many.block(i);
      for (std::size_t k = 0; k < 9; ++k) {
        const double mobility = rows.mobility(3 * i + k / 3, 3 * i + k % 3);
        worst = std::max(worst, std::fabs(block[k] - mobility)), largest = std::max(largest, std::fabs(mobility));
      }
    }
    CHECK(worst < 1e-10 * largest);
    parts.add_to(tree, many, motion, packed.data());
    CHECK(test::difference(packed.data(), expected.data(), tree.nv()) < 1e-10);
  }
}
