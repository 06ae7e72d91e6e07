#include <momentree/simulate/contact/contact_choice.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/simulate/contact/closed_contacts.hpp>
#include <momentree/simulate/contact/contact_policy.hpp>

namespace momentree {

namespace {

constexpr double little_less_friction = 1e-5, less_friction = 1e-3;  // parts by which friction is weakened
constexpr double motion_from_residual = 50;  // the motion that a solution may have because it is inexact, by its residual

// Contacts that stick at the limit of their friction because everything that they touch moves along. They may exert a little
// more, so that rounding does not decide whether they slip, and so that forces are found quickly. A positive keeps_direction
// without a direction marks them.
constexpr double more_at_limit = 1e-4, nearly_all = 0.99;
bool at_limit(const Contact& c) { return c.keeps_direction > 0 && c.direction == Vec3{}; }
void note_limit(Contact& c) { c.direction = {}, c.keeps_direction = 1e-12; }

bool keeps_direction(const Contact& c, const Vec3& v) { return c.keeps_direction > 0 && dot(v, c.direction) > 0; }

double largest(const std::vector<double>& all) {
  double most = 0;
  for (const double x : all) most = std::max(most, std::fabs(x));
  return most;
}

}  // namespace

double slow_approach(const ContactWorld& world, const SlowMotion& slow) {
  double fastest = 1;
  for (const BodyMotion& m : world.world().motions()) fastest = std::max(fastest, norm(m.linear));
  return std::max(slow.approach, policy::no_approach * fastest);
}

double friction_of(const ContactLaw& law, const Contact& contact) {
  if (contact.mode != Contact::Mode::stick) return law.friction;
  return at_limit(contact) ? (1 + more_at_limit) * law.static_friction : law.static_friction;
}

bool ContactChoice::jams(int pair) const { return std::ranges::find(jammed_, pair) != jammed_.end(); }

bool ContactChoice::choose(const std::vector<Contact>& touching, const SlowMotion& slow, std::vector<Contact>& closed) {
  closed.clear(), slow_ = slow;
  world_->accelerate(touching, rows_);
  const double little = 10 * slow_approach(*world_, slow);
  std::vector<Contact> staying;
  for (std::size_t i = 0; i < touching.size(); ++i) {
    // Flights too low to be resolved count as rest.
    const double size = pairs_->size((*pairs_)[touching[i].pair]);
    const double hidden = std::sqrt(2 * std::max(0.0, -rows_.acceleration[3 * i]) * policy::resolved_flight * size);
    if (rows_.velocity[3 * i] <= std::max(little, hidden)) staying.push_back(touching[i]);
  }
  if (staying.empty()) return true;
  world_->accelerate(staying, rows_);
  world_->find_mobility(staying, rows_);
  // A contact that begins to slip has the kinetic coefficient from then on: one that has been found to do so counts as slipping.
  for (bool begins = true; begins;) {
    closed.clear(), begins = false;
    const bool solved = solve(staying);
    bool rests = solved;
    for (std::size_t i = 0; i < staying.size(); ++i) rests = rests && system_.state(i) != contact::PointState::slip;
    rests = rests || can_rest(staying);
    if (!rests && !solved) return false;
    system_.velocities(after_);
    weakened_ = false;
    for (std::size_t i = 0; i < staying.size(); ++i) begins = choose(staying, i, rests, closed) || begins;
  }
  return true;
}

const std::vector<double>* ContactChoice::forces(const std::vector<Contact>& contacts, ContactRows rows, const SlowMotion& slow) {
  rows_ = std::move(rows), slow_ = slow;
  return solve(contacts) ? &system_.r : nullptr;
}

// The state of one of the contacts of which system_ has the forces, which is appended if it stays closed. True if it begins to
// slip, and was not known to have the kinetic coefficient: then it is noted in `staying`.
bool ContactChoice::choose(std::vector<Contact>& staying, std::size_t i, bool rests, std::vector<Contact>& closed) {
  const double noise = 1e-12 * largest(system_.r), inexact = motion_from_residual * system_.residual() * largest(system_.b);
  if (!(system_.r[3 * i] > noise)) return false;
  Contact c = staying[i];
  const contact::PointLaw& law = system_.laws[i];
  const ContactLaw& own = pairs_->law(c.pair);
  const bool was_at_limit = at_limit(c);
  bool begins = false;
  if (!law.slipping) c.keeps_direction = 0;
  if (law.slipping) {
    c.mode = Contact::Mode::slip;
    if (!keeps_direction(c, slip_at(i))) {
      c.direction = law.direction[0] * rows_.touches[i].tangent[0] + law.direction[1] * rows_.touches[i].tangent[1];
      c.keeps_direction = 0;
    }
  } else if (!(own.static_friction > 0)) {
    c.mode = Contact::Mode::smooth;
  } else if (!rests && system_.state(i) == contact::PointState::slip &&
             std::hypot(after_[3 * i + 1], after_[3 * i + 2]) > inexact) {
    if (!weakened_) weaken_friction();
    if (moves_along(staying, i)) {
      c.mode = Contact::Mode::stick;
      note_limit(c);
    } else {
      const double a1 = weaker_[3 * i + 1], a2 = weaker_[3 * i + 2], size = std::hypot(a1, a2);
      c.mode = Contact::Mode::slip;
      c.direction = (a1 / size) * rows_.touches[i].tangent[0] + (a2 / size) * rows_.touches[i].tangent[1];
      c.keeps_direction = (step_ > 0 ? step_ / 2 : policy::slow_slip) * turning_at(i);
      begins = staying[i].mode != Contact::Mode::slip && own.friction < own.static_friction;
      if (begins) staying[i].mode = Contact::Mode::slip;
    }
  } else {
    c.mode = Contact::Mode::stick;
    if (was_at_limit && uses_nearly_all(staying, i)) note_limit(c);
  }
  c.friction = friction_of(pairs_->law(c.pair), c);
  closed.push_back(c);
  return begins;
}

// turning() of contacts of which system_ has the forces.
double ContactChoice::turning_at(std::size_t i) const {
  const std::size_t n = system_.unknowns();
  double sum = 0;
  for (std::size_t j = 0; j < system_.points(); ++j) {
    double change[2] = {};
    for (std::size_t d = 0; d < 2; ++d)
      for (std::size_t e = 1; e < 3; ++e) change[d] += system_.A[(3 * i + 1 + d) * n + 3 * j + e] * system_.r[3 * j + e];
    sum += std::hypot(change[0], change[1]);
  }
  return sum;
}

// The slip of a contact that is placed (m/s, world axes).
Vec3 ContactChoice::slip_at(std::size_t i) const {
  return rows_.velocity[3 * i + 1] * rows_.touches[i].tangent[0] + rows_.velocity[3 * i + 2] * rows_.touches[i].tangent[1];
}

// Accelerations with a little less friction, in weaker_: where bodies begin to slip, their accelerations are nearly zero, and so
// are known less well than the directions in which they will slip.
void ContactChoice::weaken_friction() {
  weakened_ = true;
  weaker_ = after_, much_weaker_ = after_;
  if (!solve_weakened(less_friction, much_weaker_)) much_weaker_.clear();
  solve_weakened(little_less_friction, weaker_);
}

// True if the pair of contact i exerts nearly all friction that its points allow together.
bool ContactChoice::uses_nearly_all(const std::vector<Contact>& contacts, std::size_t i) const {
  double limit = 0;
  Vec3 friction{};
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (contacts[k].pair != contacts[i].pair || system_.laws[k].slipping) continue;
    const double side = contacts[k].a == contacts[i].a ? 1 : -1;
    limit += system_.laws[k].friction * system_.r[3 * k];
    for (std::size_t d = 1; d < 3; ++d) friction += side * system_.r[3 * k + d] * rows_.touches[k].tangent[d - 1];
  }
  return norm(friction) > nearly_all * limit;
}

// True if a pair that is at the limit of its friction stays together with less friction everywhere, although less friction of the
// pair alone would let it slip: both bodies are about to slip on a third one, with equal friction. Which of the limits is reached
// first is then known from rounding only, and so would be a direction of slip between the two.
bool ContactChoice::moves_along(const std::vector<Contact>& contacts, std::size_t i) const {
  constexpr double part = 0.1;
  if (much_weaker_.empty()) return false;
  const std::size_t n = system_.unknowns();
  double most = 0, alone = 0;
  for (std::size_t j = 0; j < contacts.size(); ++j) {
    if (contacts[j].pair != contacts[i].pair || !(system_.r[3 * j] > 0)) continue;
    most = std::max(most, std::hypot(much_weaker_[3 * j + 1], much_weaker_[3 * j + 2]));
    double change[2] = {};
    for (std::size_t k = 0; k < contacts.size(); ++k)
      for (std::size_t d = 0; contacts[k].pair == contacts[i].pair && d < 2; ++d)
        for (std::size_t e = 1; e < 3; ++e) change[d] += system_.A[(3 * j + 1 + d) * n + 3 * k + e] * system_.r[3 * k + e];
    alone = std::max(alone, less_friction * std::hypot(change[0], change[1]));
  }
  return most < part * alone;
}

// Tangential accelerations with friction that is less by that part, where they are larger. False: none were found.
bool ContactChoice::solve_weakened(double part, std::vector<double>& all) {
  const double less = 1 - part;
  const std::vector<double> solution = system_.r;
  const std::vector<contact::PointLaw> laws = system_.laws;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    system_.laws[i].friction *= less;
    for (std::size_t k = 1; k < 3; ++k) system_.r[3 * i + k] *= less;
  }
  const bool solved = system_.solve(1e-3 * part);
  if (solved) {
    std::vector<double> found;
    system_.velocities(found);
    for (std::size_t i = 0; i < laws.size(); ++i)
      if (std::hypot(found[3 * i + 1], found[3 * i + 2]) > std::hypot(after_[3 * i + 1], after_[3 * i + 2]))
        std::copy_n(found.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, all.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  system_.r = solution, system_.laws = laws;
  return solved;
}

// True if slip has a direction: not if it turns back soon after it has begun.
bool ContactChoice::slips(const Contact& c, const Vec3& v) const {
  constexpr double soon = 1e-3;
  if (!(pairs_->law(c.pair).friction > 0) || !(norm(v) > slow_.slip)) return false;
  return !(norm(v) < soon * c.keeps_direction) || dot(v, c.direction) > 0;
}

// True if all contacts that are placed can stay as they are. Their forces are then those of system_.
bool ContactChoice::can_rest(std::vector<Contact> contacts) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Contact& c = contacts[i];
    const ContactLaw& law = pairs_->law(c.pair);
    if (slips(c, slip_at(i))) return false;
    c.mode = law.static_friction > 0 ? Contact::Mode::stick : Contact::Mode::smooth;
    c.friction = friction_of(pairs_->law(c.pair), c);
  }
  world_->close(contacts);
  const bool rests = force_excess(*world_).excess <= 0;
  if (rests) {
    set_law(contacts);
    system_.r = world_->workspace().contacts->rows.forces;
  }
  world_->open();
  return rests;
}

// The law of contacts that are placed, with their accelerations and mobility.
void ContactChoice::set_law(const std::vector<Contact>& contacts) {
  system_.resize(contacts.size());
  system_.A = rows_.matrix(), system_.b = rows_.acceleration;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactLaw& own = pairs_->law(contacts[i].pair);
    contact::PointLaw& law = system_.laws[i];
    const contact::Touch& touch = rows_.touches[i];
    const Vec3 v = slip_at(i);
    law.slipping = slips(contacts[i], v);
    law.friction = law.slipping || contacts[i].mode == Contact::Mode::slip ? own.friction : own.static_friction;
    if (at_limit(contacts[i])) law.friction *= 1 + more_at_limit;
    if (!law.slipping) continue;
    const Vec3 s = keeps_direction(contacts[i], v) ? v + contacts[i].keeps_direction * contacts[i].direction : v;
    const double along_1 = dot(s, touch.tangent[0]), along_2 = dot(s, touch.tangent[1]), size = std::hypot(along_1, along_2);
    law.direction = {along_1 / size, along_2 / size};
  }
}

// The forces of contacts that are placed.
bool ContactChoice::solve(const std::vector<Contact>& contacts) {
  set_law(contacts);
  // Contacts that are nearly at rest contradict each other by what is left of their velocities. The result only tells states
  // apart.
  constexpr double acceptable = 1e-8;
  if (system_.solve(acceptable)) return true;
  // With many points that slip the solver may cycle. The velocities after a very short time obey a law without given directions.
  constexpr double soon = 1e-6;  // s
  for (std::size_t i = 0; i < system_.unknowns(); ++i) system_.b[i] = rows_.velocity[i] + soon * rows_.acceleration[i];
  for (std::size_t i = 0; i < contacts.size(); ++i) system_.b[3 * i] = soon * rows_.acceleration[3 * i];
  for (contact::PointLaw& law : system_.laws) law.slipping = false;
  std::fill(system_.r.begin(), system_.r.end(), 0.0);
  const bool solved = system_.solve(acceptable);
  for (double& x : system_.b) x /= soon;  // as accelerations and forces again
  for (double& x : system_.r) x /= soon;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double v1 = rows_.velocity[3 * i + 1], v2 = rows_.velocity[3 * i + 2], speed = std::hypot(v1, v2);
    if (!(speed > slow_.slip) || !(system_.laws[i].friction > 0)) continue;
    if (system_.state(i) == contact::PointState::stick) {  // no finite force keeps it slipping: it stops (Painlevé)
      jammed_.push_back(contacts[i].pair);
      continue;
    }
    system_.laws[i].slipping = true, system_.laws[i].direction = {v1 / speed, v2 / speed};
  }
  return solved;
}

}  // namespace momentree
