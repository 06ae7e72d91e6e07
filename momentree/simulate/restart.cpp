// What a program needs that steps a simulation again and again: restarts, and events that are forgotten.
#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

void Simulation::restart(const WorldSnapshot& start) {
  Impl& impl = changing();
  const double before = impl.world.time();
  const bool populated = !start.added.empty() || impl.world.model_.size() != impl.world.first_bodies_;
  impl.world.restore(start);
  if (populated) impl.geometry.pairs.renew();
  impl.contacts.watches.set_short_steps(0);
  impl.queue.restart(before, impl.world.time());
  impl.make_methods();
  impl.begin();
}

std::optional<Overlap> Simulation::overlap() const {
  Impl& impl = changing();
  return impl.geometry.overlaps.of_all();
}

void Simulation::functions_changed(bool preview) {
  Impl& impl = changing();
  static_cast<void>(impl.edit_state());
  impl.keeps_contacts = false;
  if (!preview) return;
  impl.evaluate_state();
  impl.update_pending_contacts();
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
  impl.history.clear();
}

}  // namespace momentree
