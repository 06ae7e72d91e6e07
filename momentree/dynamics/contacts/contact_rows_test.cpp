// The mobility of contacts, against closed forms, and that it is found island by island.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/joint/kinds.hpp>

using namespace momentree;

namespace {

constexpr double mass = 2, radius = 0.1, inertia = 0.008;

// Spheres on the floor.
struct Spheres {
  Model model;
  std::vector<Contact> contacts;
  explicit Spheres(int count) {
    for (int i = 0; i < count; ++i)
      model.add({.name = "s" + std::to_string(i),
                 .mass = mass,
                 .inertia = diagonal(inertia),
                 .joint = Free{},
                 .q = {i * 1.0, 0, radius, 1, 0, 0, 0}});
    for (int i = 0; i < count; ++i) {
      Contact c;
      c.features = {.pair = contact::FeaturePair::point_plane, .line_b = {0, 0, 1}, .radius_a = radius};
      c.a = i, c.pair = i;
      contacts.push_back(c);
    }
  }
  // Sphere `one` touches `other` as well.
  void touch(int one, int other) {
    Contact c;
    c.features = {.pair = contact::FeaturePair::point_point, .radius_a = radius, .radius_b = radius};
    c.a = one, c.b = other, c.pair = 1000 + one;
    contacts.push_back(c);
  }
  ContactRows rows() const {
    const Tree tree = compile(model);
    const State state = start_state(model, tree);
    Workspace<double> workspace(tree);
    forward_dynamics(tree, state, workspace);
    locate_bodies(tree, state, workspace);
    ContactRows rows;
    place_contacts(tree, workspace, contacts, rows);
    find_contact_mobility(tree, state.q().data(), workspace, contacts, rows);
    return rows;
  }
};

}  // namespace

TEST_CASE("contact rows: spheres that touch only the floor move alone, and memory is proportional to their number") {
  constexpr std::size_t count = 40;
  const ContactRows rows = Spheres(count).rows();
  REQUIRE(rows.contacts() == count);
  const double along_normal = 1 / mass, along_tangent = 1 / mass + radius * radius / inertia;
  for (std::size_t i = 0; i < 3 * count; ++i)
    for (std::size_t j = 0; j < 3 * count; ++j) {
      const double expected = i != j ? 0 : i % 3 == 0 ? along_normal : along_tangent;
      CHECK(std::fabs(rows.mobility(i, j) - expected) < 1e-14);
    }
  CHECK(rows.J.size() == 3 * 6 * count);
  CHECK(rows.Y.size() == 3 * 6 * count);
  CHECK(rows.A.size() == 9 * count);
  CHECK(rows.islands().size() == count);
}

TEST_CASE("contact rows: contacts of bodies that touch each other move each other") {
  Spheres spheres(5);
  spheres.touch(3, 1);
  const ContactRows rows = spheres.rows();
  REQUIRE(rows.groups.size() == 4);
  CHECK(rows.islands() == std::vector<std::vector<std::size_t>>{{0}, {1, 3, 5}, {2}, {4}});
  // The common contact is along x: both masses count, and a tangential impulse of the floor moves the spheres along it.
  CHECK(std::fabs(rows.mobility(15, 15) - 2 / mass) < 1e-14);
  const auto coupling = [&](std::size_t contact) {
    return std::hypot(rows.mobility(15, 3 * contact + 1), rows.mobility(15, 3 * contact + 2));
  };
  CHECK(std::fabs(coupling(1) - 1 / mass) < 1e-14);
  CHECK(std::fabs(coupling(3) - 1 / mass) < 1e-14);
  CHECK(coupling(0) == 0);
  CHECK(rows.matrix()[18 * 15 + 15] == rows.mobility(15, 15));
  const ContactRows some = rows.some({5, 0});
  CHECK(some.mobility(0, 0) == rows.mobility(15, 15));
  CHECK(some.mobility(3, 3) == rows.mobility(0, 0));
  CHECK(some.mobility(0, 3) == 0);
}
