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

std::vector<bool> ContactRun::stepped_bodies() const {
  std::vector<bool> on;
  if (!stepping.on) return on;
  for (const SteppedBody& body : stepping.bodies) on.push_back(body.on);
  return on;
}

// All bodies of an island are stepped through, or none: also after a topology change, and of bodies that are added.
void ContactRun::update_islands() {
  const Islands islands(run_.world.tree());
  stepping.bodies.resize(static_cast<std::size_t>(run_.world.tree().bodies()));
  const auto of = [&](int body) -> SteppedBody& { return stepping.bodies[static_cast<std::size_t>(body)]; };
  std::vector<bool> on(stepping.bodies.size(), false);
  for (const int b : run_.world.tree().order())
    if (of(b).on) on[static_cast<std::size_t>(islands.of(b))] = true;
  stepping.on = false, stepping.all = true;
  for (const int b : run_.world.tree().order()) {
    of(b).on = on[static_cast<std::size_t>(islands.of(b))];
    stepping.on = stepping.on || of(b).on, stepping.all = stepping.all && of(b).on;
  }
  stepping.all = stepping.all && stepping.on;
  geometry.stepped.set(stepped_bodies());
}

// `at`: bodies of the islands; empty, or if these are stepped through already: of all islands that touch anything, or of all.
void ContactRun::begin_stepping(const std::string& why, const std::vector<int>& at) {
  Islands islands(run_.world.tree());
  geometry.stepped.join_touching(islands);
  stepping.bodies.resize(static_cast<std::size_t>(run_.world.tree().bodies()));
  std::vector<int> begin;
  const auto begin_at = [&](const std::vector<int>& bodies) {
    std::vector<int> chosen;
    for (const int body : bodies)
      if (body >= 0) chosen.push_back(islands.of(body));
    for (const int b : run_.world.tree().order()) {
      SteppedBody& body = stepping.bodies[static_cast<std::size_t>(b)];
      if (body.on || std::find(chosen.begin(), chosen.end(), islands.of(b)) == chosen.end()) continue;
      body.on = true, body.since_impact = run_.world.time();
      begin.push_back(b);
    }
  };
  begin_at(at);
  if (begin.empty())
    for (const Contact& c : geometry.stepped.touching()) begin_at({c.a, c.b});
  if (begin.empty()) begin_at({run_.world.tree().order().begin(), run_.world.tree().order().end()});
  steps.points.set(stepping.on ? steps.points.all() : std::vector<SteppedContact>(), true);
  stepping.on = true;
  stepping.changes = stepping.changes_at_once = 0;
  update_islands();
  run_.evaluate_state();
  report_stepping("stepping", why, begin);
}

void ContactRun::report_stepping(const char* what, const std::string& why, const std::vector<int>& bodies) {
  Event event;
  event.time = run_.world.time(), event.name = what, event.reason = why;
  event.mechanisms_before = event.mechanisms_after = run_.world.mechanism_names();
  for (const Mechanism& mechanism : run_.world.mechanisms())
    if (std::find(bodies.begin(), bodies.end(), mechanism.root.index) != bodies.end()) event.stepped.emplace_back(mechanism.name);
  event.before = event.after = run_.world.totals();
  run_.events.push_back(std::move(event));
}

void ContactRun::join_touched_islands() {
  const std::vector<int> touched = geometry.stepped.touched();
  if (!touched.empty()) begin_stepping("touches what is stepped through", touched);
}

// Completes a step of h seconds, which the bodies of these islands have made without contacts.
void ContactRun::step_islands(double h) {
  steps.apply(run_.world.edit().state(), run_.energy.ledger, h);
  run_.evaluate_state();
  after_contact_step();
  if (some_step()) join_touched_islands();
}

// Bodies that passed through each other in the step: an event of each pair, at the first time.
void ContactRun::report_passes() {
  for (const SteppedPairs::Passed& pair : geometry.stepped.passed()) {
    Event event = pass_of(pair.a, pair.b, pair.point, pair.side);
    const auto same = [&](const Event& e) {
      return e.name == event.name && !(e.contact.normal == Vec3{}) && e.contact.one == event.contact.one &&
             e.contact.other == event.contact.other;
    };
    if (std::any_of(run_.events.begin(), run_.events.end(), same)) continue;
    event.reason = "within one step through contacts; use steps of at most " + detail::text(pair.step) + " s" +
                   (method_steps ? ", or dop853, which locates contacts" : "");
    run_.events.push_back(std::move(event));
  }
}

Event ContactRun::pass_of(int one, int other, const Vec3& point, const Vec3& normal) const {
  Event event;
  event.time = run_.world.time(), event.name = passed_through;
  event.contact.one = run_.world.model().body_name({one}), event.contact.other = run_.world.model().body_name({other});
  event.contact.point = point, event.contact.normal = normal;
  event.mechanisms_before = event.mechanisms_after = run_.world.mechanism_names();
  event.before = event.after = run_.world.totals();
  return event;
}

// When bodies began to overlap, and their deepest overlap, by pair of bodies.
void ContactRun::note_overlaps() {
  for (const auto& [pair, depth] : steps.overlapping()) {
    const Overlap found = geometry.overlaps.overlap(pair, depth);
    const auto known = std::ranges::find_if(stepping.overlaps, [&](const KeptOverlap& o) { return o.deepest.same_pair(found); });
    if (known == stepping.overlaps.end())
      stepping.overlaps.push_back({found, run_.world.time()});
    else if (known->deepest.depth < depth)
      known->deepest = found;
  }
}

void ContactRun::after_contact_step() {
  report_passes();
  note_overlaps();
  run_.stops.report_stepped(run_.events);
  if (steps.residual() > run_.statistics.contact_residual)
    run_.statistics.contact_residual = steps.residual(), run_.statistics.contact_residual_at = run_.world.time();
  if (!stepping.on) return;  // the method itself steps
  const auto of = [&](int body) -> SteppedBody& { return stepping.bodies[static_cast<std::size_t>(body)]; };
  for (const int body : steps.hits()) of(body).since_impact = run_.world.time();
  Islands islands(run_.world.tree());
  for (const auto& [a, b] : steps.touching()) islands.join(a, b);
  const auto find_due = [&] {
    std::map<int, SteppedBody> all;  // by number of the island
    for (const int b : run_.world.tree().order()) {
      if (!of(b).on) continue;
      SteppedBody& island = all.try_emplace(islands.of(b), of(b)).first->second;
      island.since_impact = std::max(island.since_impact, of(b).since_impact);
      island.patience = std::max(island.patience, of(b).patience);
    }
    std::erase_if(all, [&](const auto& each) { return run_.world.time() - each.second.since_impact < each.second.patience; });
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
void ContactRun::try_to_locate(const Islands& islands, int number) {
  const std::vector<SteppedContact> points = steps.points.all();
  const SteppingState as_before = stepping;
  std::vector<int> bodies;
  for (const int b : run_.world.tree().order()) {
    if (islands.of(b) != number) continue;
    stepping.bodies[static_cast<std::size_t>(b)].on = false;
    bodies.push_back(b);
  }
  std::vector<SteppedContact> others = points;
  std::erase_if(others, [&](const SteppedContact& point) { return islands.of(point.a >= 0 ? point.a : point.b) == number; });
  update_islands();
  run_.stops.share();
  steps.points.set(others);
  report_stepping("resume", {}, bodies);
  std::vector<Event> changes;
  const std::optional<Contacts::Unresolved> failed = contacts.resolve(changes);
  if (failed) {
    run_.events.pop_back();
    stepping = as_before;
    geometry.stepped.set(stepped_bodies());
    steps.points.set(points);
  }
  for (const int b : bodies) {
    SteppedBody& body = stepping.bodies[static_cast<std::size_t>(b)];
    body.patience = std::min(2 * body.patience, policy::longest_patience), body.since_impact = run_.world.time();
  }
  run_.evaluate_state();
  for (Event& change : changes) {  // impacts may have happened before an attempt failed
    run_.energy.add(change);
    run_.events.push_back(std::move(change));
  }
  run_.energy.ledger.projection -= contacts.take_lost();
  run_.queue.forget_looks();
  // The attempt opened the other contacts that are located.
  if (failed && some_step()) static_cast<void>(resolve_contacts(true));
}

}  // namespace momentree
