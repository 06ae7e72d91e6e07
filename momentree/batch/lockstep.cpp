#include <momentree/batch/lockstep.hpp>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <utility>

#include <momentree/batch/group.hpp>
#include <momentree/simulate/simulation_impl.hpp>

namespace momentree {

using batch::Group;

struct Lockstep::Member {
  LockstepRun* run;
  Simulation::Impl* impl;
  Status status;
  Group* group = nullptr;  ///< null: it has ended
  int slot = 0;
  Group* home = nullptr;  ///< the group of the tree's revision `home_of`
  std::uint64_t home_of = 0;
  Leg leg{};
  double h = 0;       ///< s, of the present step
  bool last = false;  ///< the present step ends the leg
  int unseen = 0;     ///< steps since the callbacks were called
};

namespace {

// Trees of models with the same form, constants and parameters; the topologies are compared elsewhere.
bool same_constants(const Tree& a, const Tree& b) {
  if (a.topology().model != b.topology().model || a.gravity() != b.gravity()) return false;
  if (!std::equal(a.couplings().begin(), a.couplings().end(), b.couplings().begin(), b.couplings().end())) return false;
  return std::equal(a.order().begin(), a.order().end(), b.order().begin(), b.order().end(), [&](int x, int y) {
    const JointParameters *of_x = a.parameters(x), *of_y = b.parameters(y);
    return x == y && (of_x == of_y || (of_x != nullptr && of_y != nullptr && *of_x == *of_y));
  });
}

}  // namespace

Lockstep::Lockstep(Isa widest) : isa_(batch::best_isa(widest)) {}
Lockstep::~Lockstep() = default;

bool Lockstep::fits(const Simulation& simulation) {
  Simulation::Impl& impl = implementation(simulation, false);
  return impl.method->is_that_of_lanes() && !impl.generated.provider && !impl.stops.any() && !impl.queue.watching(impl.world) &&
         !impl.world.model().has_contact() &&
         (!impl.world.tree().has_loops() || impl.world.state().variables() == Variables::velocities) &&
         !batch::unsupported(impl.world.tree());
}

bool Lockstep::share(const Simulation& a, const Simulation& b) {
  const World &one = implementation(a, false).world, &other = implementation(b, false).world;
  return one.state().variables() == other.state().variables() && batch::same(one.tree().topology(), other.tree().topology()) &&
         same_constants(one.tree(), other.tree());
}

Group& Lockstep::group_of(const Simulation::Impl& impl) {
  const Tree& tree = impl.world.tree();
  const Topology topology = tree.topology();
  const Variables variables = impl.world.state().variables();
  for (const auto& group : groups_)
    if (group->variables() == variables && batch::same(group->topology(), topology) && same_constants(group->tree(), tree))
      return *group;
  const bool loops = tree.has_loops();
  Steps& steps = steps_of(variables, loops);
  if (tree.bodies() > steps.capacity) {
    if (loops)
      steps.stepper = batch::make_loop_lanes(isa_, tree);
    else
      steps.stepper = batch::make_stepper(isa_, Precision::float64, tree, variables);
    steps.capacity = tree.bodies();
  }
  return *groups_.emplace_back(
      std::make_unique<Group>(topology, tree, steps.stepper->lanes(), variables, steps.stepper->scalars()));
}

bool Lockstep::board(Member& member) {
  Simulation::Impl& impl = *member.impl;
  const double until = member.run->until;
  while (member.status == Status::ok && impl.world.time() < until) {
    if (!fits(*member.run->simulation)) {
      member.status = impl.advance(until, Status::ok);
      break;
    }
    member.leg = leg_to(impl.world, impl.next_end(until));
    if (member.leg.target <= impl.world.time()) {
      impl.set_time(member.leg.end);
      member.status = impl.finish_step(until);
      continue;
    }
    if (const std::uint64_t revision = impl.world.tree().revision(); member.home == nullptr || member.home_of != revision)
      member.home = &group_of(impl), member.home_of = revision;
    member.group = member.home;
    member.slot = member.group->add(static_cast<int>(&member - members_.data()));
    member.group->set_state(member.slot, impl.world.state());
    member.group->set_diverged(member.slot, false);
    member.group->set_efforts(member.slot, {});
    member.unseen = 0;
    set_step(member);
    return member.group != nullptr;
  }
  finish(member);
  return false;
}

void Lockstep::leave(Member& member) {
  const int moved = member.group->remove(member.slot);
  if (moved >= 0) members_[static_cast<std::size_t>(moved)].slot = member.slot;
  member.group = nullptr;
}

void Lockstep::set_step(Member& member) {
  const double time = member.group->time(member.slot);
  const auto [h, last] = step_from(*member.impl->method, time, member.leg.target);
  member.h = h, member.last = last;
  if (h > 0) return member.group->set_step(member.slot, h);
  take_state(member);
  member.impl->note_short_step(member.leg.target);
  member.status = Status::stalled;
  leave(member);
  finish(member);
}

void Lockstep::take_state(Member& member) {
  const Group& group = *member.group;
  const State::Edit edit = member.impl->world.edit().state().edit();
  group.get_values(member.slot, edit.q.data(), edit.y.data());
  edit.time = group.time(member.slot);
  if (group.tree().has_loops()) member.impl->world.edit().state().set_turns(group.turns(member.slot));
}

void Lockstep::after_step(Member& member) {
  Simulation::Impl& impl = *member.impl;
  const double until = member.run->until;
  if (member.group->diverged(member.slot)) {  // the simulation repeats the step alone and reports why
    take_state(member);
    leave(member);
    member.status = impl.advance(until, Status::ok);
    return finish(member);
  }
  ++impl.statistics.steps;
  impl.evaluate.count += 4;
  const bool observed = impl.observers.sampler || (impl.observers.observer && impl.observers.every == 0);
  if (!member.last && !observed && ++member.unseen < steps_between_calls) return set_step(member);
  member.unseen = 0;
  take_state(member);
  if (member.last) impl.set_time(member.leg.end);
  member.status = impl.finish_step(until);
  if (member.status == Status::ok && !member.last) return set_step(member);  // events happen only at the end of a leg
  leave(member);
  board(member);
}

void Lockstep::finish(Member& member) { member.run->result = member.impl->end_run(member.status); }

void Lockstep::run(std::span<LockstepRun> runs) {
  const bool in_use = std::any_of(groups_.begin(), groups_.end(), [](const auto& group) { return group->worlds() > 0; });
  if (in_use || groups_.size() > 64) groups_.clear();  // in use only if the last call ended by an exception
  members_.clear();
  members_.reserve(runs.size());
  std::deque<Activity::During> working;
  for (LockstepRun& run : runs) {
    Simulation::Impl& impl = implementation(*run.simulation, true);
    impl.energy.settle(impl.world);
    if (impl.outcome.diverged) {
      run.result = impl.run(run.until);
      continue;
    }
    working.emplace_back(impl.activity.doing, Activity::Doing::working);
    members_.push_back({&run, &impl, impl.start_run(run.until)});
  }
  for (Member& member : members_) board(member);
  for (bool any = true; any;) {
    any = false;
    for (const auto& group : groups_)
      for (int i = 0; i < group->blocks(); ++i) {
        any = true;
        steps_of(group->variables(), group->tree().has_loops()).stepper->step(group->tree(), group->plan(), group->block(i));
      }
    if (!any) break;
    for (Member& member : members_)
      if (member.group != nullptr) after_step(member);
  }
}

}  // namespace momentree
