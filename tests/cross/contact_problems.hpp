#pragma once
// Random mechanisms that touch the ground or each other at several points, and what the contact solvers get of them.
#include <array>
#include <utility>
#include <vector>

#include <momentree/contact/system.hpp>
#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/simulate/simulation.hpp>
#include <tests/oracle/loop_rows.hpp>

namespace momentree::peers {

/// Bodies that touch: points of body a before planes of body b, and rounded points before others.
class RandomContacts {
 public:
  RandomContacts(const World& world, oracle::Prng& random) : world_(&world), random_(&random) {}

  /// The corners of a face or the ends of an edge on a plane, a point on a plane, or two balls.
  void add(int a, int b, std::vector<Contact>& out) {
    const Vec3 middle = random_->vector(0.4);
    const Mat3 axes = rotation_matrix(random_->rotation());  // of body a; the plane's normal is the third
    const double length = random_->uniform(0.1, 0.6), width = random_->uniform(0.1, 0.6);
    const Vec3 x = 0.5 * length * (axes * Vec3{1, 0, 0}), y = 0.5 * width * (axes * Vec3{0, 1, 0}), normal = axes * Vec3{0, 0, 1};
    Contact contact;
    contact.a = a, contact.b = b;
    const int what = random_->integer(0, 3);
    if (what == 3) {
      contact.features.pair = contact::FeaturePair::point_point;
      contact.features.point_a = middle, contact.features.point_b = random_->vector(1);
      out.push_back(contact);
      return;
    }
    const Pose from_b = inverse(pose(b)) * pose(a);
    contact.features.point_b = from_b * middle;
    contact.features.line_b = rotation_matrix(from_b.rotation) * normal;
    std::vector<Vec3> points{middle};
    if (what == 0) points = {middle - x - y, middle + x - y, middle + x + y, middle - x + y};
    if (what == 1) points = {middle - x, middle + x};
    for (const Vec3& point : points) {
      contact.features.point_a = point;
      out.push_back(contact);
    }
  }

 private:
  Pose pose(int body) const { return body < 0 ? Pose{} : world_->motions()[static_cast<std::size_t>(body)].pose; }

  const World* world_;
  oracle::Prng* random_;
};

/// A problem of contact: A, b and the friction of every point.
struct ContactProblem {
  contact::System system;
  bool loops = false, locks = false, friction = false;
};

/// The rows of contacts at the present state.
inline ContactRows rows_of(const World& world, const std::vector<Contact>& contacts) {
  const Tree& tree = world.tree();
  Workspace<double> workspace(tree);
  ContactRows rows;
  accelerate(tree, world.state(), workspace);
  locate_bodies(tree, world.state(), workspace);
  place_contacts(tree, workspace, contacts, rows);
  find_contact_accelerations(tree, world.state().q().data(), workspace, contacts, rows);
  find_contact_mobility(tree, world.state().q().data(), workspace, contacts, rows);
  return rows;
}

/// Trees of three to nine bodies, half of them with loops, some joints locked, with up to 12 points. b are velocities, or
/// accelerations of a mechanism at rest. No points: nothing that touches can move.
inline ContactProblem random_problem(std::uint64_t seed) {
  oracle::Prng random(seed + 300000);
  ContactProblem problem;
  problem.loops = seed % 2 == 0, problem.locks = seed % 4 < 2, problem.friction = seed % 5 != 0;
  const bool at_rest = seed % 3 == 0;
  oracle::RandomTreeOptions options;
  options.min_bodies = 3, options.max_bodies = 9, options.conservative = true;
  Model model = problem.loops ? oracle::with_loops(seed, options) : oracle::random_tree(seed, options).model;
  Simulation sim(model, {.method = "dop853", .variables = Variables::velocities});
  if (problem.locks)
    for (int k = 0; k < 2; ++k) {
      const Action action = lock(std::string(sim.world().joint_name({random.integer(0, model.size() - 1)})));
      static_cast<void>(sim.try_apply(action));  // a weld has nothing to lock
    }
  if (at_rest) {
    const Numbers q = sim.world().state().q();
    const std::vector<double> still(static_cast<std::size_t>(sim.world().tree().nv()), 0.0);
    sim.set_state(0, std::vector<double>(q.begin(), q.end()), still, Variables::velocities);
  }
  const World& world = sim.world();
  RandomContacts bodies(world, random);
  std::vector<Contact> contacts;
  for (int k = random.integer(1, 4); k > 0; --k) {
    const int a = random.integer(0, model.size() - 1), b = random.chance(0.6) ? -1 : random.integer(0, model.size() - 1);
    if (a != b && contacts.size() <= 8) bodies.add(a, b, contacts);
  }
  const auto least_mobility = [&](const ContactRows& rows, std::size_t i) {
    double least = HUGE_VAL;
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) least = std::min(least, rows.mobility(k, k));
    return least;
  };
  // Without points of which some direction cannot move: for Siconos, the block of a point must not be singular in that way.
  const ContactRows all = rows_of(world, contacts);
  std::vector<Contact> moving;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (least_mobility(all, i) > 1e-6) moving.push_back(contacts[i]);
  problem.system.resize(moving.size());
  if (moving.empty()) return problem;
  const ContactRows rows = rows_of(world, moving);
  problem.system.A = rows.matrix(), problem.system.b = at_rest ? rows.acceleration : rows.velocity;
  for (contact::PointLaw& law : problem.system.laws)
    law.friction = problem.friction && random.chance(0.9) ? random.uniform(0.05, 1.2) : 0;
  return problem;
}

}  // namespace momentree::peers
