#include <momentree/simulate/events/stops.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/simulate/arguments.hpp>
#include <momentree/simulate/stepping/contact_steps.hpp>

namespace momentree {

namespace {

// After this many impacts at one instant without coming to rest, the next step continues from the resulting state.
constexpr int most_impacts = 1000;

const Joint& joint_of(const Tree& tree, int joint) {
  return is_loop({joint}) ? tree.loops().find({joint})->joint : tree.joint(tree.carrier(joint));
}

}  // namespace

bool Stops::any() {
  if (revision_ != world_->tree().revision()) find();
  return !sides_.empty();
}

void Stops::find() {
  revision_ = world_->tree().revision();
  const std::vector<DeeperStop> before = deeper();
  sides_.clear();
  const Tree& tree = world_->tree();
  for (const int b : tree.order()) {
    const JointParameters* p = tree.parameters(b);
    if (p == nullptr || !p->limits.hard()) continue;
    for (int i = 0; i < info(tree.joint(b).kind).nv; ++i) {
      const double e = p->limits.restitution_of(i), rest = p->limits.rest_speed;
      if (std::isfinite(p->limits.upper_of(i))) sides_.push_back({tree.joint_of(b), i, 1, p->limits.upper_of(i), e, rest});
      if (std::isfinite(p->limits.lower_of(i))) sides_.push_back({tree.joint_of(b), i, -1, p->limits.lower_of(i), e, rest});
    }
  }
  for (const Loop& loop : tree.loops()) {
    const JointLimits& limits = loop.parameters.limits;
    if (!limits.hard()) continue;
    for (int i = 0; i < info(loop.joint.kind).nv; ++i) {
      const double e = limits.restitution_of(i), rest = limits.rest_speed;
      if (std::isfinite(limits.upper_of(i))) sides_.push_back({loop.id().index, i, 1, limits.upper_of(i), e, rest});
      if (std::isfinite(limits.lower_of(i))) sides_.push_back({loop.id().index, i, -1, limits.lower_of(i), e, rest});
    }
  }
  std::stable_sort(sides_.begin(), sides_.end(), [](const Side& a, const Side& b) { return a.joint < b.joint; });
  make_deeper(before);
  world_->edit().forget_active_limits();
}

std::vector<DeeperStop> Stops::deeper() const {
  std::vector<DeeperStop> all;
  for (const Side& s : sides_)
    if (s.edge > -HUGE_VAL) all.push_back({s.joint, s.dof, s.sign, s.edge});
  return all;
}

void Stops::make_deeper(std::span<const DeeperStop> stops) {
  for (const DeeperStop& deeper : stops)
    for (Side& s : sides_)
      if (s.joint == deeper.joint && s.dof == deeper.dof && s.sign == deeper.sign) s.edge = deeper.edge;
}

void Stops::set_deeper(std::span<const DeeperStop> stops) {
  static_cast<void>(any());
  for (Side& s : sides_) s.edge = -HUGE_VAL;
  make_deeper(stops);
}

double Stops::coordinate(const Side& s) const {
  if (is_loop({s.joint})) return world_->joint({s.joint}).q[static_cast<std::size_t>(s.dof)];
  return state().q()[static_cast<std::size_t>(world_->tree().first_q(world_->tree().carrier(s.joint)) + s.dof)];
}
// The coordinate of a loop joint follows from the poses of its bodies, and is not exact on a stop.
double Stops::rounding(const Side& s) { return is_loop({s.joint}) ? 1e-12 * (1 + std::fabs(s.limit)) : 0; }
double Stops::speed(const Side& s) const {
  if (is_loop({s.joint})) return s.sign * world_->joint({s.joint}).v[static_cast<std::size_t>(s.dof)];
  return s.sign * workspace().v[static_cast<std::size_t>(world_->tree().first_p(world_->tree().carrier(s.joint)) + s.dof)];
}
double Stops::acceleration(const Side& s) const {
  if (is_loop({s.joint}))
    return s.sign *
           loop_acceleration(world_->tree(), state().q().data(), workspace(), world_->tree().loops().place({s.joint}), s.dof);
  return s.sign * workspace().a[static_cast<std::size_t>(world_->tree().first_p(world_->tree().carrier(s.joint)) + s.dof)];
}
bool Stops::locked(const Side& s) const { return (joint_of(world_->tree(), s.joint).locked >> s.dof & 1u) != 0; }
bool Stops::is_stepped(const Side& s) const {
  return steps_ != nullptr && !is_loop({s.joint}) && steps_->steps(world_->tree().carrier(s.joint));
}
bool Stops::stands(const Side& s) const {
  constexpr double touching = 1e-6;  // of 1 + |limit|: in rad or m
  return s.sign * (s.limit - coordinate(s)) <= touching * (1 + std::fabs(s.limit)) && speed(s) >= -s.rest_speed;
}
SteppedStop Stops::as_stop(const Side& s) const {
  SteppedStop stop{s.joint, world_->tree().carrier(s.joint), s.dof, s.sign, s.limit, s.restitution, s.rest_speed, stands(s)};
  if (const SteppedContact* const known = steps_->points.at_stop(s.joint, s.dof, s.sign))
    stop.rests = known->rests, stop.force = known->force.x;
  return stop;
}
bool Stops::holds(const Side& s) const { return locked(s) && world_->constraints().held(s.joint, s.dof) == s.sign; }

// The stop exerts the total force along the locked DoF, Eᵀ Tr, minus the force of its spring and its drive.
double Stops::pull(const Side& s) const {
  const Tree& tree = world_->tree();
  if (is_loop({s.joint})) {
    double size = 0;
    const int place = tree.loops().place({s.joint});
    const double stop = loop_holding_force(tree, world_->time(), workspace(), place, s.dof, size);
    return s.sign * stop - 1e-12 * size;
  }
  const int b = tree.carrier(s.joint);
  double force[6] = {}, passive[6] = {};
  project(tree, b, joint_state(tree, state(), workspace(), b), transmitted_wrench(tree, workspace(), b), force);
  unlocked_forces(tree, world_->time(), state().q().data(), workspace(), b, passive);
  if (tree.has_loops()) passive[0] += coupling_effort(tree, workspace(), b);
  const double stop = force[s.dof] - passive[s.dof];
  const double noise = 1e-12 * (std::fabs(force[s.dof]) + std::fabs(passive[s.dof]));
  return s.sign * stop - noise;
}

// The joint's own rest speed; larger if the impact is so slow, or the joint pressed so hard against the stop, that the next
// flight would be too short or too low to be distinguished from rounding. Bouncing therefore always ends.
double Stops::rest_speed(const Side& s) const {
  const double a = acceleration(s);
  if (!(a > 0)) return s.rest_speed;
  constexpr double lowest_flight = 1e-14;  // of 1 + |limit|: in rad or m
  return std::max({s.rest_speed, 8 * tolerance_ * a, std::sqrt(2 * a * lowest_flight * (1 + std::fabs(s.limit)))});
}

Event Stops::begin_event(const Side& s, LimitEvent deed) const {
  static constexpr const char* verbs[] = {"hit", "rest", "leave"};
  Event event;
  event.time = world_->time();
  event.name = "stop";
  event.mechanisms_before = event.mechanisms_after = world_->mechanism_names();
  event.before = event.after = world_->totals();
  const std::string joint(world_->joint_name({s.joint}));
  const int nv = info(joint_of(world_->tree(), s.joint).kind).nv;
  const std::string side = (nv > 1 ? " [" + std::to_string(s.dof) + "]" : std::string()) + (s.sign > 0 ? " upper" : " lower");
  event.actions = {{verbs[static_cast<int>(deed)], joint + side, joint, {}, {}, {}}};
  return event;
}

void Stops::act(std::vector<Event>& events, const Side& s, LimitEvent deed, double restitution) {
  TopologyEditor editor(*world_);
  Event event = begin_event(s, deed);
  editor.begin(event, "");
  switch (deed) {
    case LimitEvent::hit: editor.apply_restitution(s.joint, s.dof, restitution); break;
    case LimitEvent::rest: editor.engage_limit(s.joint, s.dof, s.sign); break;
    case LimitEvent::leave: editor.release_limit(s.joint, s.dof); break;
  }
  event.after = world_->totals();
  editor.certify(event);
  revision_ = world_->tree().revision();  // locks change no limits
  events.push_back(std::move(event));
}

void Stops::share() {
  steps_->clear_stops();
  if (!any()) return;
  bool changed = false;
  for (const Side& s : sides_) {
    if (is_loop({s.joint})) continue;
    const bool stepped = is_stepped(s), held = holds(s);
    if (locked(s) && !(stepped && held)) continue;
    SteppedStop stop = as_stop(s);
    if (stepped ? held : stop.rests) {
      Event scratch;
      TopologyEditor editor(*world_);
      editor.begin(scratch, "");
      if (held)
        editor.release_limit(s.joint, s.dof);
      else
        editor.engage_limit(s.joint, s.dof, s.sign);
      stop.rests = held, changed = true;
      steps_->points.set_resting(stop);
    }
    if (stepped) steps_->add_stop(stop);
  }
  if (!changed) return;
  revision_ = world_->tree().revision();
  world_->edit().take_own_variables();
  (*evaluate_)(state());
}

// A joint rests while its stop presses it without a rebound, and until it is seen to have left.
void Stops::report_stepped(std::vector<Event>& events) {
  if (!any()) return;
  (*evaluate_)(state());
  for (const Side& s : sides_) {
    if (!is_stepped(s) || locked(s)) continue;
    if (steps_->struck(s.joint, s.dof, s.sign)) {  // where it stays, it rests from the next step on
      events.push_back(begin_event(s, LimitEvent::hit));
      continue;
    }
    SteppedStop stop = as_stop(s);
    if ((stop.force == 0 && !stop.rests) || stop.rests == stop.touched) continue;
    stop.rests = stop.touched;
    events.push_back(begin_event(s, stop.rests ? LimitEvent::rest : LimitEvent::leave));
    steps_->points.set_resting(stop);
  }
  steps_->forget_hits();
}

bool Stops::release_pulled(const std::vector<Event>& happened, std::vector<Event>& events, bool pressed) {
  const std::size_t count = events.size();
  for (const Side& s : sides_) {
    if (!holds(s)) continue;
    double through = 0, size = 0;
    for (const Event& event : happened) {
      for (const auto& [name, S] : event.impulse) {
        if (world_->find_joint(name) != s.joint) continue;
        const Joint& joint = joint_of(world_->tree(), s.joint);
        const Numbers q = world_->joint({s.joint}).q;
        const auto [v, w] = seen_from_child(joint, joint_dofs(spec_of(joint), q.data())[static_cast<std::size_t>(s.dof)]);
        through += dot(v, Vec3{S[0], S[1], S[2]}) + dot(w, Vec3{S[3], S[4], S[5]});
        size += norm(Vec3{S[0], S[1], S[2]}) * norm(v) + norm(Vec3{S[3], S[4], S[5]}) * norm(w);
      }
    }
    for (const Event& event : happened)  // a coupling's impulse on the joint is not the stop's
      for (const Event::OfCoupling& each : event.coupling_impulse) {
        const double own = (world_->find_joint(each.joint) == s.joint ? each.on_joint : 0.0) +
                           (world_->find_joint(each.follows) == s.joint ? each.on_follows : 0.0);
        through -= own, size += std::fabs(own);
      }
    if ((pressed ? std::fabs(through) : s.sign * through) > 1e-10 * size) act(events, s, LimitEvent::leave, 0);
  }
  revision_ = world_->tree().revision();
  return events.size() != count;
}

bool Stops::release_pushed(const std::vector<double>& forces, std::vector<Event>& events) {
  const std::size_t count = events.size();
  double size = 0;
  for (const double force : forces) size = std::max(size, std::fabs(force));
  for (const Side& s : sides_) {
    if (!holds(s) || is_loop({s.joint})) continue;
    const int place = world_->tree().first_p(world_->tree().carrier(s.joint)) + s.dof;
    if (s.sign * forces[static_cast<std::size_t>(place)] < -1e-10 * size) act(events, s, LimitEvent::leave, 0);
  }
  return events.size() != count;
}

std::vector<std::string> Stops::passed() const {
  constexpr double most = 1e-3;  // of 1 + |limit|: in rad or m
  std::vector<std::string> all;
  if (revision_ != world_->tree().revision()) return all;
  for (const Side& s : sides_)
    if (const double beyond = s.sign * (coordinate(s) - s.limit); beyond > most * (1 + std::fabs(s.limit)))
      all.push_back("'" + std::string(world_->joint_name({s.joint})) + "' is " + detail::text(beyond) + " beyond its " +
                    (s.sign > 0 ? "upper" : "lower") + " stop");
  return all;
}

bool Stops::at_stop(const Side& s) const { return s.sign * coordinate(s) - edge(s) >= -rounding(s); }

// The fastest impact faster than its rest speed, or null.
const Stops::Side* Stops::fastest_hit() {
  (*evaluate_)(state());
  const Side* hit = nullptr;
  bool accelerated = false;
  for (const Side& s : sides_) {
    if (is_stepped(s) || locked(s) || !at_stop(s) || !(speed(s) > s.rest_speed) || (hit != nullptr && !(speed(s) > speed(*hit))))
      continue;
    if (!accelerated) accelerate(world_->tree(), state(), workspace());
    accelerated = true;
    if (speed(s) > rest_speed(s)) hit = &s;
  }
  return hit;
}

bool Stops::strike(std::vector<Event>& events) {
  const std::size_t count = events.size();
  for (int k = 0; any() && k < most_impacts; ++k) {
    const Side* const hit = fastest_hit();
    if (hit == nullptr) break;
    const Side side = *hit;
    act(events, side, LimitEvent::hit, side.restitution);
    if (side.restitution == 0) act(events, side, LimitEvent::rest, 0);
  }
  return events.size() != count;
}

// Releases a joint that its stop would have to pull. If it is then pressed on the stop, rounding decides: the force is close to
// zero, or the joint is at a turning point of what loops let it do, where a stop hardly holds them and would for ever release the
// joint and stop it again. The stop then acts a little deeper, where it can hold.
void Stops::leave(std::vector<Event>& events, Side& s) {
  constexpr double deeper = 1e-8;  // of 1 + |limit|: in rad or m
  act(events, s, LimitEvent::leave, 0);
  (*evaluate_)(state());
  accelerate(world_->tree(), state(), workspace());
  if (acceleration(s) > 0) s.edge = s.sign * coordinate(s) + deeper * (1 + std::fabs(s.limit));
}

// Handles the most urgent impact, rest or release; false if there is none.
bool Stops::one_thing(std::vector<Event>& events) {
  // Where prescribed motions or other stops leave nothing that can give way, only rounding limits the impulse. Prescribed motions
  // may do more work than the kinetic energy, but not 1e10 times as much.
  const auto exceeds = [](const Event& e) { return !(std::fabs(e.lost) <= 1e10 * (e.before.kinetic + e.after.kinetic)); };
  std::size_t count = events.size();
  const auto give_up = [&](const Side& side) {
    events.resize(count);
    revision_ = world_->tree().revision();
    blocked_ = side.joint;
    return false;
  };
  const Side* const hit = fastest_hit();
  if (hit != nullptr) {
    // Joints that rest on other stops take part in the impact for as long as their stops need not pull.
    const Side side = *hit;
    WorldSnapshot before = world_->snapshot();
    for (;;) {
      act(events, side, LimitEvent::hit, side.restitution);
      const std::vector<Event> last{events.back()};
      bool pulled = false;
      for (const Side& s : sides_) pulled = pulled || holds(s);
      if (!pulled && !exceeds(last[0])) return true;
      if (!pulled) {
        world_->restore(before);
        return give_up(side);
      }
      const WorldSnapshot after = world_->snapshot();
      world_->restore(before);
      const bool blocked = exceeds(last[0]);
      events.resize(count);
      if (!release_pulled(last, events, blocked)) {
        if (blocked) return give_up(side);
        world_->restore(after);
        revision_ = world_->tree().revision();
        events.push_back(last[0]);
        return true;
      }
      before = world_->snapshot();  // released joints stay released: another one may be pulled next
      count = events.size();
    }
  }
  bool candidates = false;
  for (const Side& s : sides_)
    candidates = candidates || holds(s) || (!is_stepped(s) && !locked(s) && at_stop(s) && speed(s) >= -s.rest_speed);
  if (!candidates) return false;
  accelerate(world_->tree(), state(), workspace());
  for (Side& s : sides_) {
    if (!holds(s) || pull(s) <= 0) continue;
    leave(events, s);
    return true;
  }
  for (const Side& s : sides_) {
    if (is_stepped(s) || locked(s) || !at_stop(s) || speed(s) < -1e-3 * s.rest_speed) continue;
    const bool pressed = acceleration(s) > 0;
    if (!pressed && speed(s) <= no_speed * s.rest_speed) continue;  // pulled off, or touching at zero speed
    const Side side = s;
    const WorldSnapshot before = world_->snapshot();
    act(events, side, pressed ? LimitEvent::rest : LimitEvent::hit, 0);
    if (!exceeds(events.back())) return true;
    world_->restore(before);
    return give_up(side);
  }
  return false;
}

void Stops::resolve_limits(std::vector<Event>& events) {
  blocked_ = -1;
  if (!any()) return;
  for (int k = 0; k < most_impacts && one_thing(events); ++k) {
  }
}

}  // namespace momentree
