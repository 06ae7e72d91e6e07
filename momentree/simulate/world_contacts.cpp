// Contacts of a world as its user sees them, and distances of its bodies.
#include <algorithm>
#include <cmath>

#include <momentree/contact/distance.hpp>
#include <momentree/contact/system.hpp>
#include <momentree/dynamics/contacts.hpp>
#include <momentree/simulate/contact_bodies.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

namespace {

std::size_t at_row(std::size_t contact, std::size_t k) { return 3 * contact + k; }

ContactLaw law_between(const Model& model, const Contact& c) { return model.contact_law({c.a}, {c.b}); }

// True if these forces press everywhere, and friction is not larger than it can be.
bool are_possible(const Model& model, std::span<const Contact> contacts, const std::vector<double>& r) {
  constexpr double rounding = 1e-9;
  double size = 0;
  for (const double x : r) size = std::max(size, std::fabs(x));
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double N = r[at_row(i, 0)];
    if (N < -rounding * size) return false;
    if (contacts[i].mode != Contact::Mode::stick) continue;
    const double most = law_between(model, contacts[i]).static_friction * N;
    if (std::hypot(r[at_row(i, 1)], r[at_row(i, 2)]) > most + rounding * size) return false;
  }
  return true;
}

// Of redundant contacts the evaluation takes the least forces, some of which may pull. Others with the same effect do not.
std::vector<double> forces_of_island(const Model& model, std::span<const Contact> contacts, const ContactRows& rows) {
  if (contacts.size() < 2 || are_possible(model, contacts, rows.forces)) return rows.forces;
  contact::System system;
  system.resize(contacts.size());
  system.A = rows.matrix(), system.b = rows.acceleration, system.r = rows.forces;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactLaw law = law_between(model, contacts[i]);
    contact::PointLaw& point = system.laws[i];
    point.slipping = contacts[i].mode == Contact::Mode::slip;
    point.friction = contacts[i].mode == Contact::Mode::smooth ? 0 : point.slipping ? contacts[i].friction : law.static_friction;
    if (!point.slipping) continue;
    for (std::size_t k = 0; k < 2; ++k) point.direction[k] = dot(rows.slip[i], rows.touches[i].tangent[k]);
  }
  constexpr double acceptable = 1e-9;
  return system.solve(contact::Effort::full, acceptable) ? system.r : rows.forces;
}

std::vector<double> possible_forces(const Model& model, std::span<const Contact> contacts, const ContactRows& rows) {
  if (contacts.size() < 2 || are_possible(model, contacts, rows.forces)) return rows.forces;
  std::vector<double> all = rows.forces;
  for (const std::vector<std::size_t>& island : rows.islands()) {
    std::vector<Contact> own;
    for (const std::size_t i : island) own.push_back(contacts[i]);
    const std::vector<double> forces = forces_of_island(model, own, rows.some(island));
    for (std::size_t i = 0; i < island.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) all[at_row(island[i], k)] = forces[at_row(i, k)];
  }
  return all;
}

}  // namespace

ContactPoint in_order(ContactPoint point) {
  if (point.other == ground || (point.one != ground && point.one.index < point.other.index)) return point;
  std::swap(point.one, point.other);
  point.normal = -point.normal, point.force = -point.force, point.slip = -point.slip;
  return point;
}

std::vector<ContactPoint> World::contacts() const {
  std::vector<ContactPoint> all;
  if (model_.colliders().empty()) return all;
  evaluate();
  if (workspace_.contacts == nullptr) return all;
  const ContactWorkspace& own = *workspace_.contacts;
  const std::span<const Contact> closed = tree_.contacts();
  const std::vector<double> r = closed.empty() ? std::vector<double>() : possible_forces(model_, closed, own.rows);
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i].cable >= 0) continue;
    const contact::Touch& touch = own.rows.touches[i];
    ContactPoint point{{closed[i].a}, {closed[i].b}, touch.point, touch.normal, {}, {}, closed[i].mode == Contact::Mode::slip};
    for (std::size_t k = 0; k < 3; ++k) point.force += r[3 * i + k] * (k == 0 ? touch.normal : touch.tangent[k - 1]);
    for (std::size_t k = 1; k < 3; ++k) point.slip += own.rows.velocity[3 * i + k] * touch.tangent[k - 1];
    all.push_back(in_order(point));
  }
  for (const HeldForce& held : own.held) {
    if (held.cable >= 0) continue;
    if ((held.a >= 0 && !alive({held.a})) || (held.b >= 0 && !alive({held.b}))) continue;
    all.push_back(in_order({{held.a}, {held.b}, held.point, held.normal, held.force, held.slip, norm(held.slip) > 1e-6}));
  }
  return all;
}

double World::cable_tension(int cable) const {
  evaluate();
  if (workspace_.contacts == nullptr) return 0;
  const ContactWorkspace& own = *workspace_.contacts;
  const std::span<const Contact> closed = tree_.contacts();
  for (std::size_t i = 0; i < closed.size(); ++i)
    if (closed[i].cable == cable) return possible_forces(model_, closed, own.rows)[3 * i];
  for (const HeldForce& held : own.held)
    if (held.cable == cable) return dot(held.force, held.normal);
  return 0;
}

std::optional<BodyGap> World::gap(BodyId one, BodyId other) const {
  return gap(ContactBodies(model_, one), ContactBodies(model_, other));
}

std::optional<BodyGap> World::gap(const ContactBodies& one, const ContactBodies& other) const {
  std::optional<BodyGap> least;  // of solids that touch, once there are any
  const auto place = [&](BodyId body) -> contact::Place {
    if (body == ground) return {};
    const BodyMotion& motion = motions()[static_cast<std::size_t>(body.index)];
    return {rotation_matrix(motion.pose.rotation), motion.pose.position, motion.linear, motion.angular};
  };
  const auto compare = [&](const Collider& first, const Collider& second) {
    const contact::Place a = place(first.body), b = place(second.body);
    const Vec3 centre = a.r + a.R * first.solid.centre;
    const double apart =  // at least
        second.plane ? dot(second.normal, centre - second.point) - first.solid.reach
                     : norm(centre - b.r - b.R * second.solid.centre) - first.solid.reach - second.solid.reach;
    if (least && !least->passes && apart >= least->distance) return;
    const bool passes = model_.contact_law(first.body, second.body).off;
    if (least && passes && (!least->passes || apart >= least->distance)) return;
    const contact::NearestPoints nearest = second.plane ? contact::distance_to_plane(first.solid, a, second.point, second.normal)
                                                        : contact::distance(first.solid, a, second.solid, b);
    if (least && least->passes == passes && nearest.distance >= least->distance) return;
    const auto velocity = [](const contact::Place& of, const Vec3& point) { return of.v + cross(of.w, point - of.r); };
    const double rate = dot(nearest.normal, velocity(a, nearest.on_one) - velocity(b, nearest.on_other));
    least = BodyGap{nearest.distance, rate, passes};
  };
  const auto counts = [&](const Collider& collider, const ContactBodies& of) {
    return of.holds(collider.body) && (collider.body == ground || alive(collider.body));
  };
  for (const Collider& first : model_.colliders()) {
    if (!counts(first, one)) continue;
    for (const Collider& second : model_.colliders()) {
      if (first.body == second.body || !counts(second, other)) continue;
      if (first.plane)
        compare(second, first);  // planes are those of the ground
      else
        compare(first, second);
    }
  }
  return least;
}

}  // namespace momentree
