#pragma once
// Piles of boxes, and what the solver of time stepping gets of them.
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <momentree/contact/candidates.hpp>
#include <momentree/contact/many_points.hpp>
#include <momentree/contact/system.hpp>
#include <momentree/dynamics/contacts/contact_parts.hpp>
#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/world/world.hpp>
#include <tests/oracle/prng.hpp>

namespace momentree::peers {

/// Columns of boxes side by side on the ground, each box turned and shifted a little. They move at random, and fall at 0.1 m/s.
inline Model pile(oracle::Prng& random, int boxes, int height, const Vec3& size) {
  Model model({.gravity = {0, 0, -9.81}});
  for (int k = 0; k < boxes; ++k) {
    const double angle = random.uniform(-0.2, 0.2), x = 0.7 * size.x * 2 * (k / height), z = size.z * (k % height + 0.5);
    const double mass = random.log_uniform(0.5, 5), along_x = random.uniform(-0.05, 0.05), along_y = random.uniform(-0.05, 0.05);
    BodySpec box{.name = "box" + std::to_string(k), .mass = mass, .joint = Free{}};
    const double xx = mass / 12 * size.x * size.x, yy = mass / 12 * size.y * size.y, zz = mass / 12 * size.z * size.z;
    box.inertia = diagonal(yy + zz, xx + zz, xx + yy);
    box.q = {x + along_x, along_y, z, std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle)};
    for (int i = 0; i < 6; ++i) {
      const double v = random.uniform(-0.05, 0.05);
      box.v.push_back(i == 2 ? v - 0.1 : v);
    }
    model.add(box);
  }
  return model;
}

/// The points of boxes on the ground and on each other.
inline std::vector<Contact> points_of(const World& world, const contact::Solid& solid, double within) {
  const auto place = [&](int body) -> contact::Place {
    const BodyMotion& motion = world.motions()[static_cast<std::size_t>(body)];
    return {rotation_matrix(motion.pose.rotation), motion.pose.position, motion.linear, motion.angular};
  };
  std::vector<Contact> all;
  std::vector<contact::Candidate> found;
  const auto add = [&](int a, int b) {
    for (const contact::Candidate& candidate : std::exchange(found, {})) {
      Contact contact;
      contact.features = candidate.features, contact.id = candidate.id;
      contact.a = candidate.swapped ? b : a, contact.b = candidate.swapped ? a : b;
      all.push_back(contact);
    }
  };
  for (int a = 0; a < world.model().size(); ++a) {
    contact::face_plane(solid, place(a), {}, {0, 0, 1}, {}, within, found);
    add(a, -1);
    for (int b = a + 1; b < world.model().size(); ++b) {
      if (norm(place(a).r - place(b).r) > 2 * solid.reach) continue;
      contact::face_each_other(solid, place(a), solid, place(b), within, found);
      add(a, b);
    }
  }
  return all;
}

/// The problem that a time step has to solve.
inline contact::ManyPoints points_of_step(const World& world, const std::vector<Contact>& contacts, double friction) {
  const Tree& tree = world.tree();
  const double* const q = world.state().q().data();
  Workspace<double> workspace(tree);
  ContactRows rows;
  accelerate(tree, world.state(), workspace);
  locate_bodies(tree, world.state(), workspace);
  place_contacts(tree, workspace, contacts, rows);
  ContactParts parts;
  contact::ManyPoints many;
  parts.begin(tree, many);
  parts.add_points(tree, q, workspace, contacts, rows, many);
  for (contact::ManyPoints::Point& point : many.points) point.friction = friction;
  many.r.assign(many.b.size(), 0.0);
  return many;
}

/// The same with a dense matrix.
inline contact::System dense(const contact::ManyPoints& many) {
  contact::System all;
  all.resize(many.points.size());
  all.b = many.b;
  for (std::size_t i = 0; i < many.points.size(); ++i) {
    all.laws[i].friction = many.points[i].friction;
    for (std::size_t j = 0; j < many.points.size(); ++j)
      for (const contact::ManyPoints::Part& one : many.points[i].parts)
        for (const contact::ManyPoints::Part& other : many.points[j].parts) {
          if (one.group < 0 || one.group != other.group) continue;
          const auto n = static_cast<std::size_t>(one.count);
          for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 3; ++column)
              for (std::size_t k = 0; k < n; ++k)
                all.element(3 * i + row, 3 * j + column) += many.J[one.at + n * row + k] * many.Y[other.at + n * column + k];
        }
  }
  return all;
}

}  // namespace momentree::peers
