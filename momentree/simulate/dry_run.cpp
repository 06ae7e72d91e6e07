// Carries out everything that is scheduled without moving in between, and takes it back.
#include <momentree/base/periodic.hpp>
#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

DryRun Simulation::Impl::dry_run() {
  const During working(activity.doing, Doing::working);
  DryRun found;
  const WorldSnapshot start = world.snapshot();
  contact.between_runs.open_pending();
  std::set<std::pair<std::string, Kind>> joints;
  const auto look_at_joints = [&, &tree = world.tree()] {
    for (const int b : tree.order()) joints.emplace(world.joint_name({tree.joint_of(b)}), tree.joint(b).kind);
    for (const Loop& loop : tree.loops()) joints.emplace(world.joint_name(loop.id()), loop.joint.kind);
  };
  look_at_joints();
  // Events with known instants come first, in their order; the others follow one by one, and their order is not known.
  using Turn = EventQueue::Turn;
  std::vector<Turn> order;
  bool certain = true;
  for (std::size_t k = 0; k < queue.entries.size(); ++k) {
    const EventQueue::Entry& e = queue.entries[k];
    if (e.done) continue;
    double time = e.time;
    for (const EventQueue::Entry& other : queue.entries)
      if (!e.after.empty() && other.event.name == e.after) time = std::min(time, delayed(other.time, e.delay));
    certain = certain && std::isfinite(time);
    order.push_back({time, !e.after.empty() && e.delay == 0, k});
  }
  std::stable_sort(order.begin(), order.end(), [this](const Turn& a, const Turn& b) {
    if (a.time != b.time || !std::isfinite(a.time)) return a.time < b.time;
    return std::pair(a.follows, queue.entries[a.entry].rank) < std::pair(b.follows, queue.entries[b.entry].rank);
  });
  std::vector<DueEvent> breaks;  // of joints with a strength, including those that events make or weaken
  const auto add_breaks = [&] {
    for (const Strength& s : strengths(world)) {
      std::string name = event_name(world, s);
      if (std::any_of(breaks.begin(), breaks.end(), [&](const DueEvent& known) { return known.name == name; })) continue;
      breaks.push_back({std::move(name), false, {break_joint(name_of(world, s))}});
      order.push_back({HUGE_VAL, false, queue.entries.size() + breaks.size() - 1});
      certain = false;
    }
  };
  add_breaks();
  const std::size_t n = queue.entries.size();
  const auto event_at = [&](std::size_t k) { return k < n ? queue.entries[k].event : breaks[k - n]; };
  found.complete = order.size() * static_cast<std::size_t>(world.tree().bodies()) <= detail::most_dry_run;
  for (std::size_t i = 0; found.complete && i < order.size();) {
    std::vector<DueEvent> due;
    const std::size_t begin = i;
    const double time = order[i].time;
    do {
      due.push_back(event_at(order[i].entry));
    } while (++i < order.size() && order[i].time == time && order[i].follows == order[begin].follows && std::isfinite(time));
    if (std::isfinite(time)) world.edit().set_time(time);
    const std::optional<Overlap> deepest = contact.geometry.pairs.any() ? contact.geometry.overlaps.of_bodies() : std::nullopt;
    const double overlapping = deepest ? deepest->depth : 0;
    const WorldSnapshot before = world.snapshot();
    const InstantReport report = carry_out_with_passes(due, true);
    for (const ActionReport& action : report.actions)
      if (certain && action.result.outcome != ActionResult::Outcome::done)
        found.issues.push_back({order[begin + action.event].entry, action.action, action.result,
                                action.result.outcome == ActionResult::Outcome::refused ? report.message : "", time});
    // Bodies that were welded together may overlap, wherever they have moved until then. Where the ends of cables are is not
    // known.
    if (certain && !report.refused && !report.lost && contact.geometry.pairs.any())
      if (const std::optional<Overlap> worst = contact.geometry.overlaps.of_bodies();
          worst && worst->depth > std::max(left_by_steps, overlapping)) {
        world.restore(before);
        const auto [event, action] = overlapping_action(due);
        ActionResult overlap = refused_overlap(worst->text());
        std::string why = refusal(due[event], due[event].actions[action], time, overlap);
        found.issues.push_back({order[begin + event].entry, action, std::move(overlap), std::move(why), time});
      }
    found.complete = !report.lost;
    add_breaks();
    look_at_joints();
  }
  world.restore(start);
  found.joints.assign(joints.begin(), joints.end());
  return found;
}

}  // namespace momentree
