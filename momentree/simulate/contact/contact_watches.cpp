#include <momentree/simulate/contact/contact_watches.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/simulate/contact/closed_contacts.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

// Changes its sign where contacts change.
struct ContactWatches::Located final : Quantity {
  enum class What : unsigned char {
    gap,     // of solids that are not in contact, or of further features of a pair that is: negative if they overlap (m)
    apart,   // positive where solids that passed through each other are apart
    hold,    // positive where the closed contacts would have to pull, or to exert more friction than they can
    slip,    // positive where a contact moves against the direction in which it slipped at the start of the step (m/s)
    leaves,  // positive where features in contact no longer face each other: a ball rolls off the edge of a face
  };
  What what;
  const ContactWatches* all;
  int number = 0;     // of the pair, or of the contact that slips
  double within = 0;  // of gaps (m)
  Vec3 direction{};
  Located(What what_, const ContactWatches& all_, int number_ = 0) : what(what_), all(&all_), number(number_) {}

  std::string_view key() const override { return "contact"; }
  const char* summary() const override { return "What changes at contacts"; }
  void arguments(const ArgumentVisitor&) override {}
  Dimension dimension() const override { return dimension::number; }
  std::optional<double> value(const World&, std::span<const Event>) const override {
    switch (what) {
      case What::gap: return all->pairs_->gap(number, within).value;
      case What::apart: return all->pairs_->are_apart(number) ? 1 : -1;
      case What::hold: return force_excess(*all->world_).excess;
      case What::slip:
        return -dot(slip_velocity(*all->world_, all->world_->closed()[static_cast<std::size_t>(number)]), direction);
      case What::leaves: return all->pairs_->still_face(number) ? -1 : 1;
    }
    return std::nullopt;
  }
  std::optional<double> rate(const World&) const override {
    return what == What::gap ? std::optional(all->pairs_->gap(number, within).rate) : std::nullopt;
  }
};

void ContactWatches::watch(const Located& what) {
  conditions_.emplace_back(std::make_shared<Located>(what), 0.0, what.what != Located::What::gap);
}

// Pairs that may come near within h seconds, and those that may come apart.
void ContactWatches::watch_pairs(double& h) {
  const double accelerated = world_->gravity() * h;  // what gravity may add to speeds within the step
  const auto limit = [&](const ContactPair& pair, double distance, double speed) {
    const double longest = pairs_->longest_step(pair, distance, speed, accelerated / h);
    if (h > longest) h = std::max(longest, 1e-9 * h);
  };
  for (const int i : pairs_->near(h, 0)) {
    const ContactPair& pair = (*pairs_)[i];
    const double speed = 2 * pairs_->speed_bound(pair) + 2 * accelerated, distance = pairs_->apart(pair);
    if (distance > speed * h || stepped_->handling(pair) == SteppedPairs::Handling::stepped) continue;
    if (pair.cable >= 0 && world_->is_closed(i, 0)) continue;
    limit(pair, distance, speed);
    Located gap(Located::What::gap, *this, i);
    gap.within = ContactPairs::looked_within(pair);
    watch(gap);
    rounding_.push_back(pairs_->rounding(pair));
  }
  for (const int i : world_->overlapping()) {
    const ContactPair& pair = (*pairs_)[i];
    limit(pair, 0, 2 * pairs_->speed_bound(pair) + 2 * accelerated);
    watch({Located::What::apart, *this, i});
  }
}

void ContactWatches::watch_closed() {
  const std::span<const Contact> closed = world_->closed();
  if (!closed.empty()) watch({Located::What::hold, *this});
  for (std::size_t i = 0; i < closed.size(); ++i) {
    Located turns(Located::What::slip, *this, static_cast<int>(i));
    turns.direction = slip.direction()[i];
    if (!(turns.direction == Vec3{})) watch(turns);
  }
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (i > 0 && closed[i].pair == closed[i - 1].pair) continue;
    const ContactPair& pair = (*pairs_)[closed[i].pair];
    if (pair.cable < 0 && !pair.other->plane) watch({Located::What::leaves, *this, closed[i].pair});  // a plane has no edges
  }
}

std::span<const Watch> ContactWatches::watches(double& h) {
  watches_.clear(), conditions_.clear(), rounding_.clear();
  started_ = world_->time();
  watch_pairs(h);
  slip.begin(h);
  watch_closed();
  slip.keep_directions(h);
  const World& world = world_->world();
  for (const Condition& condition : conditions_) {
    const double excess = condition.excess(world, {}).value_or(-1);
    Watch watch{&condition, 0};
    watch.offset = -policy::rounding;
    // Flights begin at the gap at which the last one ended: rounding must not end them at once. What could not be mended at the
    // start counts only if it grows.
    if (watches_.size() < rounding_.size() && excess > policy::rounding) watch.offset = -excess - rounding_[watches_.size()];
    if (excess > 10 * policy::rounding) watch.offset = condition.above ? -2 * excess : -excess - policy::rounding;
    watch.start = std::min(excess + watch.offset, 0.0);
    watch.start_rate = watch.rate(world);
    watch.precise = watch.start_rate.has_value();
    watches_.push_back(watch);
  }
  return watches_;
}

bool ContactWatches::must_resolve() {
  bool due = next_rest(*world_) <= world_->time();
  for (const Watch& watch : watches_)
    due = due || watch.condition->excess(world_->world(), {}).value_or(-1) + watch.offset > -2 * policy::touching_within;
  if (due) {
    note_ended_slip();
    return true;
  }
  const std::span<const Contact> closed = world_->closed();
  bool creeps = false, in_short_step = false;
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i].mode != Contact::Mode::slip) continue;
    const Vec3 v = slip_velocity(*world_, closed[i]);
    // Slip that came to an end just before a step did has no direction left that could be watched.
    if (norm(v) <= slowest_slip && dot(v, closed[i].direction) < 0) return true;
    if (i >= slip.speed().size() || !(std::max(norm(v), slip.speed()[i]) < policy::creeping)) continue;
    // It is about to stick or to slip anew; or it has just begun, and steps cannot follow it.
    creeps = creeps || norm(v) < 0.5 * slip.speed()[i];
    in_short_step = in_short_step || (world_->time() - started_) * slip.turning(i) < policy::creeping;
  }
  short_steps_ = in_short_step ? short_steps_ + 1 : 0;
  if (!creeps && short_steps_ < policy::most_short_steps) return false;
  slow_slip_ = policy::creeping, short_steps_ = 0;
  return true;
}

// Where slip ends, the error of the step is left of it, with any direction.
void ContactWatches::note_ended_slip() {
  const std::span<const Contact> closed = world_->closed();
  for (std::size_t i = 0; i < closed.size() && i < slip.speed().size(); ++i) {
    const Contact& c = closed[i];
    if (c.mode != Contact::Mode::slip || slip.speed()[i] < policy::creeping) continue;
    const Vec3 point = contact::touch(c.features, world_->place(c.a), world_->place(c.b)).point;
    double speeds = 0;
    for (const int body : {c.a, c.b}) {
      const contact::Place at = world_->place(body);
      speeds += norm(at.v + cross(at.w, point - at.r));
    }
    speeds += norm(c.belt_a) + norm(c.belt_b);
    const double noise = std::max(policy::creeping, 1e-8 * speeds);
    if (norm(slip_velocity(*world_, c)) < noise) slow_slip_ = std::max(slow_slip_, noise);
  }
}

}  // namespace momentree
