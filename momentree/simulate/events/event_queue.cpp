#include <momentree/simulate/events/event_queue.hpp>

#include <algorithm>

#include <momentree/base/periodic.hpp>
#include <momentree/simulate/run_state.hpp>
#include <momentree/simulate/world/world.hpp>

namespace momentree {

std::size_t EventQueue::add(Entry entry) {
  entry.rank = entries.size();
  entries.push_back(std::move(entry));
  next_ = std::min(next_, entries.back().time);
  return entries.size() - 1;
}

void EventQueue::look_ahead() {
  next_ = HUGE_VAL;
  for (const Entry& e : entries) {
    if (e.done) continue;
    const bool holds = e.condition && e.since >= 0 && e.condition->duration > 0;
    next_ = std::min(next_, holds ? delayed(e.since, e.condition->duration) : e.time);
  }
}

std::vector<std::size_t> EventQueue::due(double time) const {
  std::vector<std::size_t> places;
  if (next_ > time) return places;
  for (std::size_t k = 0; k < entries.size(); ++k)
    if (!entries[k].done && !entries[k].condition && entries[k].time <= time) places.push_back(k);
  std::stable_sort(places.begin(), places.end(), [this](auto a, auto b) { return entries[a].rank < entries[b].rank; });
  return places;
}

bool EventQueue::watching(const World& world) const {
  return !strengths_.empty() || has_strengths(world) ||
         std::any_of(entries.begin(), entries.end(), [](const Entry& e) { return e.condition && !e.done; });
}

// Joints are made and removed, and their strengths with them; joints that remain keep the history of their loads. A joint that
// broke no longer exists: the joint that now has its number, and its strength, are new.
void EventQueue::renew_strengths(const World& world) {
  strengths_of_ = world.tree().revision();
  if (strengths_.empty() && !has_strengths(world)) return;
  const std::vector<Strength> now = strengths(world);
  std::vector<Borne> before = std::move(strengths_);
  strengths_.clear();
  for (const Strength& s : now) {
    const auto known =
        std::find_if(before.begin(), before.end(), [&](const Borne& b) { return b.strength == s && !b.entry.done; });
    if (known != before.end()) {
      strengths_.push_back(std::move(*known));
      continue;
    }
    strengths_.push_back(borne(s, event_name(world, s), name_of(world, s)));
  }
}

const EventQueue::Entry* EventQueue::to_make(const std::string& joint) const {
  const auto makes = [&](const Entry& e) { return e.fired == 0 && !e.done && makes_joint(e.event, joint); };
  const auto found = std::find_if(entries.begin(), entries.end(), makes);
  return found == entries.end() ? nullptr : &*found;
}

EventQueue::Borne EventQueue::borne(const Strength& strength, const std::string& event, const std::string& joint) {
  Entry entry;
  entry.event.name = event;
  entry.event.actions = {break_joint(joint)};
  entry.condition = condition_of(strength);
  return {strength, std::move(entry), joint};
}

namespace {

// The maximum of the parabola through three evaluations, if it is between them.
void note_between(Approach& nearest, const EventQueue::Entry& e, double time, double excess) {
  if (e.looked_before < 0 || !(e.excess >= e.excess_before && e.excess >= excess)) return;
  const double before = e.looked - e.looked_before, after = time - e.looked;
  const double rise = (e.excess - e.excess_before) / before, fall = (excess - e.excess) / after;
  const double curvature = (fall - rise) / (before + after), slope = rise + curvature * before;  // where the parabola is highest
  if (!(curvature < 0)) return;
  const double offset = -slope / (2 * curvature);
  nearest.note(e.looked + offset, std::min(e.excess + offset * (slope + curvature * offset), std::max(0.0, e.excess)));
}

}  // namespace

namespace {

// Steps may lead from one impact to the next, so that the time between them is never looked at.
bool begins_again(const EventQueue::Entry& e, const World& world, std::span<const Event> now) {
  const auto is_own = [&e](const Event& event) { return event.name == e.event.name; };
  return e.condition->what->is_impulsive() && std::none_of(now.begin(), now.end(), is_own) &&
         e.condition->what->begins(world, now);
}

}  // namespace

std::optional<std::size_t> EventQueue::urgent(const World& world, std::span<const Event> now) {
  if (strengths_of_ != world.tree().revision()) renew_strengths(world);
  std::optional<std::size_t> first, load;
  double largest = 0;
  for (std::size_t k = 0; k < count(); ++k) {
    Entry& e = at(k);
    if (!e.condition || e.done) continue;
    const Condition& c = *e.condition;
    // Impulses belong to an instant: a run that continues another one has not seen them, but the other run has already evaluated
    // them.
    if (c.what->is_impulsive() && now.empty() && e.looked == world.time()) continue;
    const std::optional<double> value = c.value(world, now);
    if (!value) {
      e.since = -1;
      continue;
    }
    const double excess = c.above ? *value - c.threshold : c.threshold - *value;
    e.nearest.note(world.time(), excess);
    if (e.looked >= 0 && world.time() > e.looked) note_between(e.nearest, e, world.time(), excess);
    if (world.time() > e.looked) e.excess_before = e.excess, e.looked_before = e.looked, e.looked = world.time();
    e.excess = excess;
    if (e.resting && (excess < -c.width() || begins_again(e, world, now))) e.resting = false;
    if (e.resting || !(excess > 0)) {
      e.since = -1;
      continue;
    }
    if (e.since < 0) e.since = world.time();
    e.nearest.held = std::max(e.nearest.held, world.time() - e.since);
    if (world.time() < delayed(e.since, c.duration)) continue;
    if (!first) first = k;
    if (c.what->is_load() && c.ratio(*value) > largest) load = k, largest = c.ratio(*value);
  }
  look_ahead();  // to when those that hold will have held for long enough
  return load ? load : first;
}

std::span<const Watch> EventQueue::watches(const World& world) {
  watches_.clear();
  if (strengths_of_ != world.tree().revision()) renew_strengths(world);
  for (std::size_t k = 0; k < count(); ++k) {
    const Entry& e = at(k);
    if (!e.condition || e.done) continue;
    const Condition& c = *e.condition;
    if (!c.exact || c.what->is_impulsive()) continue;
    const bool holds = e.since >= 0 || e.resting;
    if (holds && !e.resting && !(c.duration > 0)) continue;
    const std::optional<double> excess = c.excess(world, {});
    if (!excess) continue;
    const double sign = holds ? -1 : 1, offset = e.resting ? c.width() : 0;
    const auto counted = [&](double x) { return sign * (x + offset); };
    if (counted(*excess) > 0) continue;
    const double ago = e.looked == world.time() && e.looked_before >= 0 ? e.looked - e.looked_before : 0;
    Watch& watch = watches_.emplace_back(Watch{&c, counted(*excess), counted(e.excess_before), ago, sign, offset, {}});
    watch.start_rate = watch.rate(world);
  }
  return watches_;
}

void EventQueue::happened(std::size_t place, double time) {
  Entry& e = at(place);
  ++e.fired;
  e.since = -1;
  if (e.condition) {
    e.resting = e.condition->repeats;
    e.done = !e.condition->repeats;
  } else if (e.period > 0) {
    e.time = Periodic(e.from, e.period).first_after(e.time);
  } else if (e.after.empty()) {
    e.done = true;
  } else {
    e.time = HUGE_VAL;
  }
  const std::string name = e.event.name;
  forget_looks();
  for (Entry& other : entries)
    if (other.after == name) other.time = std::min(other.time, delayed(time, other.delay));
  look_ahead();
}

void EventQueue::forget_looks() {
  for (std::size_t k = 0; k < count(); ++k) at(k).looked = at(k).looked_before = -1;
}

std::vector<EventStatus> EventQueue::armed() const { return {entries.begin(), entries.end()}; }

QueueState EventQueue::state(const World& world) const {
  QueueState state;
  state.entries.assign(entries.begin(), entries.end());
  for (const Borne& b : strengths_) state.strengths.push_back({b.strength, b.entry.event.name, b.joint, b.entry});
  state.strengths_known = strengths_of_ == world.tree().revision();
  state.next = next_;
  return state;
}

void EventQueue::continue_from(const QueueState& state, const World& world) {
  MT_REQUIRE(state.entries.size() == entries.size(), "the events are scheduled that the run had");
  for (std::size_t k = 0; k < entries.size(); ++k) static_cast<Progress&>(entries[k]) = state.entries[k];
  restore_strengths(state, world);
  next_ = state.next;
}

void EventQueue::restore_strengths(const QueueState& state, const World& world) {
  strengths_.clear();
  strengths_of_.reset();
  for (const QueueState::Borne& b : state.strengths)
    static_cast<Progress&>(strengths_.emplace_back(borne(b.strength, b.event, b.joint)).entry) = b.entry;
  if (state.strengths_known) strengths_of_ = world.tree().revision();
}

void EventQueue::restore(std::span<const EventStatus> armed, double now) {
  strengths_.clear();
  strengths_of_.reset();
  for (std::size_t k = 0; k < entries.size(); ++k) {
    Entry& e = entries[k];
    e.looked = e.looked_before = -1;
    e.nearest = {};
    if (k < armed.size()) {
      static_cast<EventStatus&>(e) = armed[k];
    } else {
      e.fired = 0, e.since = -1, e.resting = false;
      if (!e.after.empty()) e.time = HUGE_VAL;
      e.done = !e.condition && e.time < now;
    }
  }
  look_ahead();
}

void EventQueue::restart(double before, double now) {
  const bool back = now < before;
  strengths_.clear();
  strengths_of_.reset();
  for (Entry& e : entries) {
    e.looked = e.looked_before = e.since = -1;
    e.nearest = {};
    if (back) e.fired = 0, e.done = e.resting = false;
    if (e.period > 0 && (back || e.time < now)) {
      e.time = std::max(e.from, Periodic(e.from, e.period).first_from(now));
    } else if (!e.after.empty() && (back || e.time < now)) {
      e.time = HUGE_VAL;
    } else if (!e.condition && e.time < now) {
      e.done = true;
    }
  }
  look_ahead();
}

}  // namespace momentree
