// Actions of events in worlds of a batch, carried out by a Simulation of the same model.
#include <momentree/base/error.hpp>
#include <momentree/batch/batch_impl.hpp>
#include <momentree/simulate/names.hpp>

namespace momentree {

namespace {

// Numbers of the free joints of roots that broke off.
std::vector<int> made_free(const Tree& tree) {
  std::vector<int> all;
  for (int b = tree.first_root(); b >= 0; b = tree.next_sibling(b))
    if (is_detached(tree, b) && tree.kind(b) == Kind::free) all.push_back(tree.joint_of(b));
  return all;
}

}  // namespace

// Changes by edits know no names: where they left a world without them, it gets those that actions would have given.
Names Batch::Impl::names_of(int world, const Tree& tree) const {
  Names names(basis.model);
  std::span<const int> named_free;
  if (const auto known = named.find(world); known != named.end()) {
    named_free = known->second.free;
    for (const auto& [joint, name] : known->second.joints)
      joint >= first_loop ? names.add_loop(joint, name) : names.name_joint(joint, name);
    for (const auto& [root, name] : known->second.mechanisms) names.name_mechanism(root, name);
  }
  for (int k = 0; k < basis.model.size(); ++k) {
    if (tree.carrier(k) < 0 && !names.joint(k).empty()) names.remove_joint(k);
    const bool root = tree.alive(k) && tree.parent(k) < 0;
    if (!root && !names.mechanism(k).empty())
      names.name_mechanism(k, {});
    else if (root && names.mechanism(k).empty())
      names.name_mechanism(k, basis.model[BodyId{k}].name);
  }
  for (int k = first_loop; k < names.loops_end(); ++k)
    if (tree.loops().find({k}) == nullptr && !names.joint(k).empty()) names.remove_joint(k);
  for (const Loop& loop : tree.loops()) {
    const int k = loop.id().index;
    if (k < names.loops_end() && !names.joint(k).empty()) continue;
    std::string name = "loop " + std::to_string(loop.number);
    while (names.find_joint(name) >= 0) name += "~";
    names.add_loop(k, std::move(name));
  }
  for (const int joint : made_free(tree))
    if (std::find(named_free.begin(), named_free.end(), joint) == named_free.end())
      names.name_joint(joint, names.free_joint(basis.model[BodyId{tree.carrier(joint)}].name, joint));
  return names;
}

Batch::Impl::Named Batch::Impl::names_now(int world) const {
  const Names declared_names(basis.model), names = names_of(world, seat(world).group->tree());
  Named now;
  if (const auto known = named.find(world); known != named.end()) now = known->second;
  now.joints.clear(), now.mechanisms.clear();
  for (int k = 0; k < basis.model.size(); ++k) {
    if (names.joint(k) != declared_names.joint(k)) now.joints.emplace_back(k, names.joint(k));
    if (names.mechanism(k) != declared_names.mechanism(k)) now.mechanisms.emplace_back(k, names.mechanism(k));
  }
  for (int k = first_loop; k < names.loops_end(); ++k)
    if (k >= declared_names.loops_end() ? !names.joint(k).empty() : names.joint(k) != declared_names.joint(k))
      now.joints.emplace_back(k, names.joint(k));
  return now;
}

Batch::Impl::Named Batch::Impl::names_in(const World& world, Named before, bool& made_loops) const {
  WorldSnapshot now = world.snapshot();
  before.joints = std::move(now.joint_names), before.mechanisms = std::move(now.mechanism_names);
  const int later = first_loop + static_cast<int>(basis.model.loops().size());
  const auto is_later = [later](const auto& each) { return each.first >= later; };
  made_loops = made_loops || std::any_of(before.joints.begin(), before.joints.end(), is_later);
  std::erase_if(before.joints, [&](const auto& each) { return is_later(each) && each.second.empty(); });
  before.free = made_free(world.tree());
  return before;
}

WorldSnapshot Batch::Impl::snapshot_of(int world) const {
  const Seat& at = seat(world);
  const Group& group = *at.group;
  WorldSnapshot start;
  Snapshot& engine = start.engine;
  engine.topology = group.topology();
  engine.time = group.time(at.slot);
  engine.variables = group.variables();
  engine.turns.assign(group.turns(at.slot).begin(), group.turns(at.slot).end());
  engine.q.resize(static_cast<std::size_t>(group.tree().nq())), engine.y.resize(static_cast<std::size_t>(group.tree().nv()));
  group.get_values(at.slot, engine.q.data(), engine.y.data());
  if (named.contains(world) || group.tree().revision() != basis.declared.revision()) {
    Named names = names_now(world);
    start.joint_names = std::move(names.joints), start.mechanism_names = std::move(names.mechanisms);
  }
  return start;
}

Event Batch::apply(int world, std::span<const Action> actions, std::string name) {
  Impl& impl = changing();
  const Impl::Seat& seat = impl.seat(world);
  if (impl.basis.one_by_one) return impl.apply_in_simulation(world, actions, std::move(name));
  const Group& group = *seat.group;
  if (group.tree().bodies() != impl.basis.model.size())
    throw_error({"bodies were added to world " + std::to_string(world) + ", which have no names that actions could refer to", "",
                 "use the changes of topology/change.hpp"});
  Impl::Named names = impl.names_now(world);
  SimulationSnapshot start;
  start.world = impl.snapshot_of(world);

  // Numbers of loop joints must not depend on what happened in other worlds.
  if (std::exchange(impl.trial.is_used, true)) impl.trial.simulation.reset();
  if (impl.trial.simulation == nullptr)
    impl.trial.simulation = std::make_unique<Simulation>(impl.basis.model, impl.basis.integration);
  Simulation& scratch = *impl.trial.simulation;
  scratch.restore(start);
  const bool unnamed = name.empty();
  Event event = scratch.apply(actions, std::move(name));
  const World& after = scratch.world();
  impl.out.tree = after.tree();
  impl.out.state = after.state();
  put_back(world);  // may throw

  impl.trial.is_used = false;
  names = impl.names_in(after, std::move(names), impl.trial.is_used);
  ++names.events;
  if (unnamed) event.name = "#" + std::to_string(names.events);
  impl.named[world] = std::move(names);
  return event;
}

std::optional<JointId> Batch::find_joint(int world, const std::string& name) const {
  const Impl& impl = this->impl();
  const Tree& tree = impl.seat(world).group->tree();
  if (!impl.had_loops && !impl.named.contains(world) && tree.revision() == impl.basis.declared.revision() &&
      impl.basis.model.has_joint(name))
    return impl.basis.model.joint(name);
  const int number = impl.names_of(world, tree).find_joint(name);
  return number < 0 ? std::nullopt : std::optional(JointId{number});
}

std::string Batch::joint_name(int world, JointId joint) const {
  const Tree& tree = impl().seat(world).group->tree();
  if (is_loop(joint))
    return tree.loops().find(joint) != nullptr ? impl_->names_of(world, tree).joint(joint.index) : std::string();
  MT_REQUIRE(joint.index >= 0 && joint.index < tree.bodies(), "the world has or had a joint of that number");
  if (joint.index >= impl_->basis.model.size() || tree.carrier(joint.index) < 0) return {};
  for (const auto& [number, name] : impl_->names_now(world).joints)
    if (number == joint.index) return name;
  return impl_->basis.model[joint].joint_name;
}

}  // namespace momentree
