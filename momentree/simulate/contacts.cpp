// Pairs of solids, what is to be located within a step, and impacts; contact_states.cpp chooses what follows.
#include <momentree/simulate/contacts.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <momentree/contact/cylinder.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/contacts_impl.hpp>

namespace momentree {

Contacts::Contacts(World& world, Evaluator& evaluate, double tolerance, contact::Simultaneous how, double step)
    : world_(&world), evaluate_(&evaluate), tolerance_(tolerance), step_(step), simultaneous_(how), pairs_(world.model_) {}
Contacts::~Contacts() = default;

bool Contacts::any() {
  if (!world_->model_.has_contact()) return false;
  if (bodies_ != world_->model_.size()) find_any();
  return any_;
}

// Whether any two bodies can touch.
void Contacts::find_any() {
  const Model& model = world_->model_;
  bodies_ = model.size();
  pairs_.clear();
  const std::vector<Spring>& springs = model.springs();
  any_ = std::any_of(springs.begin(), springs.end(), [](const Spring& s) { return s.inextensible; });
  const std::vector<Collider>& all = model.colliders();
  for (std::size_t i = 0; i < all.size() && !any_; ++i)
    for (std::size_t k = 0; k < i && !any_; ++k)
      any_ = all[i].body != all[k].body && !model.contact_law(all[i].body, all[k].body).off;
}

const Contacts::Pair& Contacts::Pairs::operator[](std::size_t number) const {
  const auto found = known_.find(number);
  if (found != known_.end()) return found->second;
  const std::vector<Collider>& all = model_->colliders();
  if (number >= most_colliders * most_colliders) {
    const auto spring = number - most_colliders * most_colliders;
    const Spring& cable = model_->springs()[spring];
    Pair pair{.a = cable.from.body.index, .b = cable.to.body.index, .law_name = cable.name, .cable = static_cast<int>(spring)};
    if (pair.a < 0) std::swap(pair.a, pair.b);
    pair.law = {.friction = 0, .static_friction = 0, .restitution = cable.restitution};
    return known_.emplace(number, std::move(pair)).first->second;
  }
  const Collider &first = all[number / most_colliders], &second = all[number % most_colliders];
  // The ground is the second one.
  const bool swap = first.body == ground;
  const Collider &one = swap ? second : first, &other = swap ? first : second;
  Pair pair{.one = &one, .other = &other, .a = one.body.index, .b = other.body.index};
  pair.law = model_->contact_law(one.body, other.body);
  pair.while_joined = model_->touch_while_joined(one.body, other.body);
  if (!other.plane) pair.thickness = std::min(one.solid.thickness, other.solid.thickness);
  if (const ContactRule* const rule = model_->contact_rule(one.body, other.body)) pair.law_name = rule->name;
  return known_.emplace(number, std::move(pair)).first->second;
}

// Pairs that can touch within h seconds, or are nearer than `margin` (m), in ascending order; and all cables.
const std::vector<int>& Contacts::near_pairs(double h, double margin) const {
  const std::vector<Collider>& all = world_->model_.colliders();
  const double accelerated = norm(world_->model_.gravity()) * h;
  const Connections& connections = world_->connections();
  const std::vector<int>& passing = world_->overlapping_;
  balls_.clear(), solids_.clear(), near_.clear();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].plane || all[i].field || (all[i].body != ground && !world_->alive(all[i].body))) continue;
    const contact::Place at = place(all[i].body.index);
    const contact::Solid& solid = all[i].solid;
    const Vec3 arm = at.R * solid.centre;
    const double speed = 2 * (norm(at.v + cross(at.w, arm)) + norm(at.w) * solid.reach) + accelerated;
    balls_.push_back({at.r + arm, solid.reach + speed * h + margin * std::max(1.0, norm(at.r))});
    solids_.push_back(static_cast<int>(i));
  }
  const auto body_of = [&](int collider) { return all[static_cast<std::size_t>(collider)].body.index; };
  const auto add = [&](int one, int other) {
    if (connections.are_welded(body_of(one), body_of(other))) return;
    const int number = pair_of_colliders(world_->model_, one, other);
    const Pair& pair = pairs_[static_cast<std::size_t>(number)];
    if (pair.law.off || (!pair.while_joined && connections.are_joined(pair.a, pair.b))) return;
    if (!std::binary_search(passing.begin(), passing.end(), number)) near_.push_back(number);
  };
  for (const auto& [one, other] : broad_phase_.find(balls_))
    add(solids_[static_cast<std::size_t>(one)], solids_[static_cast<std::size_t>(other)]);
  for (int plane = 0; plane < static_cast<int>(all.size()); ++plane) {
    const Collider& floor = all[static_cast<std::size_t>(plane)];
    if (!floor.plane && !floor.field) continue;
    for (std::size_t i = 0; i < balls_.size(); ++i)
      if (!(above_ground(floor, balls_[i].centre, balls_[i].radius) > 0)) add(solids_[i], plane);
  }
  for (std::size_t s = 0; s < world_->model_.springs().size(); ++s)
    if (can_be_taut(s)) near_.push_back(pair_of_cable(static_cast<int>(s)));
  std::sort(near_.begin(), near_.end());
  return near_;
}

contact::Place Contacts::place(int body) const {
  if (body < 0) return {};
  const BodyMotion& motion = world_->motions()[static_cast<std::size_t>(body)];
  return {rotation_matrix(motion.pose.rotation), motion.pose.position, motion.linear, motion.angular};
}

bool Contacts::can_be_taut(std::size_t spring) const {
  return world_->model_.springs()[spring].inextensible && world_->tree_.spring_acts(static_cast<int>(spring));
}

contact::Features Contacts::cable_features(const Pair& cable) const {
  const Spring& spring = world_->model_.springs()[static_cast<std::size_t>(cable.cable)];
  contact::Features features{.pair = contact::FeaturePair::cable};
  features.point_a = spring.from.point, features.point_b = spring.to.point;
  if (spring.from.body.index != cable.a) std::swap(features.point_a, features.point_b);
  features.length = world_->tree_.spring_law(cable.cable).rest;
  return features;
}

void Contacts::candidates(const Pair& pair, double within, std::vector<contact::Candidate>& out) const {
  if (pair.cable >= 0) {
    const contact::Features features = cable_features(pair);
    const double gap = contact::touch(features, place(pair.a), place(pair.b)).gap;
    if (gap < within) out.push_back({features, false, 0, gap});
    return;
  }
  const Collider &one = *pair.one, &other = *pair.other;
  const contact::Place a = place(one.body.index), b = place(other.body.index);
  if (other.plane)
    contact::face_plane(one.solid, a, other.point, other.normal, b, within, out);
  else if (other.field)
    contact::face_field(one.solid, a, *other.field, within, out);
  else
    contact::face_each_other(one.solid, a, other.solid, b, within, out);
}

Contact Contacts::contact_of(const Pair& pair, int number, const contact::Candidate& candidate) const {
  Contact c;
  c.features = candidate.features, c.id = candidate.id, c.pair = number;
  c.a = pair.a, c.b = pair.b, c.cable = pair.cable;
  if (pair.cable < 0) c.belt_a = pair.one->solid.belt, c.belt_b = pair.other->solid.belt;
  if (candidate.swapped) std::swap(c.a, c.b), std::swap(c.belt_a, c.belt_b);
  c.friction = pair.law.friction;
  return c;
}

// All contacts that touch at present, whether they are closed or not.
std::vector<Contact> Contacts::touching() {
  std::vector<Contact> all;
  for (const int i : near_pairs(0, policy::touching_within)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    const double size = pair.size(*this);
    if (handling(pair) != Handling::located || apart(pair) > policy::touching_within * size) continue;
    found_candidates_.clear();
    candidates(pair, policy::touching_within * size, found_candidates_);
    for (const contact::Candidate& found : found_candidates_) all.push_back(contact_of(pair, i, found));
  }
  return all;
}

// A lower bound of the distance of two solids, or by how much a cable is slack (m).
double Contacts::apart(const Pair& pair) const {
  const contact::Place a = place(pair.a);
  if (pair.cable >= 0) return contact::touch(cable_features(pair), a, place(pair.b)).gap;
  const contact::Solid& one = pair.one->solid;
  const Vec3 centre = a.r + a.R * one.centre;
  if (pair.other->plane || pair.other->field) return above_ground(*pair.other, centre, one.reach);
  const contact::Place b = place(pair.b);
  const contact::Solid& other = pair.other->solid;
  return norm(centre - b.r - b.R * other.centre) - one.reach - other.reach;
}

// An upper bound of the speed with which points of two solids approach each other, or the ends of a cable part (m/s).
double Contacts::speed_bound(const Pair& pair) const {
  const contact::Place a = place(pair.a), b = place(pair.b);
  if (pair.cable >= 0) {
    const contact::Features f = cable_features(pair);
    return norm(a.v - b.v) + norm(a.w) * norm(f.point_a) + norm(b.w) * norm(f.point_b);
  }
  const contact::Solid &one = pair.one->solid, &other = pair.other->solid;
  const Vec3 va = a.v + cross(a.w, a.R * one.centre), vb = b.v + cross(b.w, b.R * other.centre);
  return norm(va - vb) + norm(a.w) * one.reach + (pair.other->plane ? 0.0 : norm(b.w) * other.reach);
}

// The nearest point of a cylinder's rim jumps to the other side where an end is parallel to a plane, or to an edge. A time in
// which the tilt does not get that far, or infinity once the cylinder stands.
double Contacts::time_to_stand(const Pair& pair, double acceleration) const {
  const contact::Solid &one = pair.one->solid, &other = pair.other->solid;
  const double rim = std::max(one.rim, other.rim);
  if (!(rim > 0)) return HUGE_VAL;
  const auto time = [&](const contact::Tilt& tilt) {
    if (!(tilt.sine * rim >= contact::standing) || !std::isfinite(tilt.sine)) return HUGE_VAL;
    const double falling = std::max(0.0, -tilt.rate), quicker = acceleration / rim;
    if (!(quicker > 0)) return falling > 0 ? 0.9 * tilt.sine / falling : HUGE_VAL;
    return (std::sqrt(falling * falling + 3.6 * tilt.sine * quicker) - falling) / (2 * quicker);
  };
  const contact::Place a = place(pair.a), b = place(pair.b);
  if (pair.other->plane) {
    const contact::Features end{.pair = contact::FeaturePair::circle_plane,
                                .line_a = normalized(one.ends[1] - one.ends[0]),
                                .line_b = pair.other->normal};
    return time(contact::tilt_of(end, a, b));
  }
  constexpr double near = 1e-3;  // of the radius
  found_candidates_.clear();
  candidates(pair, near * rim, found_candidates_);
  double least = HUGE_VAL;
  for (const contact::Candidate& c : found_candidates_)
    least = std::min(least, time(contact::tilt_of(c.features, c.swapped ? b : a, c.swapped ? a : b)));
  return least;
}

// Negative where the solids of a pair overlap, apart from contacts that are closed; `within` if nothing is that near.
Contacts::Gap Contacts::gap_of(int number, double within) const {
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  found_candidates_.clear();
  candidates(pair, within, found_candidates_);
  Gap least{within, 0};
  for (const contact::Candidate& c : found_candidates_) {
    if (!(c.gap < least.value) || is_closed(number, c.id)) continue;
    const contact::Place a = place(pair.a), b = place(pair.b);
    const contact::Place &first = c.swapped ? b : a, &second = c.swapped ? a : b;
    const contact::Touch touch = contact::touch(c.features, first, second);
    least = {c.gap, dot(touch.normal, contact::relative_velocity(touch, first, second))};
  }
  return least;
}

// True if the features of a pair that are in contact are still those that touch.
bool Contacts::face_each_other(int number) const {
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  found_candidates_.clear();
  candidates(pair, 1e-6 * pair.size(*this), found_candidates_);
  for (const ContactsByPair::Entry& entry : closed_of(number)) {
    const std::uint64_t id = world_->tree_.contacts()[entry.second].id;
    const auto same = [&](const contact::Candidate& found) { return found.id == id; };
    if (std::none_of(found_candidates_.begin(), found_candidates_.end(), same)) return false;
  }
  return true;
}

// How far rounding may be off in a gap (m).
double Contacts::noise_of(int number) const {
  const Pair& pair = pairs_[static_cast<std::size_t>(number)];
  const double length = pair.cable >= 0 ? world_->tree_.spring_law(pair.cable).rest : 0.0;
  return 4 * std::numeric_limits<double>::epsilon() * (norm(place(pair.a).r) + length);
}

// How far a solid may move towards another one: not farther than through a part of the thinner one, so that its end is not beyond
// it (m).
double Contacts::margin_within(const Pair& pair) const {
  if (pair.cable >= 0) return 0.05 * world_->tree_.spring_law(pair.cable).rest;  // so that it does not become taut unseen
  return 0.5 * std::min({pair.thickness, pair.one->solid.reach, pair.other->solid.reach});
}

// How near features are whose gap is watched, and how deep they may overlap (m).
double Contacts::looked_within(const Pair& pair) {
  if (std::isfinite(pair.thickness)) return 0.5 * pair.thickness + 1e-9;
  return pair.cable >= 0 ? HUGE_VAL : pair.one->solid.reach;
}

std::vector<double> Contacts::kinetic_by_island() const {
  const Tree& tree = world_->tree_;
  Islands islands(tree);
  std::vector<bool> touches(static_cast<std::size_t>(tree.bodies()), false);
  for (const Contact& c : tree.contacts()) islands.join(c.a, c.b);
  for (const Contact& c : tree.contacts()) touches[static_cast<std::size_t>(islands.of(c.a >= 0 ? c.a : c.b))] = true;
  std::vector<double> energies(touches.size(), 0.0);
  for (const int b : tree.order()) {
    const auto island = static_cast<std::size_t>(islands.of(b));
    const Motion<double>& v = world_->workspace_.bodies[static_cast<std::size_t>(b)].velocity;
    if (touches[island]) energies[island] += 0.5 * dot(v, momentum(tree.link(b).body, v));
  }
  return energies;
}

// A time (s) within which a pair does not come near and leave again unseen.
double Contacts::longest_step(const Pair& pair, double distance, double speed, double acceleration) const {
  const double until_near = 2 * std::max(distance, 0.0) / speed;
  if (pair.cable >= 0) return until_near + margin_within(pair) / speed;
  if (!pair.other->plane) return std::min(until_near + margin_within(pair) / speed, time_to_stand(pair, acceleration));
  // Above a plane not through an angle within which points come near and leave again.
  const double longest = std::max(until_near, 0.3 / norm(place(pair.a).w));
  return std::min(longest, time_to_stand(pair, acceleration));
}

std::span<const Watch> Contacts::watches(double& h) {
  watches_.clear(), conditions_.clear(), noise_.clear();
  const World& world = *world_;
  const double accelerated = norm(world.model_.gravity()) * h;  // what gravity may add to speeds within the step
  for (const int i : near_pairs(h, 0)) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    const double speed = 2 * speed_bound(pair) + 2 * accelerated, distance = apart(pair);
    if (distance > speed * h || handling(pair) == Handling::stepped) continue;
    if (pair.cable >= 0 && is_closed(i, 0)) continue;
    const double longest = longest_step(pair, distance, speed, accelerated / h);
    if (h > longest) h = std::max(longest, 1e-9 * h);
    conditions_.emplace_back(std::make_shared<PairGap>(*this, i, looked_within(pair)), 0.0, false);
    noise_.push_back(noise_of(i));
  }
  for (const int i : world.overlapping_) {
    const Pair& pair = pairs_[static_cast<std::size_t>(i)];
    const double longest = longest_step(pair, 0, 2 * speed_bound(pair) + 2 * accelerated, accelerated / h);
    if (h > longest) h = std::max(longest, 1e-9 * h);
    conditions_.emplace_back(std::make_shared<Apart>(*this, i), 0.0, true);
  }
  const std::span<const Contact> closed = world.tree_.contacts();
  speed_.assign(closed.size(), 0.0), turning_.assign(closed.size(), 0.0), slips_along_.assign(closed.size(), {});
  started_ = world.time();
  if (!closed.empty()) conditions_.emplace_back(std::make_shared<Hold>(*this), 0.0, true);
  for (std::size_t i = 0; i < closed.size(); ++i)
    if (closed[i].mode == Contact::Mode::slip) {
      const Vec3 v = slip_velocity(static_cast<int>(i));
      speed_[i] = norm(v), turning_[i] = turning(i);
      const double shortest = step_ > 0 ? policy::shortest_step_of_slip * step_ : 0;
      h = std::min(h, std::max(shortest, std::min(slip_change_time(i), (step_ > 0 ? 1 : policy::stable_turning) *
                                                                           (speed_[i] + most_kept(i)) / turning_[i])));
      if (!(norm(v) > slowest_slip)) continue;
      slips_along_[i] = normalized(v);
      conditions_.emplace_back(std::make_shared<Slip>(*this, static_cast<int>(i), slips_along_[i]), 0.0, true);
    }
  for (std::size_t i = 0; i < closed.size(); ++i) {
    const Pair& pair = pairs_[static_cast<std::size_t>(closed[i].pair)];
    if (i > 0 && closed[i].pair == closed[i - 1].pair) continue;
    if (pair.cable >= 0 || pair.other->plane) continue;  // a plane has no edges
    conditions_.emplace_back(std::make_shared<Leaves>(*this, closed[i].pair), 0.0, true);
  }
  keep_directions(h);
  for (const Condition& condition : conditions_) {
    const double excess = condition.excess(world, {}).value_or(-1);
    Watch watch{&condition, 0};
    watch.offset = -policy::rounding;
    // Flights begin at the gap at which the last one ended: rounding must not end them at once. What could not be mended at the
    // start counts only if it grows.
    if (watches_.size() < noise_.size() && excess > policy::rounding) watch.offset = -excess - noise_[watches_.size()];
    if (excess > 10 * policy::rounding) watch.offset = condition.above ? -2 * excess : -excess - policy::rounding;
    watch.start = std::min(excess + watch.offset, 0.0);
    watch.start_rate = watch.rate(world);
    watch.precise = watch.start_rate.has_value();
    watches_.push_back(watch);
  }
  return watches_;
}

bool Contacts::must_resolve() {
  bool due = next_rest() <= world_->time();
  for (const Watch& watch : watches_)
    due = due || watch.condition->excess(*world_, {}).value_or(-1) + watch.offset > -2 * policy::touching_within;
  if (due) {
    note_ended_slip();
    return true;
  }
  const std::span<const Contact> closed = world_->tree_.contacts();
  bool creeps = false, in_short_step = false;
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i].mode != Contact::Mode::slip) continue;
    const Vec3 v = slip_velocity(static_cast<int>(i));
    // Slip that came to an end just before a step did has no direction left that could be watched.
    if (norm(v) <= slowest_slip && dot(v, closed[i].direction) < 0) return true;
    if (i >= speed_.size() || !(std::max(norm(v), speed_[i]) < policy::creeping)) continue;
    // It is about to stick or to slip anew; or it has just begun, and steps cannot follow it.
    creeps = creeps || norm(v) < 0.5 * speed_[i];
    in_short_step = in_short_step || (world_->time() - started_) * turning_[i] < policy::creeping;
  }
  short_steps_ = in_short_step ? short_steps_ + 1 : 0;
  if (!creeps && short_steps_ < policy::most_short_steps) return false;
  slowest_ = policy::creeping, short_steps_ = 0;
  return true;
}

double Contacts::next_rest() const {
  double next = HUGE_VAL;
  for (const Contact& c : world_->tree_.contacts())
    if (c.settles >= 0) next = std::min(next, c.settles);
  return next;
}

std::string Contacts::name_of(int body) const { return world_->model_.body_name({body}); }

Vec3 Contacts::slip_velocity(const Contact& contact) const {
  const contact::Place a = place(contact.a), b = place(contact.b);
  const contact::Touch touch = contact::touch(contact.features, a, b);
  const Vec3 v = contact::relative_velocity(touch, a, b) + belt_velocity(contact, touch, a, b);
  return v - dot(v, touch.normal) * touch.normal;
}

// By how much the frictions of its island accelerate the slip of a contact if they turn from its side (m/s²).
double Contacts::turning(std::size_t contact) const {
  world_->evaluate();
  const ContactRows& rows = world_->workspace_.contacts->rows;
  const std::span<const Contact> closed = world_->tree_.contacts();
  double sum = 0;
  for (const std::size_t j : rows.of_group(rows.groups[rows.group_of[contact]])) {
    if (closed[j].mode != Contact::Mode::slip) continue;
    const double f1 = rows.forces[3 * j + 1], f2 = rows.forces[3 * j + 2];
    const auto change = [&](std::size_t k) {
      return rows.mobility(3 * contact + k, 3 * j + 1) * f1 + rows.mobility(3 * contact + k, 3 * j + 2) * f2;
    };
    sum += std::hypot(change(1), change(2));
  }
  return sum;
}

// Slip that is slow for a step of h seconds keeps its direction in it, without which its sideways motion would be unstable.
void Contacts::keep_directions(double h) {
  std::vector<Contact> all(world_->tree_.contacts().begin(), world_->tree_.contacts().end());
  bool any = false;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].mode != Contact::Mode::slip) continue;
    const double begun = step_ == 0 && least_kept(i) > slowest_slip ? least_kept(i) : 0;
    const double keeps = std::clamp(turning_[i] * (step_ > 0 ? step_ : h) / 2 - speed_[i], begun, most_kept(i));
    any = any || keeps > 0 || all[i].keeps_direction > 0;
    all[i].direction = world_->workspace_.contacts->rows.slip[i], all[i].keeps_direction = keeps;
  }
  if (any) set(std::move(all)), (*evaluate_)(world_->state_);
}

// Fixed steps keep the direction of slip that has begun. Methods that adapt theirs keep more and more of it while it goes
// straight on.
double Contacts::most_kept(std::size_t contact) const {
  const double now = kept(contact), least = least_kept(contact);
  if (step_ > 0) return now > 0 ? HUGE_VAL : 0;
  if (turned(contact) > policy::most_turned) return least;
  return std::max(least, turned(contact) * policy::keeps_more < policy::most_turned ? policy::keeps_more * now : now);
}

// What a contact keeps, or, if it has closed since its pair began to slip, what others of the pair do (m/s).
double Contacts::kept(std::size_t contact) const {
  const std::span<const Contact> closed = world_->tree_.contacts();
  double most = closed[contact].keeps_direction;
  if (most > 0) return most;
  for (const ContactsByPair::Entry& entry : closed_of(closed[contact].pair))
    if (closed[entry.second].mode == Contact::Mode::slip) most = std::max(most, closed[entry.second].keeps_direction);
  return most;
}

// What slip keeps that turns (m/s): next to nothing, unless it has just begun.
double Contacts::least_kept(std::size_t contact) const {
  const double slow = policy::slow_slip * turning_[contact];
  return speed_[contact] < 2 * slow && kept(contact) > 0.5 * slow ? slow : slowest_slip;
}

// By how much slip has turned less because it has kept its direction (m/s).
double Contacts::turned(std::size_t contact) const {
  const Contact& c = world_->tree_.contacts()[contact];
  return c.keeps_direction * norm(world_->workspace_.contacts->rows.slip[contact] - c.direction);
}

bool Contacts::kept_too_much() const {
  const std::span<const Contact> closed = world_->tree_.contacts();
  if (step_ > 0) return false;
  world_->evaluate();
  for (std::size_t i = 0; i < closed.size(); ++i)
    if (closed[i].mode == Contact::Mode::slip && turned(i) > policy::most_turned && closed[i].keeps_direction > least_kept(i))
      return true;
  return false;
}

void Contacts::keep_less() {
  std::vector<Contact> all(world_->tree_.contacts().begin(), world_->tree_.contacts().end());
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].mode == Contact::Mode::slip) all[i].keeps_direction = std::min(all[i].keeps_direction, least_kept(i));
  set(std::move(all));
}

// The time (s) in which the slip velocity of a contact changes by its own size, at its present rate; for slip too slow to be
// followed, by `creeping`. In a longer adaptive step slip can end, or turn round, without being seen at the end of any stage.
double Contacts::slip_change_time(std::size_t contact) const {
  world_->evaluate();
  const ContactRows& rows = world_->workspace_.contacts->rows;
  double v[2] = {}, a[2] = {};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t row = 3 * contact + k + 1;
    v[k] = rows.velocity[row], a[k] = rows.acceleration[row];
    for (const std::size_t j : rows.of_group(rows.groups[rows.group_of[contact]]))
      for (std::size_t i = 0; i < 3; ++i) a[k] += rows.mobility(row, 3 * j + i) * rows.forces[3 * j + i];
  }
  return std::max(std::hypot(v[0], v[1]), policy::creeping) / std::hypot(a[0], a[1]);
}

double Contacts::Pair::size(const Contacts& all) const { return std::max(1.0, norm(all.place(a).r)); }

}  // namespace momentree
