// Steps of a simulation, from one instant at which something may happen to the next.
#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

void Simulation::Impl::make_methods() {
  const auto make = [&](const std::string& name) {
    std::unique_ptr<Integrator> made =
        make_integrator(name, world.tree(), {integration.step, integration.rtol, integration.atol, integration.max_step});
    made->use(&contact.steps);
    return made;
  };
  contact.steps.set_usual_step(integration.step);
  method = make(integration.method);
  contact.method_steps = steps_through_contacts(integration.method);
  contact.geometry.stepped.set_all(contact.method_steps && contact.geometry.pairs.any());
  stops.use(contact.steps);
  contact.stepper = world.model().has_contact() ? make(contact_stepping_method()) : nullptr;
  if (contact.stepper == nullptr) contact.stepping = {}, contact.geometry.stepped.set({});
  if (contact.stepper != nullptr) contact.steps.points.set({}, true);  // their numbers are those of the former bodies
}
void Simulation::Impl::note_short_step(double target) {
  const double usual = present_method().next_step(target - world.time());
  outcome.stall(no_progress_at(world.time()) + "a step of " + detail::text(usual) + " s is too short to move the clock");
}

// One step towards `end`.
bool Simulation::Impl::step_towards(double end) {
  const Leg leg = leg_to(world, end);
  end = leg.end;
  if (leg.target <= world.time()) {
    set_time(end);
    return true;
  }
  const auto [h, last] = step_from(present_method(), world.time(), leg.target);
  if (!(h > 0)) {
    note_short_step(leg.target);
    return false;
  }
  ask_for_generated();
  const auto start = Clock::now();
  evaluate_state();
  note_kinetic_energy();
  if (stops.any() || contact.geometry.pairs.any() || queue.watching(world)) return step_and_look(h, last ? end : HUGE_VAL, start);
  const double stepped = method->advance(evaluate, world.edit().state(), energy.ledger, h);
  if (stepped == 0) {
    report_divergence(h);
    return false;
  }
  if (last && stepped == h) set_time(end);
  ++statistics.steps;
  const double taken = detail::seconds_since(start);
  statistics.worst_step_seconds = std::max(statistics.worst_step_seconds, taken);
  return true;
}

// The same for joints with stops or events with conditions: the step may end earlier and an event happen there. `end`: the end
// of a full step.
bool Simulation::Impl::step_and_look(double h, double end, Clock::time_point start) {
  double most = h;
  if (contact.geometry.pairs.any() && (contact.steps_through() || contact.some_step())) contact.steps.begin_step();
  stops.share();
  if (contact.some_step()) {
    // The evaluation of the state has the forces of contacts in the last step: this one is made without them.
    contact.steps.points.release();
    evaluate_state();
  }
  // Where nothing moves, adaptive steps grow whatever forces do: these must not rise and fall again within one.
  if (present_method().adaptive()) most = std::min(most, 0.25 * shortest_period(world.tree()));
  const std::span<const Watch> watched = contact.watches(most);
  const bool closed = !world.tree().contacts().empty();
  if (closed) contact.note_before_step();
  // Where prescribed motions press bodies against others that cannot give way, contacts bring in energy without bounds; and where
  // bodies without inertia come to lie so that some motion moves no mass.
  const bool through = contact.geometry.pairs.any() && (contact.steps_through() || contact.some_step());
  const bool pressing = through && has_motions(world.tree()), unsafe = pressing || (through && has_thin_bodies(world.model()));
  const double scale = unsafe ? energy_scale() : 0, taken = energy.ledger.impacts, projected = energy.ledger.projection;
  const auto exploded = [&] {
    const double most_gained = pressing ? 1e3 : 1;  // impacts of what moves change the energy by its scale at most
    const double gained = std::fabs(energy.ledger.impacts - taken) + std::fabs(energy.ledger.projection - projected);
    if (!unsafe || gained <= most_gained * scale) return false;
    contact.undo_step();
    if (pressing)
      report_pressing(gained);
    else
      report_divergence(h);
    return true;
  };
  if (unsafe && !closed) contact.note_before_step();
  std::optional<double> stepped = stops.step(present_method(), energy.ledger, most, watched);
  if (closed && stepped && contact.contacts.watches.slip.kept_too_much()) {
    contact.undo_step();
    contact.contacts.watches.slip.keep_less();
    contact.note_before_step();  // it changes what the state belongs to
    stepped = stops.step(present_method(), energy.ledger, most, watched);
  }
  if (stepped && exploded()) return false;
  if (closed && (!stepped || contact.gained_energy())) {
    const std::vector<int> where = most_loaded(contact.geometry.world);
    contact.undo_step();
    contact.begin_stepping("the forces of contacts grow without bounds", where);
    return true;
  }
  if (!stepped) {
    report_divergence(h);
    return false;
  }
  if (*stepped == h && std::isfinite(end)) set_time(end);
  ++statistics.steps;
  if (!contact.resolve_after_step(*stepped) || exploded()) return false;
  contact.judge_steps();
  statistics.worst_step_seconds = std::max(statistics.worst_step_seconds, detail::seconds_since(start));
  return true;
}

}  // namespace momentree
