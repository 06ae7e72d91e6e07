#include <momentree/simulate/contact/contact_pairs.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/contact/shapes/cylinder.hpp>
#include <momentree/contact/shapes/height_field.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

namespace {

constexpr int stride = static_cast<int>(most_colliders), first_cable = stride * stride;

}  // namespace

int pair_of_colliders(const Model& model, int one, int other) {
  const auto plane = [&](int collider) { return model.colliders()[static_cast<std::size_t>(collider)].plane; };
  const bool swap = plane(one) || (!plane(other) && other < one);
  return swap ? other * stride + one : one * stride + other;
}

int pair_of_cable(int spring) { return first_cable + spring; }

double above_ground(const Collider& below, const Vec3& centre, double radius) {
  return below.field ? contact::clearance(*below.field, centre, radius) : dot(below.normal, centre - below.point) - radius;
}

double apart(const Collider& one, const contact::Place& a, const Collider& other, const contact::Place& b) {
  const Vec3 centre = a.r + a.R * one.solid.centre;
  if (other.plane || other.field) return above_ground(other, centre, one.solid.reach);
  return norm(centre - b.r - b.R * other.solid.centre) - one.solid.reach - other.solid.reach;
}

contact::NearestPoints distance_to(const contact::Solid& solid, const contact::Place& place, const Collider& other,
                                   const contact::Place& of_other) {
  if (other.plane) return contact::distance_to_plane(solid, place, other.point, other.normal);
  return other.field ? contact::distance_to_field(solid, place, *other.field)
                     : contact::distance(solid, place, other.solid, of_other);
}

bool ContactPairs::any() const {
  if (!world_->model().has_contact()) return false;
  if (bodies_ != world_->model().size()) find_any();
  return any_;
}

// Whether any two bodies can touch.
void ContactPairs::find_any() const {
  const Model& model = world_->model();
  bodies_ = model.size();
  known_.clear();
  any_ = std::ranges::any_of(model.springs(), &Spring::inextensible);
  const std::vector<Collider>& all = model.colliders();
  for (std::size_t i = 0; i < all.size() && !any_; ++i)
    for (std::size_t k = 0; k < i && !any_; ++k)
      any_ = all[i].body != all[k].body && !model.contact_law(all[i].body, all[k].body).off;
}

const ContactPair& ContactPairs::operator[](int number) const {
  const auto found = known_.find(number);
  if (found != known_.end()) return found->second;
  const Model& model = world_->model();
  ContactPair pair;
  if (number >= first_cable) {
    pair.cable = number - first_cable;
    const Spring& cable = model.springs()[static_cast<std::size_t>(pair.cable)];
    pair.a = cable.from.body.index, pair.b = cable.to.body.index, pair.law_name = cable.name;
    if (pair.a < 0) std::swap(pair.a, pair.b);
    pair.law = {.friction = 0, .static_friction = 0, .restitution = cable.restitution};
    return known_.emplace(number, std::move(pair)).first->second;
  }
  const auto collider = [&](int i) { return &model.colliders()[static_cast<std::size_t>(i)]; };
  pair.one = collider(number / stride), pair.other = collider(number % stride);
  if (pair.one->body == ground) std::swap(pair.one, pair.other);
  const BodyId one = pair.one->body, other = pair.other->body;
  pair.a = one.index, pair.b = other.index;
  pair.law = model.contact_law(one, other), pair.while_joined = touch_while_joined(model, one, other);
  if (!pair.other->plane) pair.thickness = std::min(pair.one->solid.thickness, pair.other->solid.thickness);
  if (const ContactRule* const rule = model.contact_rule(one, other)) pair.law_name = rule->name;
  return known_.emplace(number, std::move(pair)).first->second;
}

const std::vector<int>& ContactPairs::near(double h, double margin) const {
  const std::vector<Collider>& all = world_->model().colliders();
  const double accelerated = world_->gravity() * h;
  balls_.clear(), solids_.clear(), near_.clear();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].plane || all[i].field || world_->is_gone(all[i].body.index)) continue;
    const contact::Place at = world_->place(all[i].body.index);
    const contact::Solid& solid = all[i].solid;
    const Vec3 arm = at.R * solid.centre;
    const double speed = 2 * (norm(at.v + cross(at.w, arm)) + norm(at.w) * solid.reach) + accelerated;
    balls_.push_back({at.r + arm, solid.reach + speed * h + margin * std::max(1.0, norm(at.r))});
    solids_.push_back(static_cast<int>(i));
  }
  for (const auto& [one, other] : broad_phase_.find(balls_))
    add_if_near(solids_[static_cast<std::size_t>(one)], solids_[static_cast<std::size_t>(other)]);
  for (int plane = 0; plane < static_cast<int>(all.size()); ++plane) {
    const Collider& floor = all[static_cast<std::size_t>(plane)];
    if (!floor.plane && !floor.field) continue;
    for (std::size_t i = 0; i < balls_.size(); ++i)
      if (!(above_ground(floor, balls_[i].centre, balls_[i].radius) > 0)) add_if_near(solids_[i], plane);
  }
  for (int s = 0; s < static_cast<int>(world_->model().springs().size()); ++s)
    if (world_->can_be_taut(s)) near_.push_back(pair_of_cable(s));
  std::sort(near_.begin(), near_.end());
  return near_;
}

// Of colliders whose balls are near each other, those that do not pass through each other.
void ContactPairs::add_if_near(int one, int other) const {
  const Connections& connections = world_->connections();
  const auto body_of = [&](int i) { return world_->model().colliders()[static_cast<std::size_t>(i)].body.index; };
  if (connections.are_welded(body_of(one), body_of(other))) return;
  const int number = pair_of_colliders(world_->model(), one, other);
  const ContactPair& pair = (*this)[number];
  if (pair.law.off || (!pair.while_joined && connections.are_joined(pair.a, pair.b))) return;
  if (!std::ranges::binary_search(world_->overlapping(), number)) near_.push_back(number);
}

contact::Features ContactPairs::features_of(const ContactPair& cable) const {
  const Spring& spring = world_->model().springs()[static_cast<std::size_t>(cable.cable)];
  contact::Features features{.pair = contact::FeaturePair::cable};
  features.point_a = spring.from.point, features.point_b = spring.to.point;
  if (spring.from.body.index != cable.a) std::swap(features.point_a, features.point_b);
  features.length = world_->tree().springs().law(cable.cable).rest;
  return features;
}

const std::vector<contact::Candidate>& ContactPairs::candidates(const ContactPair& pair, double within) const {
  found_.clear();
  const contact::Place a = world_->place(pair.a), b = world_->place(pair.b);
  if (pair.cable >= 0) {
    const contact::Features features = features_of(pair);
    const double gap = contact::touch(features, a, b).gap;
    if (gap < within) found_.push_back({features, false, 0, gap});
  } else if (pair.other->plane) {
    contact::face_plane(pair.one->solid, a, pair.other->point, pair.other->normal, b, within, found_);
  } else if (pair.other->field) {
    contact::face_field(pair.one->solid, a, *pair.other->field, within, found_);
  } else {
    contact::face_each_other(pair.one->solid, a, pair.other->solid, b, within, found_);
  }
  return found_;
}

Contact ContactPairs::contact_of(int number, const contact::Candidate& candidate) const {
  const ContactPair& pair = (*this)[number];
  Contact c;
  c.features = candidate.features, c.id = candidate.id, c.pair = number;
  c.a = pair.a, c.b = pair.b, c.cable = pair.cable;
  if (pair.cable < 0) c.belt_a = pair.one->solid.belt, c.belt_b = pair.other->solid.belt;
  if (candidate.swapped) std::swap(c.a, c.b), std::swap(c.belt_a, c.belt_b);
  c.friction = pair.law.friction;
  return c;
}

void ContactPairs::add(int number, double within, std::vector<Contact>& out) const {
  for (const contact::Candidate& found : candidates((*this)[number], within)) out.push_back(contact_of(number, found));
}

void ContactPairs::add_overlapping(int number, double within, std::vector<Contact>& out) const {
  const ContactPair& pair = (*this)[number];
  if (!pair.polyhedra()) return add(number, within, out);
  found_.clear();
  overlap_.find(pair.one->solid, world_->place(pair.a), pair.other->solid, world_->place(pair.b), within, found_);
  for (const contact::Candidate& found : found_) out.push_back(contact_of(number, found));
}

double ContactPairs::apart(const ContactPair& pair) const {
  const contact::Place a = world_->place(pair.a), b = world_->place(pair.b);
  return pair.cable >= 0 ? contact::touch(features_of(pair), a, b).gap : momentree::apart(*pair.one, a, *pair.other, b);
}

double ContactPairs::speed_bound(const ContactPair& pair) const {
  const contact::Place a = world_->place(pair.a), b = world_->place(pair.b);
  if (pair.cable >= 0) {
    const contact::Features f = features_of(pair);
    return norm(a.v - b.v) + norm(a.w) * norm(f.point_a) + norm(b.w) * norm(f.point_b);
  }
  const contact::Solid &one = pair.one->solid, &other = pair.other->solid;
  const Vec3 va = a.v + cross(a.w, a.R * one.centre), vb = b.v + cross(b.w, b.R * other.centre);
  return norm(va - vb) + norm(a.w) * one.reach + (pair.other->plane ? 0.0 : norm(b.w) * other.reach);
}

double ContactPairs::margin(const ContactPair& pair) const {
  if (pair.cable >= 0) return 0.05 * world_->tree().springs().law(pair.cable).rest;  // so that it does not become taut unseen
  return 0.5 * std::min({pair.thickness, pair.one->solid.reach, pair.other->solid.reach});
}

double ContactPairs::looked_within(const ContactPair& pair) {
  if (std::isfinite(pair.thickness)) return 0.5 * pair.thickness + 1e-9;
  return pair.cable >= 0 ? HUGE_VAL : pair.one->solid.reach;
}

// The nearest point of a cylinder's rim jumps to the other side where an end is parallel to a plane, or to an edge. A time in
// which the tilt does not get that far, or infinity once the cylinder stands.
double ContactPairs::time_to_stand(const ContactPair& pair, double acceleration) const {
  const contact::Solid &one = pair.one->solid, &other = pair.other->solid;
  const double rim = std::max(one.rim, other.rim);
  if (!(rim > 0)) return HUGE_VAL;
  const auto time = [&](const contact::Tilt& tilt) {
    if (!(tilt.sine * rim >= contact::standing) || !std::isfinite(tilt.sine)) return HUGE_VAL;
    const double falling = std::max(0.0, -tilt.rate), quicker = acceleration / rim;
    if (!(quicker > 0)) return falling > 0 ? 0.9 * tilt.sine / falling : HUGE_VAL;
    return (std::sqrt(falling * falling + 3.6 * tilt.sine * quicker) - falling) / (2 * quicker);
  };
  const contact::Place a = world_->place(pair.a), b = world_->place(pair.b);
  if (pair.other->plane) {
    const contact::Features end{.pair = contact::FeaturePair::circle_plane,
                                .line_a = normalized(one.ends[1] - one.ends[0]),
                                .line_b = pair.other->normal};
    return time(contact::tilt_of(end, a, b));
  }
  constexpr double near = 1e-3;  // of the radius
  double least = HUGE_VAL;
  for (const contact::Candidate& c : candidates(pair, near * rim))
    least = std::min(least, time(contact::tilt_of(c.features, c.swapped ? b : a, c.swapped ? a : b)));
  return least;
}

double ContactPairs::longest_step(const ContactPair& pair, double distance, double speed, double acceleration) const {
  const double until_near = 2 * std::max(distance, 0.0) / speed;
  if (pair.cable >= 0) return until_near + margin(pair) / speed;
  // Above a plane not through an angle within which points come near and leave again.
  const double longest =
      pair.other->plane ? std::max(until_near, 0.3 / norm(world_->place(pair.a).w)) : until_near + margin(pair) / speed;
  return std::min(longest, time_to_stand(pair, acceleration));
}

double ContactPairs::rounding(const ContactPair& pair) const {
  const double length = pair.cable >= 0 ? world_->tree().springs().law(pair.cable).rest : 0.0;
  return 4 * std::numeric_limits<double>::epsilon() * (norm(world_->place(pair.a).r) + length);
}

ContactPairs::Gap ContactPairs::gap(int number, double within) const {
  const ContactPair& pair = (*this)[number];
  const contact::Place a = world_->place(pair.a), b = world_->place(pair.b);
  Gap least{within, 0};
  for (const contact::Candidate& c : candidates(pair, within)) {
    if (!(c.gap < least.value) || world_->is_closed(number, c.id)) continue;
    const contact::Place &first = c.swapped ? b : a, &second = c.swapped ? a : b;
    const contact::Touch touch = contact::touch(c.features, first, second);
    least = {c.gap, dot(touch.normal, contact::relative_velocity(touch, first, second))};
  }
  return least;
}

bool ContactPairs::still_face(int number) const {
  const ContactPair& pair = (*this)[number];
  const std::vector<contact::Candidate>& found = candidates(pair, 1e-6 * size(pair));
  return std::ranges::all_of(world_->closed_of(number), [&](const ContactsByPair::Entry& entry) {
    const std::uint64_t id = world_->closed()[entry.second].id;
    return std::ranges::any_of(found, [&](const contact::Candidate& c) { return c.id == id; });
  });
}

double ContactPairs::depth(int number) const {
  const ContactPair& pair = (*this)[number];
  double depth = -gap(number, 0).value;
  if (!pair.polyhedra()) return depth;
  found_.clear();
  overlap_.find(pair.one->solid, world_->place(pair.a), pair.other->solid, world_->place(pair.b), 0, found_);
  for (const contact::Candidate& found : found_) depth = std::max(depth, -found.gap);
  return depth;
}

contact::NearestPoints ContactPairs::nearest(const ContactPair& pair) const {
  return distance_to(pair.one->solid, world_->place(pair.a), *pair.other, world_->place(pair.b));
}

bool ContactPairs::are_apart(int number) const {
  const ContactPair& pair = (*this)[number];
  return nearest(pair).distance > policy::touching_within * size(pair);
}

}  // namespace momentree
