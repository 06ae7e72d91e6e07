// Contacts in the steps of a simulation.
#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

// Events with conditions, and contacts, to be located within a step of at most h seconds, which contacts may shorten.
std::span<const Watch> Simulation::Impl::watches(double& h) {
  const std::span<const Watch> of_events = queue.watches(world);
  if (!contacts.any()) return of_events;
  const std::span<const Watch> of_contacts = contacts.watches(h);
  all_watches.assign(of_events.begin(), of_events.end());
  all_watches.insert(all_watches.end(), of_contacts.begin(), of_contacts.end());
  return all_watches;
}

bool Simulation::Impl::resolve_contacts() {
  const std::size_t before = events.size();
  const std::optional<std::string> why = contacts.resolve(events);
  for (std::size_t i = before; i < events.size(); ++i) add_to_balance(events[i]);
  balance.lost_in_impacts += contacts.take_lost();
  queue.forget_looks();
  if (!why) return true;
  message = no_progress_at(world.time()) + *why;
  stalled = true;
  return false;
}

}  // namespace momentree
