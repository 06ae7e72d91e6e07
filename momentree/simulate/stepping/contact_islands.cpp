// Islands whose contacts are stepped through while those of all others are located: when that begins for which bodies, and when
// it ends.
//
// An island is what loops, couplings and contacts connect. Its bodies move without contacts within steps of the method, which are
// then not longer than the given step, and get their impulses at the ends. A body that such an island touches joins it. If all
// mechanisms are stepped through, the method of time stepping takes the place of the other one.
#include <algorithm>
#include <map>

#include <momentree/simulate/contact/contact_policy.hpp>
#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

std::vector<bool> Simulation::Impl::stepped_bodies() const {
  std::vector<bool> on;
  if (!stepping.on) return on;
  for (const SteppedBody& body : stepping.bodies) on.push_back(body.on);
  return on;
}

// All bodies of an island are stepped through, or none: also after a topology change, and of bodies that are added.
void Simulation::Impl::update_islands() {
  const Islands islands(world.tree_);
  stepping.bodies.resize(static_cast<std::size_t>(world.tree_.bodies()));
  const auto of = [&](int body) -> SteppedBody& { return stepping.bodies[static_cast<std::size_t>(body)]; };
  std::vector<bool> on(stepping.bodies.size(), false);
  for (const int b : world.tree_.order())
    if (of(b).on) on[static_cast<std::size_t>(islands.of(b))] = true;
  stepping.on = false, stepping.all = true;
  for (const int b : world.tree_.order()) {
    of(b).on = on[static_cast<std::size_t>(islands.of(b))];
    stepping.on = stepping.on || of(b).on, stepping.all = stepping.all && of(b).on;
  }
  stepping.all = stepping.all && stepping.on;
  geometry.stepped.set(stepped_bodies());
}

// `at`: bodies of the islands; empty, or if these are stepped through already: of all islands that touch anything, or of all.
void Simulation::Impl::begin_stepping(const std::string& why, const std::vector<int>& at) {
  Islands islands(world.tree_);
  geometry.stepped.join_touching(islands);
  stepping.bodies.resize(static_cast<std::size_t>(world.tree_.bodies()));
  std::vector<int> begin;
  const auto begin_at = [&](const std::vector<int>& bodies) {
    std::vector<int> chosen;
    for (const int body : bodies)
      if (body >= 0) chosen.push_back(islands.of(body));
    for (const int b : world.tree_.order()) {
      SteppedBody& body = stepping.bodies[static_cast<std::size_t>(b)];
      if (body.on || std::find(chosen.begin(), chosen.end(), islands.of(b)) == chosen.end()) continue;
      body.on = true, body.since_impact = world.time();
      begin.push_back(b);
    }
  };
  begin_at(at);
  if (begin.empty())
    for (const Contact& c : geometry.stepped.touching()) begin_at({c.a, c.b});
  if (begin.empty()) begin_at({world.tree_.order().begin(), world.tree_.order().end()});
  contact_steps.points.set(stepping.on ? contact_steps.points.all() : std::vector<SteppedContact>(), true);
  stepping.on = true;
  stepping.changes = stepping.changes_at_once = 0;
  update_islands();
  evaluate_state();
  report_stepping("stepping", why, begin);
}

void Simulation::Impl::report_stepping(const char* what, const std::string& why, const std::vector<int>& bodies) {
  Event event;
  event.time = world.time(), event.name = what, event.reason = why;
  event.mechanisms_before = event.mechanisms_after = world.mechanism_names();
  for (const Mechanism& mechanism : world.mechanisms())
    if (std::find(bodies.begin(), bodies.end(), mechanism.root.index) != bodies.end()) event.stepped.emplace_back(mechanism.name);
  event.before = event.after = world.totals();
  events.push_back(std::move(event));
}

void Simulation::Impl::join_touched_islands() {
  const std::vector<int> touched = geometry.stepped.touched();
  if (!touched.empty()) begin_stepping("touches what is stepped through", touched);
}

// Completes a step of h seconds, which the bodies of these islands have made without contacts.
void Simulation::Impl::step_islands(double h) {
  contact_steps.apply(world.state_, ledger, h);
  evaluate_state();
  after_contact_step();
  if (some_step()) join_touched_islands();
}

// Bodies that passed through each other in the step: an event of each pair, at the first time.
void Simulation::Impl::report_passes() {
  for (const SteppedPairs::Passed& pair : geometry.stepped.passed()) {
    Event event = pass_of(pair.a, pair.b, pair.point, pair.side);
    const auto same = [&](const Event& e) {
      return e.name == event.name && !(e.contact.normal == Vec3{}) && e.contact.one == event.contact.one &&
             e.contact.other == event.contact.other;
    };
    if (std::any_of(events.begin(), events.end(), same)) continue;
    event.reason = "within one step through contacts; use steps of at most " + detail::text(pair.step) + " s" +
                   (method_steps ? ", or dop853, which locates contacts" : "");
    events.push_back(std::move(event));
  }
}

Event Simulation::Impl::pass_of(int one, int other, const Vec3& point, const Vec3& normal) const {
  Event event;
  event.time = world.time(), event.name = passed_through;
  event.contact.one = world.model_.body_name({one}), event.contact.other = world.model_.body_name({other});
  event.contact.point = point, event.contact.normal = normal;
  event.mechanisms_before = event.mechanisms_after = world.mechanism_names();
  event.before = event.after = world.totals();
  return event;
}

// When bodies began to overlap, and their deepest overlap, by pair of bodies.
void Simulation::Impl::note_overlaps() {
  for (const auto& [pair, depth] : contact_steps.overlapping()) {
    const Overlap found = geometry.overlaps.overlap(pair, depth);
    const auto known = std::ranges::find_if(stepping.overlaps, [&](const KeptOverlap& o) { return o.deepest.same_pair(found); });
    if (known == stepping.overlaps.end())
      stepping.overlaps.push_back({found, world.time()});
    else if (known->deepest.depth < depth)
      known->deepest = found;
  }
}

void Simulation::Impl::after_contact_step() {
  report_passes();
  note_overlaps();
  stops.report_stepped(events);
  if (contact_steps.residual() > statistics.contact_residual)
    statistics.contact_residual = contact_steps.residual(), statistics.contact_residual_at = world.time();
  if (!stepping.on) return;  // the method itself steps
  const auto of = [&](int body) -> SteppedBody& { return stepping.bodies[static_cast<std::size_t>(body)]; };
  for (const int body : contact_steps.hits()) of(body).since_impact = world.time();
  Islands islands(world.tree_);
  for (const auto& [a, b] : contact_steps.touching()) islands.join(a, b);
  const auto find_due = [&] {
    std::map<int, SteppedBody> all;  // by number of the island
    for (const int b : world.tree_.order()) {
      if (!of(b).on) continue;
      SteppedBody& island = all.try_emplace(islands.of(b), of(b)).first->second;
      island.since_impact = std::max(island.since_impact, of(b).since_impact);
      island.patience = std::max(island.patience, of(b).patience);
    }
    std::erase_if(all, [&](const auto& each) { return world.time() - each.second.since_impact < each.second.patience; });
    return all;
  };
  if (find_due().empty()) return;
  std::vector<Contact> near;  // also what the step itself brought together
  geometry.stepped.add_near(policy::step_touch, near);
  for (const Contact& c : near) islands.join(c.a, c.b);
  for (const auto& [number, island] : find_due()) {
    if (!of(number).on) continue;
    const auto here = [&](const Contact& c) { return islands.of(c.a >= 0 ? c.a : c.b) == number; };
    if (static_cast<std::size_t>(std::ranges::count_if(near, here)) > policy::most_points) continue;
    if (std::ranges::any_of(near, [&](const Contact& c) { return here(c) && geometry.pairs.law(c.pair).has_moments(); }))
      continue;
    try_to_locate(islands, number);
    if (!stepping.on) return;
  }
}

// Each attempt that does not last is followed by a longer wait.
void Simulation::Impl::try_to_locate(const Islands& islands, int number) {
  const std::vector<SteppedContact> points = contact_steps.points.all();
  const SteppingState as_before = stepping;
  std::vector<int> bodies;
  for (const int b : world.tree_.order()) {
    if (islands.of(b) != number) continue;
    stepping.bodies[static_cast<std::size_t>(b)].on = false;
    bodies.push_back(b);
  }
  std::vector<SteppedContact> others = points;
  std::erase_if(others, [&](const SteppedContact& point) { return islands.of(point.a >= 0 ? point.a : point.b) == number; });
  update_islands();
  stops.share();
  contact_steps.points.set(others);
  report_stepping("resume", {}, bodies);
  std::vector<Event> changes;
  const std::optional<Contacts::Unresolved> failed = contacts.resolve(changes);
  if (failed) {
    events.pop_back();
    stepping = as_before;
    geometry.stepped.set(stepped_bodies());
    contact_steps.points.set(points);
  }
  for (const int b : bodies) {
    SteppedBody& body = stepping.bodies[static_cast<std::size_t>(b)];
    body.patience = std::min(2 * body.patience, policy::longest_patience), body.since_impact = world.time();
  }
  evaluate_state();
  for (Event& change : changes) {  // impacts may have happened before an attempt failed
    add_to_balance(change);
    events.push_back(std::move(change));
  }
  ledger.projection -= contacts.take_lost();
  queue.forget_looks();
  // The attempt opened the other contacts that are located.
  if (failed && some_step()) static_cast<void>(resolve_contacts(true));
}

}  // namespace momentree
