// Worlds of a batch that are stepped one by one, each by a simulation of its own: with contact, and with what lanes do not have.
#include <algorithm>
#include <exception>
#include <limits>

#include <momentree/base/error.hpp>
#include <momentree/batch/batch_impl.hpp>

namespace momentree {

using batch::SimulatedWorld;

// Those after the first cannot fail for another reason than that there is no more memory.
void Batch::Impl::make_simulations(std::span<const int> worlds) {
  std::vector<std::unique_ptr<SimulatedWorld>> made(worlds.size());
  if (!made.empty()) made[0] = std::make_unique<SimulatedWorld>(basis.model, basis.integration);
  std::exception_ptr failed;
  std::mutex mutex;
  pool.run(static_cast<int>(worlds.size()) - 1, [&](int, int i) {
    try {
      made[static_cast<std::size_t>(i) + 1] = std::make_unique<SimulatedWorld>(basis.model, basis.integration);
    } catch (...) {
      const std::lock_guard lock(mutex);
      failed = std::current_exception();
    }
  });
  if (failed) std::rethrow_exception(failed);
  for (std::size_t i = 0; i < made.size(); ++i) simulated[static_cast<std::size_t>(worlds[i])] = std::move(made[i]);
}

void Batch::Impl::prepare_simulation(int world, SimulatedWorld::Use use) {
  SimulatedWorld& run = *simulated[static_cast<std::size_t>(world)];
  if (run.is_changed()) run.restart(snapshot_of(world), basis.model);
  run.prepare(use);
}

void Batch::Impl::step_simulations(const std::function<double(int)>& step_of) noexcept {
  const int worlds = static_cast<int>(simulated.size());
  pool.run(worlds, [&](int, int world) { step_simulation(world, step_of(world)); });
  for (int world = 0; world < worlds; ++world)
    if (simulated[static_cast<std::size_t>(world)]->moves) change_group(world);
}

void Batch::Impl::step_simulation(int world, double h) noexcept {
  SimulatedWorld& run = *simulated[static_cast<std::size_t>(world)];
  const Seat at = seat(world);
  if (h == 0 || at.group->diverged(at.slot)) return;
  try {
    prepare_simulation(world, SimulatedWorld::Use::step);
    run.message = run.step(h);
  } catch (const std::exception& error) {
    run.message = error.what();
  }
  if (run.message.empty()) return copy_to_group(world);
  at.group->set_diverged(at.slot, true);
  run.changed();  // the simulation ended somewhere else
}

void Batch::Impl::copy_to_group(int world) {
  SimulatedWorld& run = *simulated[static_cast<std::size_t>(world)];
  const Seat at = seat(world);
  run.moves = run.left(at.group->topology(), basis.declared);
  if (!run.moves) at.group->set_state(at.slot, run.simulation().world().state());
}

void Batch::Impl::change_group(int world) {
  SimulatedWorld& run = *simulated[static_cast<std::size_t>(world)];
  const Seat from = seat(world);
  const World& now = run.simulation().world();
  const bool away = from.group->diverged(from.slot);
  run.moves = false;
  Named names = names_in(now, names_now(world), run.made_loops);
  Group& to = group_of(run.topology(), now.tree());
  drop_efforts(world, from.group->tree(), to.tree());
  sit(world, to);
  leave(from);
  const int slot = seat(world).slot;
  to.set_diverged(slot, away);
  to.set_efforts(slot, efforts[static_cast<std::size_t>(world)]);
  to.set_state(slot, now.state());
  named[world] = std::move(names);
}

Event Batch::Impl::apply_in_simulation(int world, std::span<const Action> actions, std::string name) {
  SimulatedWorld& run = *simulated[static_cast<std::size_t>(world)];
  prepare_simulation(world, SimulatedWorld::Use::step);
  const bool unnamed = name.empty();
  Event event = run.simulation().apply(actions, std::move(name));  // may throw, with nothing changed
  copy_to_group(world);
  if (run.moves) change_group(world);
  Named names = names_in(run.simulation().world(), names_now(world), run.made_loops);
  ++names.events;
  if (unnamed) event.name = "#" + std::to_string(names.events);
  named[world] = std::move(names);
  return event;
}

std::vector<ContactPoint> Batch::contacts(int world) const {
  impl().seat(world);
  if (!impl_->basis.one_by_one) return {};
  impl_->prepare_simulation(world, SimulatedWorld::Use::read);
  return impl_->simulated[static_cast<std::size_t>(world)]->simulation().world().contacts();
}

void Batch::contact_forces(std::span<const int> worlds, BodyId body, double* forces) const {
  Impl& impl = this->impl();
  MT_REQUIRE(body == ground || (body.index >= 0 && body.index < impl.basis.model.size()), "the ground or a body of the model");
  std::vector<int> once(worlds.begin(), worlds.end());  // no world is prepared by two threads
  std::sort(once.begin(), once.end());
  once.erase(std::unique(once.begin(), once.end()), once.end());
  for (const int world : once) impl.seat(world);
  if (impl.basis.one_by_one)
    impl.pool.run(static_cast<int>(once.size()),
                  [&](int, int i) { impl.prepare_simulation(once[static_cast<std::size_t>(i)], SimulatedWorld::Use::read); });
  impl.pool.run(static_cast<int>(worlds.size()), [&](int, int i) {
    const auto row = static_cast<std::size_t>(i);
    const Tree& tree = impl.seat(worlds[row]).group->tree();
    Vec3 force{};
    if (body != ground && !tree.alive(body.index)) {
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      force = {none, none, none};
    } else {
      for (const ContactPoint& point : contacts(worlds[row])) {
        if (point.one == body) force += point.force;
        if (point.other == body) force += -point.force;
      }
    }
    forces[3 * row] = force.x, forces[3 * row + 1] = force.y, forces[3 * row + 2] = force.z;
  });
}

std::span<const Event> Batch::events(int world) const {
  impl().seat(world);
  if (!impl_->basis.one_by_one) return {};
  return impl_->simulated[static_cast<std::size_t>(world)]->events();
}

std::string Batch::message(int world) const {
  if (!diverged(world)) return {};
  if (!impl_->basis.one_by_one) return "the step diverged, or ended where loops can't be closed; use a shorter one";
  return impl_->simulated[static_cast<std::size_t>(world)]->message;
}

}  // namespace momentree
