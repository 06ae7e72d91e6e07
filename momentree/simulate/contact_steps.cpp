#include <momentree/simulate/contact_steps.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>

#include <momentree/dynamics/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>

namespace momentree {

namespace {

bool earlier(const SteppedContact& x, const SteppedContact& y) { return x.pair != y.pair ? x.pair < y.pair : x.id < y.id; }

// Stops come before all points of contact.
auto* find_stop(auto& points, int joint, int dof, int sign) {
  for (auto& p : points) {
    if (p.joint < 0) break;
    if (p.joint == joint && p.id == static_cast<std::uint64_t>(dof) && p.side == sign) return &p;
  }
  return static_cast<decltype(points.data())>(nullptr);
}
SteppedContact point_of(const SteppedStop& stop, double force) {
  SteppedContact point;
  point.id = static_cast<std::uint64_t>(stop.dof), point.a = stop.body, point.force = {force, 0, 0};
  point.joint = stop.joint, point.side = stop.sign, point.rests = stop.rests;
  return point;
}

const Vec3& row_direction(const contact::Touch& touch, std::size_t k) { return k == 0 ? touch.normal : touch.tangent[k - 1]; }

}  // namespace

// The points of solids that overlap, or are nearer than `within`. The state has been evaluated without contacts.
void ContactSteps::find_points(double within) {
  const Tree& tree = world_->tree_;
  Workspace<double>& workspace = world_->workspace_;
  near_.clear(), hit_.clear();
  contacts_->add_near(within, near_, resting_.stays());
  if (near_.empty() && near_stops_.empty()) return;
  accelerate(tree, world_->state_, workspace);
  for (NearStop& near : near_stops_)
    near.acceleration = -near.stop.sign * workspace.a[static_cast<std::size_t>(tree.first_p(near.stop.body) + near.stop.dof)];
  locate_bodies(tree, world_->state_, workspace);
  place_contacts(tree, workspace, near_, rows_);
  const double* const q = world_->state_.q().data();
  find_contact_accelerations(tree, q, workspace, near_, rows_);
  parts_.begin(tree, many_);
  parts_.add_points(tree, q, workspace, near_, rows_, many_);
  for (const NearStop& near : near_stops_) {  // after the points of contacts
    parts_.add_stop(tree, q, workspace, near.stop.body, near.stop.dof, -near.stop.sign, many_);
    many_.b[many_.b.size() - 3] = near.velocity;
  }
  find_moments();
}

// Those of contacts with torsional or rolling friction, after the points of stops.
void ContactSteps::find_moments() {
  moments_.clear();
  for (std::size_t i = 0; i < near_.size(); ++i) {
    const ContactLaw& law = contacts_->law_of(near_[i].pair);
    if (near_[i].cable >= 0 || !law.has_moments()) continue;
    const double length = contacts_->reach_of(near_[i].pair);
    const std::size_t point = parts_.add_moments(world_->tree_, world_->state_.q().data(), world_->workspace_, near_[i],
                                                 rows_.touches[i], length, many_);
    many_.points[point].pressed_by = static_cast<int>(i);
    many_.points[point].torsion = law.torsional / length, many_.points[point].friction = law.rolling / length;
    moments_.push_back({i, point, length});
  }
}

// Moments act from when their points of contact are reached.
void ContactSteps::share_times() {
  for (const Moments& moments : moments_) reached_[moments.point] = reached_[moments.contact];
}

// Those that joints have reached, or are nearer to than they move in h seconds.
void ContactSteps::find_stops(double h) {
  const Tree& tree = world_->tree_;
  near_stops_.clear();
  for (const SteppedStop& stop : stops_) {
    const double q = world_->state_.q()[static_cast<std::size_t>(tree.first_q(stop.body) + stop.dof)];
    const double v = -stop.sign * world_->workspace_.v[static_cast<std::size_t>(tree.first_p(stop.body) + stop.dof)];
    const double gap = stop.sign * (stop.limit - q);
    if (stop.touched || stop.rests || gap <= policy::step_touch + h * std::fabs(v)) near_stops_.push_back({stop, gap, v, 0});
  }
}

// The forces of the last step, each at the nearest point of its pair: the features that touch may be others, but together they
// have the same load to carry. Their impulses are the first guess.
void ContactSteps::guess(double h) {
  carried_.assign(3 * many_.points.size(), 0.0);
  const auto by_pair = [](const auto& x, const auto& y) { return x.pair < y.pair; };
  Contact key;
  for (const SteppedContact& known : points_) {
    key.pair = known.pair;
    const auto [begin, end] = std::equal_range(near_.begin(), near_.end(), key, by_pair);
    if (begin == end) continue;
    const auto distance = [&](const Contact& c) {
      return norm(rows_.touches[static_cast<std::size_t>(&c - near_.data())].point - known.point);
    };
    auto nearest = begin;
    for (auto other = begin + 1; other != end; ++other)
      if (distance(*other) < distance(*nearest)) nearest = other;
    const auto i = static_cast<std::size_t>(nearest - near_.begin());
    const double sign = nearest->a == known.a ? 1 : -1;
    for (std::size_t k = 0; k < 3; ++k) carried_[3 * i + k] += sign * dot(known.force, row_direction(rows_.touches[i], k));
    const Moments* const moments = moments_of(i);
    for (std::size_t k = 0; moments != nullptr && k < 3; ++k)
      carried_[3 * moments->point + k] += sign / moments->length * dot(known.moment, row_direction(rows_.touches[i], k));
  }
  for (std::size_t i = 0; i < near_.size(); ++i) carried_[3 * i] = std::max(0.0, carried_[3 * i]);
  for (std::size_t i = 0; i < near_stops_.size(); ++i) carried_[3 * (near_.size() + i)] = near_stops_[i].stop.force;
  many_.r = carried_;
  for (double& r : many_.r) r *= h;
}

// When a point was reached, and its restitution; true if it was hit, with more than a `slow` speed.
bool ContactSteps::approach(std::size_t i, double gap, double v, double a, double restitution, double slow, double h) {
  const double fast = std::max(0.25 * norm(world_->model_.gravity()) * h, 1e-6);  // so that the time of touching is known
  const double tiny = policy::least_depth * (i < near_.size() ? std::max(1.0, norm(rows_.touches[i].point)) : 1.0);
  if (gap > tiny) {
    // It must not be reached in the next step by what others do to it in this one, unless it will hit anyway.
    const bool will_hit = v < -std::max(gap / h, policy::slow_impact);
    many_.points[i].slack = will_hit ? HUGE_VAL : gap / h;
    if (will_hit) std::fill_n(many_.r.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, 0.0);
    return false;
  }
  const double depth = std::max(0.0, -gap);
  // What lay on it falls with it: a heavy load would turn the smallest difference of these times into a motion.
  const bool lay_on_it = std::fabs(gap - (v - 0.5 * a * h) * h) < tiny;
  if (!lay_on_it && v < -fast) reached_[i] = std::min(h, depth / -v);
  // The speed with which it was reached: the approach since then was accelerated, and so is the flight until the end.
  const double square = v < 0 ? v * v + 2 * a * depth : 0.0, speed = square > 0 ? std::sqrt(square) : 0.0;
  if (!(speed > std::max(slow, std::fabs(a) * h))) return false;
  const double since = std::min(h, 2 * depth / (speed - v)), leaves = restitution * speed + a * since;
  if (restitution > 0 && leaves > 0) {
    many_.points[i].restitution = leaves / -v, reached_[i] = since;
    many_.points[i].carried = norm(world_->model_.gravity()) * h;
  }
  return hit_[i] = true;
}

// The law at each point, and a first guess.
void ContactSteps::set_law(double h) {
  reached_.assign(many_.points.size(), 0.5 * h);  // what lies on something falls with it before the impulse
  hit_.assign(many_.points.size(), false);
  guess(h);
  // What contacts do in the step may accelerate bodies by as much as gravity, though they fall alike without these.
  const double by_gravity = norm(world_->model_.gravity()) * h, slow = std::max(policy::slow_impact, by_gravity);
  for (std::size_t i = 0; i < near_.size(); ++i) {
    const Contact& c = near_[i];
    const ContactLaw& law = contacts_->law_of(c.pair);
    many_.points[i].friction = law.friction;
    const double v = rows_.velocity[3 * i], a = rows_.acceleration[3 * i];
    if (!approach(i, rows_.touches[i].gap, v, a, law.restitution, slow, h)) continue;
    for (const int body : {c.a, c.b})
      if (body >= 0) hits_.push_back(body);
  }
  for (std::size_t i = 0; i < near_stops_.size(); ++i) {
    const NearStop& at = near_stops_[i];
    const double gap = at.stop.touched ? std::min(at.gap, 0.0) : at.gap;
    const double rests = std::max(at.stop.rest_speed, by_gravity);
    approach(near_.size() + i, gap, at.velocity, at.acceleration, at.stop.restitution, rests, h);
  }
  share_times();
}

void ContactSteps::solve(double h) {
  set_law(h);
  many_.solve();
  many_.velocities(after_);
}

// True if prescribed motions press together what contacts and stops keep apart. Stops then give way, which a warning says.
bool ContactSteps::jammed() {
  constexpr double most = 0.01;  // of the fastest approach
  if (world_->tree_.driven_joints().empty() && world_->tree_.loop_motions() == 0) return false;
  double fastest = 0, left = 0;
  for (std::size_t i = 0; i < near_.size() + near_stops_.size(); ++i) {
    fastest = std::max(fastest, std::fabs(many_.b[3 * i]));
    if (many_.points[i].slack < HUGE_VAL && many_.block(i)[0] > 0) left = std::min(left, after_[3 * i] + many_.points[i].slack);
  }
  return !(-left <= most * fastest);
}

double ContactSteps::energy() const {
  const Totals now = world_->totals();
  return now.kinetic + now.potential;
}

// Applies the impulses: to the velocities, and to the coordinates for the time since the points were reached. What is left of
// overlaps is removed. The energy that each of this takes or brings is measured.
void ContactSteps::move(State& state, EnergyLedger& ledger) {
  const Tree& tree = world_->tree_;
  const bool driven = !tree.driven_joints().empty() || (!near_.empty() && rows_.has_belts());
  const double before = energy(), kinetic = driven ? world_->totals().kinetic : 0.0;
  {
    const State::Edit edit = state.edit();
    parts_.add_to(tree, many_, many_.change(), edit.u.data());
  }
  double by_drives = 0;
  if (driven) {
    // Prescribed motions and belts take up impulses without moving differently: what the other bodies gain is their work.
    by_drives = world_->totals().kinetic - kinetic;
    for (std::size_t row = 0; row < many_.r.size(); ++row) by_drives -= 0.5 * many_.r[row] * (many_.b[row] + after_[row]);
  }
  contact::LinksMotion& moved = many_.displacement(reached_);
  displace(state, moved);
  const double struck = energy();
  ledger.work += by_drives, ledger.impacts += before + by_drives - struck;
  double deepest = 0, size = 1;
  for (std::size_t i = 0; i < near_.size(); ++i) {
    gaps_[i] = rows_.touches[i].gap + many_.along_normal(i, moved);
    deepest = std::max(deepest, -gaps_[i]), size = std::max(size, norm(rows_.touches[i].point));
  }
  for (std::size_t i = 0; i < near_stops_.size(); ++i) {
    const SteppedStop& stop = near_stops_[i].stop;
    const double q = state.q()[static_cast<std::size_t>(tree.first_q(stop.body) + stop.dof)];
    gaps_[near_.size() + i] = stop.sign * (stop.limit - q);
    deepest = std::max(deepest, -gaps_[near_.size() + i]);
  }
  if (!(deepest > policy::least_depth * size)) return;
  contact::LinksMotion& apart = many_.separate(gaps_, pushes_);
  if (deepest > left_by_steps) note_overlaps(apart);
  displace(state, apart);
  ledger.projection += energy() - struck;
}

// Where nothing gives way, such as below a body whose motion is prescribed, overlaps are left.
void ContactSteps::note_overlaps(contact::LinksMotion& moved) {
  for (std::size_t i = 0; i < near_.size(); ++i) {
    const double depth = -gaps_[i] - many_.along_normal(i, moved);
    if (depth > left_by_steps) overlapping_.emplace_back(near_[i].pair, depth);
  }
}

// Bodies that lie on something fall with it in each step, and are moved back: dampers and efforts do nothing in that, as a whole.
// The velocity of such a body grows from zero in the step. The work of efforts is then half of the power at the end times h, and
// what dampers take, which grows with its square, a third. Bodies that bounce do not rest. What prescribed motions do is in
// move().
void ContactSteps::take_back_work(double t, EnergyLedger& ledger, double h) {
  const Tree& tree = world_->tree_;
  if ((free_power_.dissipated == 0 && free_power_.work == 0) || !tree.driven_joints().empty() || tree.loop_motions() > 0) return;
  for (std::size_t i = 0; i < many_.points.size(); ++i)
    if (many_.points[i].restitution > 0) reached_[i] = 0;
  share_times();
  packed_.assign(static_cast<std::size_t>(tree.nv()), 0.0);
  parts_.add_to(tree, many_, many_.displacement(reached_), packed_.data());
  for (std::size_t i = 0; i < packed_.size(); ++i) packed_[i] = free_u_[i] + 2 / h * packed_[i];
  (*evaluate_)(t, free_q_.data(), packed_.data());
  const Power& there = world_->workspace_.power;
  const double work = h / 2 * (there.work - free_power_.work), dissipated = h / 3 * (there.dissipated - free_power_.dissipated);
  ledger.work += work, ledger.dissipated += dissipated, ledger.impacts += work - dissipated;
}

void ContactSteps::displace(State& state, contact::LinksMotion& by) {
  const Tree& tree = world_->tree_;
  packed_.assign(static_cast<std::size_t>(tree.nv()), 0.0);
  parts_.add_to(tree, many_, by, packed_.data());
  const double t = state.time();
  const State::Edit edit = state.edit();
  displacement_.apply(tree, t, packed_.data(), edit.q.data(), edit.u.data(), world_->workspace_);
  double ignored = 0;
  if (tree.has_loops()) static_cast<void>(evaluate_->close(t, edit.q.data(), edit.u.data(), ignored));
}

// True if bodies lay on each other at the start of the step: what they approached each other with is what the step accelerated
// them by.
bool ContactSteps::lay_there(double v, double a, double h) const { return hits_.empty() && std::fabs(v) <= 2 * h * std::fabs(a); }

// Except those of bodies that rest.
void ContactSteps::forget_points() {
  std::erase_if(points_, [this](const SteppedContact& point) {
    return point.joint >= 0 || !(resting_.stays(point.a) || resting_.stays(point.b));
  });
  for (const SteppedContact& point : points_) touching_.emplace_back(point.a, point.b);
}

// The points for the next step, and for evaluations of the state until then. A gap of 1e-9 m that closes in a step of 1e-12 s
// takes an impulse that would be a huge force: such a step changes the mean by little.
void ContactSteps::remember(double h) {
  const double over = std::max(h, usual_step_), before = over - h;
  // What had no forces before, but lay there, had those of this step.
  const auto carry = [&](std::size_t i) {
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) carried_[k] = many_.r[k] / h;
  };
  for (std::size_t i = 0; before > 0 && i < near_.size(); ++i) {
    const auto same = [&](const SteppedContact& p) { return p.pair == near_[i].pair; };
    if (lay_there(rows_.velocity[3 * i], rows_.acceleration[3 * i], h) && std::ranges::none_of(points_, same)) carry(i);
  }
  for (std::size_t i = 0; before > 0 && i < near_stops_.size(); ++i) {
    const NearStop& at = near_stops_[i];
    if (lay_there(at.velocity, at.acceleration, h) && at.stop.force == 0) carry(near_.size() + i);
  }
  forget_points();
  for (std::size_t i = 0; i < near_stops_.size(); ++i) {
    const std::size_t row = 3 * (near_.size() + i);
    const double force = (many_.r[row] + before * carried_[row]) / over;
    const bool parts = near_stops_[i].gap > policy::step_touch || after_[row] > policy::slow_impact;
    const bool presses = force > 0 && !(parts && !(many_.r[row] > 0));
    if (presses || near_stops_[i].stop.rests) points_.push_back(point_of(near_stops_[i].stop, presses ? force : 0));
  }
  for (std::size_t i = 0; i < near_.size(); ++i) {
    const auto force = [&](std::size_t k) { return (many_.r[3 * i + k] + before * carried_[3 * i + k]) / over; };
    const bool parts = rows_.touches[i].gap > policy::step_touch || after_[3 * i] > policy::slow_impact;
    if (!(force(0) > 0) || (parts && !(many_.r[3 * i] > 0))) continue;
    if (near_[i].cable >= 0 && hit_[i]) continue;  // the impulse by which it becomes taut is no force
    // The point may have turned since the last step: in its cone nevertheless.
    const double friction = std::hypot(force(1), force(2)), limit = many_.points[i].friction * force(0);
    const double part = friction > limit ? limit / friction : 1;
    points_.push_back(point_at(i, {force(0), part * force(1), part * force(2)}, after_));
    add_moment(i, before, over, points_.back());
  }
  std::stable_sort(points_.begin(), points_.end(), earlier);
}

// The mean of the moments of a contact in this step and in the time before it, within the bounds that its force sets.
void ContactSteps::add_moment(std::size_t i, double before, double over, SteppedContact& point) const {
  const Moments* const moments = moments_of(i);
  if (moments == nullptr) return;
  const contact::ManyPoints::Point& law = many_.points[moments->point];
  const double N = dot(point.force, point.normal);
  const auto mean = [&](std::size_t k) {
    return (many_.r[3 * moments->point + k] + before * carried_[3 * moments->point + k]) / over;
  };
  const double rolls = std::hypot(mean(1), mean(2)), part = rolls > law.friction * N ? law.friction * N / rolls : 1;
  const Vec3 along = {std::clamp(mean(0), -law.torsion * N, law.torsion * N), part * mean(1), part * mean(2)};
  const contact::Touch& touch = rows_.touches[i];
  point.moment = moments->length * (along.x * touch.normal + along.y * touch.tangent[0] + along.z * touch.tangent[1]);
}

// `force`: along the rows of the point, as its part of `velocity`.
SteppedContact ContactSteps::point_at(std::size_t i, const Vec3& force, const std::vector<double>& velocity) const {
  const Contact& c = near_[i];
  const contact::Touch& touch = rows_.touches[i];
  SteppedContact point{c.pair, c.id, c.a, c.b, touch.point, touch.normal, {}, {}, c.cable};
  point.force = force.x * touch.normal + force.y * touch.tangent[0] + force.z * touch.tangent[1];
  point.slip = velocity[3 * i + 1] * touch.tangent[0] + velocity[3 * i + 2] * touch.tangent[1];
  return point;
}

// The impulses of a step of the usual length that begins with the present accelerations, as forces.
void ContactSteps::find_forces() {
  const double h = usual_step_;
  release();
  (*evaluate_)(world_->state_);
  find_stops(0);
  find_points(policy::step_touch);
  std::vector<SteppedContact> found;
  if (!near_.empty() || !near_stops_.empty()) {
    guess(h);
    for (std::size_t i = 0; i < near_.size(); ++i) {
      many_.points[i].friction = contacts_->law_of(near_[i].pair).friction;
      many_.b[3 * i] = std::max(0.0, many_.b[3 * i]);
      const std::array<double, 9> block = many_.block(i);
      for (std::size_t k = 0; k < 3; ++k)  // not where joints keep the bodies from moving
        if (block[4 * k] > 0) many_.b[3 * i + k] += h * rows_.acceleration[3 * i + k];
    }
    for (std::size_t i = 0; i < near_stops_.size(); ++i) {
      double& b = many_.b[3 * (near_.size() + i)];
      b = std::max(0.0, b) + h * near_stops_[i].acceleration;
    }
    for (const Moments& moments : moments_) {
      const Vec3 rate = spin_acceleration(world_->tree_, world_->state_.q().data(), world_->workspace_, near_[moments.contact]);
      for (std::size_t k = 0; k < 3; ++k)
        many_.b[3 * moments.point + k] += h * moments.length * dot(rate, row_direction(rows_.touches[moments.contact], k));
    }
    many_.solve(contact::ManyPoints::at_rest);
    for (std::size_t i = 0; i < near_.size(); ++i) {
      const double* const r = &many_.r[3 * i];
      if (!(r[0] > 0)) continue;
      found.push_back(point_at(i, {r[0] / h, r[1] / h, r[2] / h}, rows_.velocity));
      add_moment(i, 0, h, found.back());
    }
    for (std::size_t i = 0; i < near_stops_.size(); ++i) {
      const double r = many_.r[3 * (near_.size() + i)];
      if (r > 0 || near_stops_[i].stop.rests) found.push_back(point_of(near_stops_[i].stop, r / h));
    }
    std::stable_sort(found.begin(), found.end(), earlier);
  }
  if (!points_.empty()) return set_points(std::move(found));
  std::ranges::copy_if(found, std::back_inserter(points_), [](const SteppedContact& point) { return point.joint >= 0; });
  hold(found);
}

void ContactSteps::hold(const std::vector<SteppedContact>& points) {
  has_forces_ = true;
  std::vector<HeldForce>& held = held_forces(world_->workspace_);
  held.clear();
  for (const SteppedContact& point : points)
    if (point.joint < 0)
      held.push_back({point.a, point.b, point.point, point.force, point.normal, point.slip, point.cable, point.moment});
  show_stops(points);
  static_cast<void>(world_->state_.edit());  // its evaluation is without them
}

void ContactSteps::show_stops(const std::vector<SteppedContact>& points) {
  std::vector<HeldStop>& held = contact_memory(world_->workspace_).stops;
  held.clear();
  for (const SteppedContact& point : points)
    if (point.joint >= 0)
      held.push_back({point.joint, static_cast<int>(point.id), has_forces_ ? -point.side * point.force.x : 0, point.rests});
}

const SteppedContact* ContactSteps::at_stop(int joint, int dof, int sign) const { return find_stop(points_, joint, dof, sign); }

bool ContactSteps::struck(int joint, int dof, int sign) const {
  for (std::size_t i = 0; near_.size() + i < hit_.size(); ++i) {
    const SteppedStop& stop = near_stops_[i].stop;
    if (hit_[near_.size() + i] && stop.joint == joint && stop.dof == dof && stop.sign == sign) return true;
  }
  return false;
}

void ContactSteps::set_resting(const SteppedStop& stop) {
  if (SteppedContact* const known = find_stop(points_, stop.joint, stop.dof, stop.sign))
    known->rests = stop.rests;
  else
    points_.insert(points_.begin(), point_of(stop, 0));
  show_stops(points_);
}

void ContactSteps::set_points(std::vector<SteppedContact> points, bool released) {
  points_ = std::move(points), released_ = released;
  if (released) return release();
  hold(points_);
}

void ContactSteps::release() {
  released_ = true, has_forces_ = false, resting_.forget();
  held_forces(world_->workspace_).clear();
  show_stops(points_);
  static_cast<void>(world_->state_.edit());
}

// How near each other points are that count in a step of h seconds (m): also those that others push towards each other in it, and
// those with forces that a short step may not need.
double ContactSteps::reach(double h) const {
  const double gravity = norm(world_->model_.gravity()), speed = contacts_->fastest() + gravity * h;
  return std::max({h * speed, gravity * usual_step_ * usual_step_, policy::step_touch});
}

// Among those that find_near() found.
bool ContactSteps::is_near(const SteppedContact& point) const {
  return point.joint >= 0 || std::ranges::any_of(near_, [&](const Contact& c) { return c.pair == point.pair; });
}

bool ContactSteps::still_near() {
  find_near();
  return std::ranges::all_of(points_, [this](const SteppedContact& point) { return is_near(point); });
}

void ContactSteps::forget_parted() {
  if (points_.empty()) return;
  find_near();
  std::vector<SteppedContact> near = points_;
  if (std::erase_if(near, [this](const SteppedContact& point) { return !is_near(point); }) > 0)
    set_points(std::move(near), released_);
}

void ContactSteps::begin_step() {
  const std::span<const SteppedContact> points(points_.data(), released_ ? 0 : points_.size());
  resting_.begin_step(world_->tree_, world_->state_, world_->workspace_, points, usual_step_);
}

void ContactSteps::apply(State& state, EnergyLedger& ledger, double h) {
  release();
  (*evaluate_)(state);
  free_power_ = world_->workspace_.power;
  const double within = reach(h);
  if (resting_.put_back(world_->tree_, state, *contacts_, within, points_)) (*evaluate_)(state);
  find_stops(h);
  find_points(within);
  hits_.clear(), touching_.clear(), overlapping_.clear();
  for (;;) {
    if (near_.empty() && near_stops_.empty()) {
      forget_points(), released_ = false;
      return hold(points_);
    }
    solve(h);
    if (near_stops_.empty() || !jammed()) break;
    near_stops_.clear(), hits_.clear();
    (*evaluate_)(state);
    find_points(within);
  }
  free_q_.assign(state.q().begin(), state.q().end()), free_u_.assign(state.u().begin(), state.u().end());
  for (std::size_t i = 0; i < near_.size(); ++i)
    if (!(rows_.touches[i].gap > policy::step_touch)) touching_.emplace_back(near_[i].a, near_[i].b);
  gaps_.assign(many_.points.size(), HUGE_VAL);  // moments have none
  move(state, ledger);
  take_back_work(state.time(), ledger, h);
  remember(h), released_ = false;
  resting_.come_to_rest(world_->tree_, state, points_);
  hold(points_);
}

}  // namespace momentree
