// Events of a run: actions that are due, or that come from outside, are carried out.
#include <algorithm>
#include <iterator>

#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

bool Simulation::Impl::happen() {
  for (std::size_t count = 0;; ++count) {
    std::vector<std::size_t> places = queue.due(world.time());
    if (places.empty() && queue.watching(world)) {
      evaluate_state();
      if (const std::optional<std::size_t> place = queue.urgent(world, events_now())) places = {*place};
    }
    if (places.empty()) return true;
    if (count > detail::most_events_at_once) {
      outcome.message = "more than " + std::to_string(detail::most_events_at_once) +
                        " events at t = " + detail::text(world.time()) + " s, the last of them " + last_events(events) +
                        "; do they trigger each other without a delay?";
      return false;
    }
    std::vector<DueEvent> due;
    for (const std::size_t k : places) due.push_back(queue.at(k).event);
    if (history.keeps()) history.keep({events.size(), snapshot(), places});
    if (!carry_out_now(due)) {
      if (history.keeps()) history.instants.pop_back();
      return false;
    }
    for (const std::size_t k : places) queue.happened(k, world.time());
  }
}

bool Simulation::Impl::act(std::span<const Action> actions, const std::string& name) {
  energy.settle(world);
  const bool continued = std::exchange(continues, false), kept = std::exchange(contact.keeps_closed, false);
  const bool pending = contact.between_runs.has_pending();
  contact.between_runs.open_pending();
  const During working(activity.doing, Doing::working);
  DueEvent due{name.empty() ? "#" + std::to_string(queue.entries.size() + events.size() + 1) : name, !name.empty(), {}};
  due.actions.assign(actions.begin(), actions.end());
  if (history.keeps()) history.keep({events.size(), snapshot(), {}});
  const bool done = carry_out_now({&due, 1});
  if (!done && history.keeps()) history.instants.pop_back();
  if (done ? contact.some_step() || contact.steps_through() : pending) contact.update_pending();
  if (!done) continues = continued, contact.keeps_closed = kept;
  return done;
}

// Carries out actions. False: they were refused, or bodies then overlap, and nothing has happened.
bool Simulation::Impl::carry_out_now(std::span<const DueEvent> due) {
  evaluate_state();
  if (statistics.changes == 0) book();
  outcome.overlapped.reset();
  if (!contact.geometry.pairs.any()) return try_now(due);
  const SimulationSnapshot before = snapshot();
  const RunStatistics counted = statistics;
  const double overlapping = contact.steps_through() || contact.some_step() ? contact.geometry.overlaps.deepest()
                                                                            : 0;  // time stepping leaves small ones
  if (try_now(due) && !contact.overlaps_more_than(overlapping)) return true;
  restore_run(before);
  queue.continue_from(*before.queue, world);
  statistics = counted;
  if (outcome.overlapped) {
    evaluate_state();
    const auto [event, action] = overlapping_action(due);
    outcome.message = refusal(due[event], due[event].actions[action], world.time(), refused_overlap(*outcome.overlapped));
    outcome.stalled = false;
  }
  return false;
}

// The first action of an instant after which bodies overlap.
std::pair<std::size_t, std::size_t> Simulation::Impl::overlapping_action(std::span<const DueEvent> due) {
  const std::optional<Overlap> already = contact.geometry.overlaps.of_all();
  const WorldSnapshot start = world.snapshot();
  std::pair<std::size_t, std::size_t> last{};
  for (std::size_t e = 0; e < due.size(); ++e)
    for (std::size_t a = 0; a < due[e].actions.size(); ++a) {
      last = {e, a};
      const DueEvent alone{due[e].name, due[e].named, {due[e].actions[a]}};
      static_cast<void>(carry_out_with_passes({&alone, 1}, true));
      const std::optional<Overlap> now = contact.geometry.overlaps.of_all();
      if (!now || now->depth <= std::max(left_by_steps, already ? already->depth : 0)) continue;
      world.restore(start);
      return last;
    }
  world.restore(start);
  return last;
}

ActionResult Simulation::Impl::refused_overlap(const std::string& what) {
  return ActionResult::refused(what,
                               "only bodies that are welded together may overlap: leave a gap between them, or let them "
                               "pass through each other by a contact rule that is off");
}

// Bodies that overlap when the joint between them ends pass through each other until they are apart, which an event says.
InstantReport Simulation::Impl::carry_out_with_passes(std::span<const DueEvent> due, bool dry_run) {
  if (!contact.geometry.pairs.any()) return carry_out(world, due, dry_run);
  const Connections before = world.edit().connections();
  InstantReport report = carry_out(world, due, dry_run);
  if (report.refused || report.lost || report.changes == 0) return report;
  for (const PairOverlaps::Parted& pair : contact.geometry.overlaps.let_pass(before)) {
    Event event = contact.pass_of(pair.overlap.a, pair.overlap.b, pair.point, {});
    event.reason = "they overlap by " + detail::text(pair.overlap.depth) +
                   " m where the joint between them ended, and touch once they are apart; leave a gap between their shapes";
    report.events.push_back(std::move(event));
  }
  return report;
}

bool Simulation::Impl::try_now(std::span<const DueEvent> due) {
  WorldSnapshot before;
  const bool stopped = stops.any();
  if (stopped) before = world.snapshot();
  InstantReport report = carry_out_with_passes(due, false);
  std::vector<Event> leaves;
  // A stop that would have had to pull in an impact was released before it: repeat without it.
  for (bool again = stopped; again && !report.refused;) {
    const WorldSnapshot after = world.snapshot();
    world.restore(before);
    again = stops.release_pulled(report.events, leaves);
    if (again) {
      before = world.snapshot();
      report = carry_out_with_passes(due, false);
    } else {
      world.restore(after);
    }
  }
  statistics.changes += report.changes;
  statistics.topology_seconds += report.seconds;
  if (report.refused) {
    outcome.message = report.message;
    return false;
  }
  world.edit().take_own_variables();
  contact.steps.forget_parted();
  if (report.changes != 0 && contact.steps.points.has_forces()) contact.steps.points.release();
  evaluate_state();
  std::ranges::move(leaves, std::back_inserter(events));
  for (Event& event : report.events) {
    for (ActionRecord& action : event.actions)
      if (action.skipped == joint_is_gone && world.find_joint(action.joint) < 0)
        if (const EventQueue::Entry* const makes = queue.to_make(action.joint))
          action.skipped = "the joint does not exist yet: event '" + makes->event.name + "' makes it";
    energy.add(event);
    events.push_back(std::move(event));
  }
  queue.forget_looks();
  static_cast<void>(contact.resolve_in_turn(true));
  return !outcome.overlapped;
}

}  // namespace momentree
