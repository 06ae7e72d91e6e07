// Adding bodies to a running world and removing them.
#include <cmath>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree {

BodyId World::add(BodySpec spec, std::vector<contact::Solid> collision) {
  if (spec.parent != ground && !alive(spec.parent)) throw_error({"the parent is no body of this world", spec.name, ""});
  const std::string joint = spec.joint_name.empty() ? spec.name : spec.joint_name;
  if (names_.find_joint(joint) >= 0)
    throw_error({"there is already a joint '" + joint + "'", spec.name, "give the new one another name"});
  Model trial;  // throws for what is no solid
  for (const contact::Solid& solid : collision) trial.add_collider({.solid = solid});
  const WorldSnapshot before = snapshot();
  const JointDrive* drive = spec.joint.parameters.drive.get();
  if (drive != nullptr && drive->motion.size() == 1) {
    const Curve::Point now = drive->motion[0].at(time());
    spec.q = now.value, spec.v = now.rate;
  }
  const BodyId body = model_.add(std::move(spec));
  if (tree_.has_loops()) take_variables(Variables::velocities);
  evaluate();
  const double kinetic = totals().kinetic;
  apply(Add{&model_[body]}, tree_, state_, workspace_);
  declared_ = Names(model_);
  names_.add(joint, declared_.mechanism(body.index));
  make_room();
  // A DoF that moves no mass is detected by its effect on the motion.
  evaluate();
  const double now = totals().kinetic;
  if (!std::isfinite(now) || now < kinetic * (1 - 1e-3)) {
    const std::string name = model_[body].name;
    restore(before);
    throw_error(
        {"the joint '" + joint + "' would move no mass or inertia", name, "give the body a mass and an inertia, or weld it"});
  }
  for (contact::Solid& solid : collision) model_.add_collider({.body = body, .solid = std::move(solid)});
  return body;
}

void World::remove(BodyId body) {
  if (!alive(body)) throw_error({"the body is no longer in this world", "", ""});
  const int b = body.index;
  Event ledger;
  TopologyEditor editor(*this);
  editor.begin(ledger, "");
  const auto outboard = [&](int x) {
    while (x >= 0 && x != b) x = tree_.parent(x);
    return x == b;
  };
  for (const JointId loop : loops())
    if (const Loop& each = *tree_.loops().find(loop); outboard(each.body) || outboard(each.to)) editor.break_off(loop.index);
  const int joint = tree_.joint_of(b);
  if (can_break(tree_, tree_.inboard_joint(body))) {
    editor.break_off(joint);
  } else {  // a free joint to the ground: only its forces and locks need to be removed
    if (tree_.parameters(b) != nullptr) editor.set(joint, {});
    if (tree_.joint(b).function >= 0) drive(joint, {});
    if (tree_.joint(b).locked != 0) editor.unlock(joint, ~0u);
  }
  evaluate();
  std::vector<int> gone;
  for (const int x : tree_.order())
    if (root_of(tree_, {x}).index == b) gone.push_back(x);
  std::vector<int> joints;
  for (const int x : gone) joints.push_back(tree_.joint_of(x));
  apply(Remove{body}, tree_, state_, workspace_);
  for (const int j : joints) names_.remove_joint(j);
  for (const int x : gone) names_.name_mechanism(x, {});
  std::erase_if(constraints_.active_limits, [&](const ActiveLimit& h) {
    return is_loop({h.joint}) ? tree_.loops().find({h.joint}) == nullptr : tree_.carrier(h.joint) < 0;
  });
}

void World::make_room() {
  workspace_ = Workspace<double>(tree_);
  motions_.resize(static_cast<std::size_t>(model_.size()));
  motions_of_ = accelerations_of_ = {};
}

}  // namespace momentree
