#include <momentree/simulate/stepping/step_impulses.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

namespace {

bool earlier(const SteppedContact& x, const SteppedContact& y) { return x.pair != y.pair ? x.pair < y.pair : x.id < y.id; }

}  // namespace

SteppedContact point_of(const SteppedStop& stop, double force) {
  SteppedContact point;
  point.id = static_cast<std::uint64_t>(stop.dof), point.a = stop.body, point.force = {force, 0, 0};
  point.joint = stop.joint, point.side = stop.sign, point.rests = stop.rests;
  return point;
}

void StepImpulses::find_points(double within, const std::vector<bool>& stays) {
  const Tree& tree = world_->tree();
  Workspace<double>& workspace = world_->workspace();
  near.clear(), hit_.clear();
  stepped_->add_near(within, near, stays);
  if (!any()) return;
  world_->accelerate(near, rows);
  for (NearStop& at : stops)
    at.acceleration = -at.stop.sign * workspace.a[static_cast<std::size_t>(tree.first_p(at.stop.body) + at.stop.dof)];
  const double* const q = world_->q();
  parts.begin(tree, many);
  parts.add_points(tree, q, workspace, near, rows, many);
  for (const NearStop& at : stops) {  // after the points of contacts
    parts.add_stop(tree, q, workspace, at.stop.body, at.stop.dof, -at.stop.sign, many);
    many.b[many.b.size() - 3] = at.velocity;
  }
  find_moments();
}

// Those of contacts with torsional or rolling friction, after the points of stops.
void StepImpulses::find_moments() {
  moments_.clear();
  for (std::size_t i = 0; i < near.size(); ++i) {
    const ContactLaw& law = pairs_->law(near[i].pair);
    if (near[i].cable >= 0 || !law.has_moments()) continue;
    const double length = (*pairs_)[near[i].pair].one->solid.reach;
    const std::size_t point =
        parts.add_moments(world_->tree(), world_->q(), world_->workspace(), near[i], rows.touches[i], length, many);
    many.points[point].pressed_by = static_cast<int>(i);
    many.points[point].torsion = law.torsional / length, many.points[point].friction = law.rolling / length;
    moments_.push_back({i, point, length});
  }
}

void StepImpulses::forget_bounces() {
  for (std::size_t i = 0; i < many.points.size(); ++i)
    if (many.points[i].restitution > 0) reached[i] = 0;
  share_times();
}

// Moments act from when their points of contact are reached.
void StepImpulses::share_times() {
  for (const Moments& moments : moments_) reached[moments.point] = reached[moments.contact];
}

const StepImpulses::Moments* StepImpulses::moments_of(std::size_t contact) const {
  const auto found = std::ranges::lower_bound(moments_, contact, {}, &Moments::contact);
  return found != moments_.end() && found->contact == contact ? &*found : nullptr;
}

void StepImpulses::find_stops(const std::vector<SteppedStop>& all, double h) {
  const Tree& tree = world_->tree();
  stops.clear();
  for (const SteppedStop& stop : all) {
    const double q = world_->state().q()[static_cast<std::size_t>(tree.first_q(stop.body) + stop.dof)];
    const double v = -stop.sign * world_->workspace().v[static_cast<std::size_t>(tree.first_p(stop.body) + stop.dof)];
    const double gap = stop.sign * (stop.limit - q);
    if (stop.touched || stop.rests || gap <= policy::step_touch + h * std::fabs(v)) stops.push_back({stop, gap, v, 0});
  }
}

// The forces of the last step, each at the nearest point of its pair: the features that touch may be others, but together they
// have the same load to carry. Their impulses are the first guess.
void StepImpulses::guess(const std::vector<SteppedContact>& before, double h) {
  carried_.assign(3 * many.points.size(), 0.0);
  const auto by_pair = [](const auto& x, const auto& y) { return x.pair < y.pair; };
  Contact key;
  for (const SteppedContact& known : before) {
    key.pair = known.pair;
    const auto [begin, end] = std::equal_range(near.begin(), near.end(), key, by_pair);
    if (begin == end) continue;
    const auto distance = [&](const Contact& c) {
      return norm(rows.touches[static_cast<std::size_t>(&c - near.data())].point - known.point);
    };
    auto nearest = begin;
    for (auto other = begin + 1; other != end; ++other)
      if (distance(*other) < distance(*nearest)) nearest = other;
    const auto i = static_cast<std::size_t>(nearest - near.begin());
    const double sign = nearest->a == known.a ? 1 : -1;
    for (std::size_t k = 0; k < 3; ++k) carried_[3 * i + k] += sign * dot(known.force, along(rows.touches[i], k));
    const Moments* const moments = moments_of(i);
    for (std::size_t k = 0; moments != nullptr && k < 3; ++k)
      carried_[3 * moments->point + k] += sign / moments->length * dot(known.moment, along(rows.touches[i], k));
  }
  for (std::size_t i = 0; i < near.size(); ++i) carried_[3 * i] = std::max(0.0, carried_[3 * i]);
  for (std::size_t i = 0; i < stops.size(); ++i) carried_[3 * (near.size() + i)] = stops[i].stop.force;
  many.r = carried_;
  for (double& r : many.r) r *= h;
}

// When a point was reached, and its restitution; true if it was hit, with more than a `slow` speed.
bool StepImpulses::approach(std::size_t i, double gap, double v, double a, double restitution, double slow, double h) {
  const double fast = std::max(0.25 * world_->gravity() * h, 1e-6);  // so that the time of touching is known
  const double tiny = policy::least_depth * (i < near.size() ? std::max(1.0, norm(rows.touches[i].point)) : 1.0);
  if (gap > tiny) {
    // It must not be reached in the next step by what others do to it in this one, unless it will hit anyway.
    const bool will_hit = v < -std::max(gap / h, policy::slow_impact);
    many.points[i].slack = will_hit ? HUGE_VAL : gap / h;
    if (will_hit) std::fill_n(many.r.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, 0.0);
    return false;
  }
  const double depth = std::max(0.0, -gap);
  // What lay on it falls with it: a heavy load would turn the smallest difference of these times into a motion.
  const bool lay_on_it = std::fabs(gap - (v - 0.5 * a * h) * h) < tiny;
  if (!lay_on_it && v < -fast) reached[i] = std::min(h, depth / -v);
  // The speed with which it was reached: the approach since then was accelerated, and so is the flight until the end.
  const double square = v < 0 ? v * v + 2 * a * depth : 0.0, speed = square > 0 ? std::sqrt(square) : 0.0;
  if (!(speed > std::max(slow, std::fabs(a) * h))) return false;
  const double since = std::min(h, 2 * depth / (speed - v)), leaves = restitution * speed + a * since;
  if (restitution > 0 && leaves > 0) {
    many.points[i].restitution = leaves / -v, reached[i] = since;
    many.points[i].carried = world_->gravity() * h;
  }
  return hit_[i] = true;
}

// The law at each point.
void StepImpulses::set_law(double h) {
  reached.assign(many.points.size(), 0.5 * h);  // what lies on something falls with it before the impulse
  hit_.assign(many.points.size(), false);
  // What contacts do in the step may accelerate bodies by as much as gravity, though they fall alike without these.
  const double by_gravity = world_->gravity() * h;
  const double slow = std::max(policy::slow_impact, policy::least_flight * by_gravity);
  for (std::size_t i = 0; i < near.size(); ++i) {
    const Contact& c = near[i];
    const ContactLaw& law = pairs_->law(c.pair);
    many.points[i].friction = law.friction;
    const double v = rows.velocity[3 * i], a = rows.acceleration[3 * i];
    if (!approach(i, rows.touches[i].gap, v, a, law.restitution, slow, h)) continue;
    for (const int body : {c.a, c.b})
      if (body >= 0) hits.push_back(body);
  }
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const NearStop& at = stops[i];
    const double gap = at.stop.touched ? std::min(at.gap, 0.0) : at.gap;
    const double rests = std::max(at.stop.rest_speed, by_gravity);
    approach(near.size() + i, gap, at.velocity, at.acceleration, at.stop.restitution, rests, h);
  }
  share_times();
}

void StepImpulses::solve(const std::vector<SteppedContact>& before, double h) {
  guess(before, h);
  set_law(h);
  many.solve();
  many.velocities(after);
}

bool StepImpulses::jammed() {
  constexpr double most = 0.01;  // of the fastest approach
  if (world_->tree().joints_with().motions.empty() && world_->tree().loops().motions == 0) return false;
  double fastest = 0, left = 0;
  for (std::size_t i = 0; i < near.size() + stops.size(); ++i) {
    fastest = std::max(fastest, std::fabs(many.b[3 * i]));
    if (many.points[i].slack < HUGE_VAL && many.block(i)[0] > 0) left = std::min(left, after[3 * i] + many.points[i].slack);
  }
  return !(-left <= most * fastest);
}

bool StepImpulses::struck(int joint, int dof, int sign) const {
  for (std::size_t i = 0; i < stops.size() && near.size() + i < hit_.size(); ++i) {
    const SteppedStop& stop = stops[i].stop;
    if (hit_[near.size() + i] && stop.joint == joint && stop.dof == dof && stop.sign == sign) return true;
  }
  return false;
}

// True if bodies lay on each other at the start of the step: what they approached each other with is what the step accelerated
// them by.
bool StepImpulses::lay_there(double v, double a, double h) const { return hits.empty() && std::fabs(v) <= 2 * h * std::fabs(a); }

// A gap of 1e-9 m that closes in a step of 1e-12 s takes an impulse that would be a huge force: such a step changes the mean by
// little.
void StepImpulses::add_means(const std::vector<SteppedContact>& before, double h, double usual,
                             std::vector<SteppedContact>& out) {
  const double over = std::max(h, usual), time_before = over - h;
  // What had no forces before, but lay there, had those of this step.
  const auto carry = [&](std::size_t i) {
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) carried_[k] = many.r[k] / h;
  };
  for (std::size_t i = 0; time_before > 0 && i < near.size(); ++i) {
    const auto same = [&](const SteppedContact& p) { return p.pair == near[i].pair; };
    if (lay_there(rows.velocity[3 * i], rows.acceleration[3 * i], h) && std::ranges::none_of(before, same)) carry(i);
  }
  for (std::size_t i = 0; time_before > 0 && i < stops.size(); ++i) {
    const NearStop& at = stops[i];
    if (lay_there(at.velocity, at.acceleration, h) && at.stop.force == 0) carry(near.size() + i);
  }
  const auto mean = [&](std::size_t row) { return (many.r[row] + time_before * carried_[row]) / over; };
  // What parts from a point has no force there but that of this step.
  const auto presses = [&](std::size_t i, double gap) {
    const bool parting = gap > policy::step_touch || after[3 * i] > policy::slow_impact;
    return mean(3 * i) > 0 && !(parting && !(many.r[3 * i] > 0));
  };
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const bool pressed = presses(near.size() + i, stops[i].gap);
    if (pressed || stops[i].stop.rests) out.push_back(point_of(stops[i].stop, pressed ? mean(3 * (near.size() + i)) : 0));
  }
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (!presses(i, rows.touches[i].gap)) continue;
    if (near[i].cable >= 0 && hit_[i]) continue;  // the impulse by which it becomes taut is no force
    // The point may have turned since the last step: in its cone nevertheless.
    const Vec3 force{mean(3 * i), mean(3 * i + 1), mean(3 * i + 2)};
    const double friction = std::hypot(force.y, force.z), limit = many.points[i].friction * force.x;
    const double part = friction > limit ? limit / friction : 1;
    out.push_back(point_at(i, {force.x, part * force.y, part * force.z}, after));
    add_moment(i, time_before, over, out.back());
  }
  std::ranges::stable_sort(out, earlier);
}

// The mean of the moments of a contact in this step and in the time before it, within the bounds that its force sets.
void StepImpulses::add_moment(std::size_t i, double before, double over, SteppedContact& point) const {
  const Moments* const moments = moments_of(i);
  if (moments == nullptr) return;
  const contact::ManyPoints::Point& law = many.points[moments->point];
  const double N = dot(point.force, point.normal);
  const auto mean = [&](std::size_t k) {
    return (many.r[3 * moments->point + k] + before * carried_[3 * moments->point + k]) / over;
  };
  const double rolls = std::hypot(mean(1), mean(2)), part = rolls > law.friction * N ? law.friction * N / rolls : 1;
  const Vec3 moment = {std::clamp(mean(0), -law.torsion * N, law.torsion * N), part * mean(1), part * mean(2)};
  const contact::Touch& touch = rows.touches[i];
  point.moment = moments->length * (moment.x * touch.normal + moment.y * touch.tangent[0] + moment.z * touch.tangent[1]);
}

// `force`: along the rows of the point, as its part of `velocity`.
SteppedContact StepImpulses::point_at(std::size_t i, const Vec3& force, const std::vector<double>& velocity) const {
  const Contact& c = near[i];
  const contact::Touch& touch = rows.touches[i];
  SteppedContact point{c.pair, c.id, c.a, c.b, touch.point, touch.normal, {}, {}, c.cable};
  point.force = force.x * touch.normal + force.y * touch.tangent[0] + force.z * touch.tangent[1];
  point.slip = velocity[3 * i + 1] * touch.tangent[0] + velocity[3 * i + 2] * touch.tangent[1];
  return point;
}

std::vector<SteppedContact> StepImpulses::forces_from_rest(const std::vector<SteppedContact>& before, double h) {
  std::vector<SteppedContact> found;
  if (!any()) return found;
  guess(before, h);
  for (std::size_t i = 0; i < near.size(); ++i) {
    many.points[i].friction = pairs_->law(near[i].pair).friction;
    many.b[3 * i] = std::max(0.0, many.b[3 * i]);
    const std::array<double, 9> block = many.block(i);
    for (std::size_t k = 0; k < 3; ++k)  // not where joints keep the bodies from moving
      if (block[4 * k] > 0) many.b[3 * i + k] += h * rows.acceleration[3 * i + k];
  }
  for (std::size_t i = 0; i < stops.size(); ++i) {
    double& b = many.b[3 * (near.size() + i)];
    b = std::max(0.0, b) + h * stops[i].acceleration;
  }
  for (const Moments& moments : moments_) {
    const Vec3 rate = spin_acceleration(world_->tree(), world_->q(), world_->workspace(), near[moments.contact]);
    for (std::size_t k = 0; k < 3; ++k)
      many.b[3 * moments.point + k] += h * moments.length * dot(rate, along(rows.touches[moments.contact], k));
  }
  many.solve(contact::ManyPoints::at_rest);
  for (std::size_t i = 0; i < near.size(); ++i) {
    const double* const r = &many.r[3 * i];
    if (!(r[0] > 0)) continue;
    found.push_back(point_at(i, {r[0] / h, r[1] / h, r[2] / h}, rows.velocity));
    add_moment(i, 0, h, found.back());
  }
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const double r = many.r[3 * (near.size() + i)];
    if (r > 0 || stops[i].stop.rests) found.push_back(point_of(stops[i].stop, r / h));
  }
  std::ranges::stable_sort(found, earlier);
  return found;
}

}  // namespace momentree
