// Contacts of a world as its user sees them, and distances of its bodies.
#include <cmath>

#include <momentree/contact/distance.hpp>
#include <momentree/dynamics/contacts.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree {

namespace {

ContactPoint from_first_body(ContactPoint point) {
  if (point.one != ground) return point;
  std::swap(point.one, point.other);
  point.normal = -point.normal, point.force = -point.force, point.slip = -point.slip;
  return point;
}

}  // namespace

std::vector<ContactPoint> World::contacts() const {
  std::vector<ContactPoint> all;
  if (model_.colliders().empty()) return all;
  evaluate();
  if (workspace_.contacts == nullptr) return all;
  const ContactWorkspace& own = *workspace_.contacts;
  const std::span<const Contact> closed = tree_.contacts();
  for (std::size_t i = 0; i < closed.size(); ++i) {
    const contact::Touch& touch = own.rows.touches[i];
    ContactPoint point{{closed[i].a}, {closed[i].b}, touch.point, touch.normal, {}, {}, closed[i].mode == Contact::Mode::slip};
    for (std::size_t k = 0; k < 3; ++k)
      point.force += own.rows.forces[3 * i + k] * (k == 0 ? touch.normal : touch.tangent[k - 1]);
    for (std::size_t k = 1; k < 3; ++k) point.slip += own.rows.velocity[3 * i + k] * touch.tangent[k - 1];
    all.push_back(from_first_body(point));
  }
  for (const HeldForce& held : own.held) {
    if ((held.a >= 0 && !alive({held.a})) || (held.b >= 0 && !alive({held.b}))) continue;
    all.push_back(from_first_body({{held.a}, {held.b}, held.point, held.normal, held.force, held.slip, norm(held.slip) > 1e-6}));
  }
  return all;
}

std::optional<BodyGap> World::gap(BodyId one, BodyId other) const {
  if (one == ground && other != ground) return gap(other, one);  // planes are those of the ground
  std::optional<BodyGap> least;
  const auto place = [&](BodyId body) -> contact::Place {
    if (body == ground) return {};
    const BodyMotion& motion = motions()[static_cast<std::size_t>(body.index)];
    return {rotation_matrix(motion.pose.rotation), motion.pose.position, motion.linear, motion.angular};
  };
  for (const BodyId body : {one, other})
    if (body != ground && !alive(body)) return least;
  const contact::Place a = place(one), b = place(other);
  for (const Collider& first : model_.colliders()) {
    if (first.body != one || first.plane) continue;
    for (const Collider& second : model_.colliders()) {
      if (second.body != other) continue;
      const contact::NearestPoints nearest = second.plane
                                                 ? contact::distance_to_plane(first.solid, a, second.point, second.normal)
                                                 : contact::distance(first.solid, a, second.solid, b);
      if (least && nearest.distance >= least->distance) continue;
      const auto velocity = [](const contact::Place& of, const Vec3& point) { return of.v + cross(of.w, point - of.r); };
      least = BodyGap{nearest.distance, dot(nearest.normal, velocity(a, nearest.on_one) - velocity(b, nearest.on_other))};
    }
  }
  return least;
}

}  // namespace momentree
