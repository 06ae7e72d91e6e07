// Contacts of a world as its user sees them, and distances of its bodies.
#include <algorithm>

#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/simulate/contact/contact_bodies.hpp>
#include <momentree/simulate/contact/contact_pairs.hpp>
#include <momentree/simulate/events/topology_record.hpp>
#include <momentree/simulate/stepping/overlap.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

ContactPoint in_order(ContactPoint point) {
  if (point.other == ground || (point.one != ground && point.one.index < point.other.index)) return point;
  std::swap(point.one, point.other);
  point.normal = -point.normal, point.force = -point.force, point.slip = -point.slip;
  point.moment = -point.moment;
  return point;
}

std::vector<ContactPoint> World::contacts() const {
  std::vector<ContactPoint> all;
  if (model_.colliders().empty()) return all;
  evaluate();
  if (workspace_.contacts == nullptr) return all;
  const ContactWorkspace& own = *workspace_.contacts;
  const std::span<const Contact> closed = tree_.contacts();
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i].cable >= 0) continue;
    const contact::Touch& touch = own.rows.touches[i];
    ContactPoint point{
        {closed[i].a},         {closed[i].b}, touch.point, touch.normal, {}, {}, closed[i].mode == Contact::Mode::slip,
        own.rows.determined(i)};
    for (std::size_t k = 0; k < 3; ++k) point.force += own.rows.forces[3 * i + k] * along(touch, k);
    for (std::size_t k = 1; k < 3; ++k) point.slip += own.rows.velocity[3 * i + k] * touch.tangent[k - 1];
    all.push_back(in_order(point));
  }
  for (const HeldForce& held : own.held) {
    if (held.cable >= 0) continue;
    if ((held.a >= 0 && !alive({held.a})) || (held.b >= 0 && !alive({held.b}))) continue;
    all.push_back(in_order(
        {{held.a}, {held.b}, held.point, held.normal, held.force, held.slip, norm(held.slip) > 1e-6, std::nullopt, held.moment}));
  }
  return all;
}

// False if other forces of redundant contacts, which move nothing, change the reaction of a joint.
bool World::contacts_determine(JointId number) const {
  constexpr double rounding = 1e-7;  // of forces of about 1 N
  evaluate();
  if (workspace_.contacts == nullptr || tree_.contacts().empty()) return true;
  if (!(open_joints_of_ == state_.stamp())) {
    const ContactRows& rows = workspace_.contacts->rows;
    std::vector<HeldForce>& held = workspace_.contacts->held;
    const std::size_t count = held.size();
    std::vector<HeldForce> open;
    for (std::size_t i = 0; i < rows.contacts(); ++i) {
      if (rows.determined(i)) continue;
      open.push_back({.a = tree_.contacts()[i].a, .b = tree_.contacts()[i].b, .point = rows.touches[i].point});
      for (std::size_t k = 0; k < 3; ++k) open.back().force += rows.open[3 * i + k] * along(rows.touches[i], k);
    }
    open_joints_.clear();
    std::vector<std::pair<JointId, Wrench>> before;
    if (!open.empty())
      for (const JointId joint : present_joints(*this)) before.emplace_back(joint, reaction(joint));
    const auto again = [this] { workspace_.evaluated = workspace_.accelerated = {}; };
    held.insert(held.end(), open.begin(), open.end()), again();
    for (const auto& [joint, W] : before) {
      const Wrench other = reaction(joint);
      if (norm(other.force - W.force) > rounding || norm(other.torque - W.torque) > rounding) open_joints_.push_back(joint.index);
    }
    held.resize(count), again();
    open_joints_of_ = state_.stamp();
  }
  return std::ranges::find(open_joints_, number.index) == open_joints_.end();
}

double World::cable_tension(int cable) const {
  evaluate();
  if (workspace_.contacts == nullptr) return 0;
  const ContactWorkspace& own = *workspace_.contacts;
  const std::span<const Contact> closed = tree_.contacts();
  for (std::size_t i = 0; i < closed.size(); ++i)
    if (closed[i].cable == cable) return own.rows.forces[3 * i];
  for (const HeldForce& held : own.held)
    if (held.cable == cable) return dot(held.force, held.normal);
  return 0;
}

// True if two colliders do not touch each other at present, whatever their distance is.
bool World::pass_through(int one_collider, int other_collider) const {
  const BodyId one = model_.colliders()[static_cast<std::size_t>(one_collider)].body,
               other = model_.colliders()[static_cast<std::size_t>(other_collider)].body;
  const Connections& now = connections();
  return model_.contact_law(one, other).off || now.are_welded(one.index, other.index) ||
         (now.are_joined(one.index, other.index) && !touch_while_joined(model_, one, other)) ||
         std::binary_search(constraints_.overlapping.begin(), constraints_.overlapping.end(),
                            pair_of_colliders(model_, one_collider, other_collider));
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
  const auto number_of = [this](const Collider& collider) { return static_cast<int>(&collider - model_.colliders().data()); };
  const auto compare = [&](const Collider& first, const Collider& second) {
    const contact::Place a = place(first.body), b = place(second.body);
    const double least_distance = apart(first, a, second, b);
    if (least && !least->passes && least_distance >= least->distance) return;
    const bool passes = pass_through(number_of(first), number_of(second));
    if (least && passes && (!least->passes || least_distance >= least->distance)) return;
    const contact::NearestPoints nearest = distance_to(first.solid, a, second, b);
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
      if (first.plane || first.field)
        compare(second, first);
      else
        compare(first, second);
    }
  }
  return least;
}

}  // namespace momentree
