// Height fields of the ground: where solids begin to touch them, and how they move on them.
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/contact/shapes/height_field.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;
using contact::HeightField;
using contact::Solid;

namespace {

double uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}
Pose any_pose(std::mt19937_64& random, double most) {
  const auto r = [&] { return uniform(random, -1, 1); };
  return {{most * r(), most * r(), most * r()}, normalized(Quat{r(), r(), r(), r() + 1e-3})};
}

// A pyramid with seven corners, without symmetry.
Solid mesh(double size) {
  const Vec3 corners[] = {{-0.6, -0.5, -0.3}, {0.7, -0.4, -0.3}, {0.6, 0.5, -0.2}, {-0.5, 0.6, -0.3},
                          {0.1, 0.2, 0.7},    {0.3, -0.2, 0.4},  {-0.3, 0.1, 0.35}};
  std::vector<Vec3> points;
  for (const Vec3& corner : corners) points.push_back(size * corner);
  return contact::hull(points);
}
std::vector<Solid> solids(double size) {
  return {contact::sphere(0.4 * size),
          contact::capsule(0.2 * size, 0.7 * size),
          contact::box({size, 0.7 * size, 0.4 * size}),
          mesh(size),
          contact::cylinder(0.35 * size, 0.6 * size),
          contact::ellipsoid({0.5 * size, 0.4 * size, 0.3 * size})};
}

HeightField any_field(std::mt19937_64& random, int count, double extent, double high, const Pose& at) {
  std::vector<double> heights;
  for (int k = 0; k < count * count; ++k) heights.push_back(uniform(random, 0, high));
  return contact::height_field(extent, extent, count, count, std::move(heights), at);
}

Vec3 point_of(const HeightField& field, int i, int j) {
  return field.at * Vec3{field.x * (i / (field.columns - 1.0) - 0.5), field.y * (j / (field.rows - 1.0) - 0.5),
                         field.heights[static_cast<std::size_t>(j * field.columns + i)]};
}

// The least distance of a solid from prisms below all triangles; zero or less: it overlaps one.
double distance_from_prisms(const Solid& solid, const contact::Place& place, const HeightField& field) {
  double least = HUGE_VAL;
  const Vec3 down = field.at.position - field.at * Vec3{0, 0, field.x};
  for (int j = 0; j + 1 < field.rows; ++j)
    for (int i = 0; i + 1 < field.columns; ++i)
      for (const auto& corners :
           {std::array{point_of(field, i, j), point_of(field, i + 1, j), point_of(field, i, j + 1)},
            std::array{point_of(field, i + 1, j + 1), point_of(field, i, j + 1), point_of(field, i + 1, j)}}) {
        std::vector<Vec3> prism(corners.begin(), corners.end());
        for (const Vec3& corner : corners) prism.push_back(corner + down);
        least = std::min(least, contact::distance(solid, place, contact::hull(prism), {}).distance);
      }
  return least;
}

double least_gap(const Solid& solid, const contact::Place& place, const HeightField& field, double within) {
  std::vector<contact::Candidate> found;
  contact::face_field(solid, place, field, within, found);
  double least = within;
  for (const contact::Candidate& each : found) least = std::min(least, each.gap);
  return least;
}

struct Fall {
  Model model;
  BodyId body;
};
Fall fall(const Solid& solid, const Pose& start, const Vec3& velocity, double friction, double restitution = 0) {
  Fall made;
  const Quat& q = start.rotation;
  made.body = made.model.add({.name = "m/m",
                              .mass = 1,
                              .inertia = diagonal(0.01, 0.012, 0.014),
                              .joint = Free{},
                              .q = {start.position.x, start.position.y, start.position.z, q.w, q.x, q.y, q.z},
                              .v = {velocity.x, velocity.y, velocity.z, 0.5, 1, 0.3}});
  made.model.add_collider({.body = made.body, .solid = solid});
  made.model.add_contact_rule({.law = {.friction = friction, .static_friction = friction, .restitution = restitution}});
  return made;
}
void add_field(Model& model, HeightField field) {
  model.add_collider({.field = std::make_shared<const HeightField>(std::move(field))});
}
Vec3 place_after(const Fall& what, const std::string& method, double time) {
  Simulation sim(what.model, {.method = method});
  REQUIRE(sim.run_until(time));
  for (const Event& event : sim.events()) CHECK(event.name.find("stepping") == std::string::npos);
  return sim.world().motions()[static_cast<std::size_t>(what.body.index)].pose.position;
}

}  // namespace

TEST_CASE("height fields: a solid that begins to touch one has a gap of zero, and no gap is below it") {
  std::mt19937_64 random(7);
  int touching = 0;
  for (int sample = 0; sample < 60; ++sample) {
    const HeightField field = any_field(random, 5, 4, uniform(random, 0.05, 2), any_pose(random, 1));
    const Vec3 up = rotation_matrix(field.at.rotation) * z_axis;
    const std::vector<Solid> all = solids(uniform(random, 0.2, 2));
    for (std::size_t s = 0; s < all.size(); ++s) {
      const Pose turned = any_pose(random, 1);
      const auto at = [&](double height) {
        contact::Place place;
        place.R = rotation_matrix(turned.rotation);
        place.r = field.at * Vec3{turned.position.x, turned.position.y, 0} + height * up;
        return place;
      };
      double low = -1, high = 5;
      REQUIRE(distance_from_prisms(all[s], at(high), field) > 0);
      for (int k = 0; k < 50; ++k) {
        const double middle = 0.5 * (low + high);
        (distance_from_prisms(all[s], at(middle), field) > 1e-10 ? high : low) = middle;
      }
      CAPTURE(sample);
      CAPTURE(s);
      const double gap = least_gap(all[s], at(high), field, 0.05);
      CHECK(gap < 1e-8);
      CHECK(gap > -1e-8);
      // A little above nothing touches, a little below something does.
      CHECK(least_gap(all[s], at(high + 1e-3), field, 0.05) > 0);
      CHECK(least_gap(all[s], at(high - 1e-3), field, 0.05) < 0);
      touching += std::fabs(gap) < 1e-8;
      const double far = uniform(random, 0.1, 2);
      const double exact = distance_from_prisms(all[s], at(high + far), field);
      CHECK(contact::distance_to_field(all[s], at(high + far), field).distance == doctest::Approx(exact).epsilon(1e-7));
      CHECK(contact::clearance(field, at(high + far).r + at(0).R * all[s].centre, all[s].reach) <= exact + 1e-12);
    }
  }
  CHECK(touching == 360);
}

TEST_CASE("height fields: bodies move on a tilted flat one as on a plane, with both ways of contact") {
  const Pose tilt{{0, 0, 0}, from_axis_angle(normalized(Vec3{0.6, 0.8, 0}), 0.25)};
  const Vec3 normal = rotation_matrix(tilt.rotation) * z_axis;
  const std::vector<Solid> all = solids(0.25);
  for (const char* const method : {"rk4", "dop853", "stepping"})
    for (std::size_t s = 0; s < all.size(); ++s) {
      CAPTURE(method);
      CAPTURE(s);
      const Fall start = fall(all[s], {{0.03, 0.02, 0.4}, normalized(Quat{1, 0.2, 0.1, 0.3})}, {0.5, 0.2, 0}, 0.2, 0.3);
      Fall on_plane = start, on_field = start;
      on_plane.model.add_collider({.plane = true, .normal = normal});
      add_field(on_field.model, contact::height_field(8, 8, 41, 41, std::vector<double>(41 * 41, 0.0), tilt));
      CHECK(norm(place_after(on_plane, method, 0.4) - place_after(on_field, method, 0.4)) < 1e-8);
    }
}

TEST_CASE("height fields: a valley is two planes, and a ridge a convex solid") {
  for (const char* const method : {"dop853", "stepping"})
    for (const double sign : {1.0, -1.0}) {
      CAPTURE(method);
      CAPTURE(sign);
      const Fall start = fall(contact::sphere(0.1), {{0.3, 0, 0.8}, {}}, {-0.5, 0.6, 0}, 0.3, 0.4);
      Fall one = start, other = start;
      std::vector<double> heights;
      for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 9; ++i) heights.push_back(sign * 0.5 * std::abs(i - 4) * 0.25);
      add_field(one.model, contact::height_field(2, 4, 9, 5, std::move(heights)));
      if (sign > 0)
        for (const double side : {1.0, -1.0}) other.model.add_collider({.plane = true, .normal = {side, 0, 2}});
      else
        other.model.add_collider({.solid = contact::hull(std::vector<Vec3>{{0, -2, 0},
                                                                           {0, 2, 0},
                                                                           {1, -2, -0.5},
                                                                           {1, 2, -0.5},
                                                                           {-1, -2, -0.5},
                                                                           {-1, 2, -0.5},
                                                                           {-1, -2, -1},
                                                                           {-1, 2, -1},
                                                                           {1, -2, -1},
                                                                           {1, 2, -1}})});
      CHECK(norm(place_after(one, method, 0.8) - place_after(other, method, 0.8)) < 1e-7);
    }
}

TEST_CASE("height fields: nothing sinks into any terrain, and no energy appears, under time stepping") {
  std::mt19937_64 random(11);
  constexpr double step = 2e-3;
  double deepest = 0;
  for (int sample = 0; sample < 200; ++sample) {
    CAPTURE(sample);
    const double size = uniform(random, 0.15, 0.5);
    const std::vector<Solid> all = solids(size);
    const Pose turned = any_pose(random, 1);
    Fall what =
        fall(all[static_cast<std::size_t>(sample) % all.size()], {{turned.position.x, turned.position.y, 2}, turned.rotation},
             {uniform(random, -1, 1), uniform(random, -1, 1), 0}, uniform(random, 0, 1), uniform(random, 0, 0.5));
    const HeightField field = any_field(random, 24, 12, uniform(random, 0, 0.6), {});
    add_field(what.model, field);
    Simulation sim(what.model, {.method = "stepping", .step = step});
    double energy = HUGE_VAL;
    for (double time = 0.1; time < 2; time += 0.1) {
      REQUIRE(sim.run_until(time));
      const EnergyBalance balance = sim.energy();
      CHECK(balance.final - balance.projection < energy + 0.2 * 9.81 * step);  // of the order of a step
      energy = balance.final - balance.projection;
      const BodyMotion& motion = sim.world().motions()[static_cast<std::size_t>(what.body.index)];
      contact::Place place;
      place.R = rotation_matrix(motion.pose.rotation), place.r = motion.pose.position;
      deepest = std::max(deepest, -least_gap(what.model.colliders()[0].solid, place, field, 0.01));
    }
  }
  CHECK(deepest < 1e-3);
}
