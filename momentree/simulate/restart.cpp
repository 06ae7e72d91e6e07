// What programs need that prepare simulations, restore them or step them again and again.
#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

void expect_joints(Simulation& simulation, const std::vector<std::string>& names) {
  Simulation::Impl& impl = implementation(simulation, false);
  MT_REQUIRE(impl.activity.steady(), callback_schedules);
  impl.queue.expected.insert(names.begin(), names.end());
}

StepMemory step_memory(const Simulation& simulation) {
  Simulation::Impl& impl = implementation(simulation, false);
  const bool adaptive = impl.method->adaptive();
  StepMemory memory{adaptive ? impl.method->proposal() : 0.0, adaptive ? impl.energy.ledger.work : 0.0,
                    impl.contact.stepping_state()};
  if (impl.activity.idle() && impl.contact.geometry.pairs.any()) {
    const bool stepped = impl.contact.method_steps || impl.contact.stepping.on || !memory.stepping.points.empty();
    if (stepped && impl.contact.steps.points.has_forces() && !impl.contact.between_runs.has_pending())
      memory.stepping.unloaded = impl.contact.unloaded();
    memory.stepping.excess = impl.contact.between_runs.excess_of_closed();
    const double overlap = impl.contact.stepping.placed ? 0 : impl.contact.geometry.overlaps.deepest();
    if (overlap > left_by_steps) memory.stepping.overlap = overlap;
  }
  if (!impl.contact.geometry.pairs.any()) memory.stepping.released = false;  // nothing that can touch has forces
  memory.stepping.placed = true;                                             // whatever begins with it
  memory.stepping.overlaps.clear();                                          // of the run until then
  for (const DeeperStop& stop : impl.stops.deeper())
    memory.deeper.emplace_back(std::string(impl.world.joint_name({stop.joint})), stop);
  return memory;
}

void resume(Simulation& simulation, std::span<const EventStatus> armed, const StepMemory& memory) {
  Simulation::Impl& impl = implementation(simulation, true);
  MT_REQUIRE(armed.size() <= impl.queue.entries.size(), "at most as many events as are scheduled");
  MT_REQUIRE(std::isfinite(memory.next_step) && std::isfinite(memory.work), "a StepMemory returned by step_memory()");
  if (impl.method->adaptive() && memory.next_step > 0) {
    impl.method->set_proposal(memory.next_step);
    impl.energy.balance.work -= memory.work - impl.energy.ledger.work;  // it was done before this run
    impl.energy.ledger.work = memory.work;
  }
  std::vector<EventStatus> all = impl.queue.armed();
  std::copy_n(armed.begin(), std::min(armed.size(), all.size()), all.begin());
  impl.queue.restore(all, impl.world.time());
  std::vector<DeeperStop> deeper;
  for (auto [joint, stop] : memory.deeper)
    if (stop.joint = impl.world.find_joint(joint); stop.joint >= 0) deeper.push_back(stop);
  impl.stops.set_deeper(deeper);
  // The forces of the last step, if any, take the place of these contacts.
  if (!memory.stepping.points.empty() || memory.stepping.unloaded >= 0) impl.contact.between_runs.open_pending();
  if (memory.stepping != SteppingState{}) impl.contact.continue_stepping(memory.stepping);
  impl.contact.keeps_closed = true;
  impl.contact.stepping.placed = !impl.contact.overlaps_as_before(memory.stepping.overlap);
  impl.contact.check_contacts_of_document(memory.stepping);
}

void restart(Simulation& simulation, const WorldSnapshot& start) {
  Simulation::Impl& impl = implementation(simulation, true);
  require_contact_method(start, impl.integration.method);
  const double before = impl.world.time();
  const bool populated = !start.added.empty() || impl.world.model().size() != impl.world.start().bodies;
  impl.world.restore(start);
  impl.world.edit().take_needed_variables();
  if (populated) impl.contact.geometry.pairs.renew();
  impl.contact.contacts.watches.set_short_steps(0);
  impl.queue.restart(before, impl.world.time());
  impl.make_methods();
  impl.begin();
}

std::optional<Overlap> overlap(const Simulation& simulation) {
  return implementation(simulation, true).contact.geometry.overlaps.of_all();
}

void functions_changed(Simulation& simulation, bool preview) {
  Simulation::Impl& impl = implementation(simulation, true);
  static_cast<void>(impl.world.edit().state().edit());
  impl.contact.keeps_closed = false;
  if (!preview) return;
  impl.evaluate_state();
  impl.contact.update_pending();
}

void Simulation::forget_events(double time) {
  constexpr double needed = 0.1;  // s
  Impl& impl = changing();
  std::vector<Event>& events = impl.events;
  if (events.empty()) return;
  const double before = std::min(time, impl.world.time() - needed);
  const auto end = std::find_if(events.begin(), events.end() - 1, [&](const Event& event) { return event.time >= before; });
  if (end == events.begin()) return;
  events.erase(events.begin(), end);
  impl.history.instants.clear();
}

}  // namespace momentree
