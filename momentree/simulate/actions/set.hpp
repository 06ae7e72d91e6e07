#pragma once
// New parameters for a joint or a spring; velocities stay.
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree::actions {

struct Set : ActionBase {
  std::string name;
  JointParameters parameters;  ///< those given replace the joint's own; a drive or an effort replaces the whole drive

  std::string_view key() const override { return "set"; }
  const char* summary() const override { return "Sets new parameters of a joint or a spring; those that are not given stay"; }
  const char* hint() const override { return R"(for example set = { joint = "arm/elbow", damping = 0.1 })"; }
  std::string target() const override { return name; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"joint", argument::Joint{name}});
    visit({"parameters", argument::Parameters{parameters, name}});
  }
  std::vector<std::string> joints() const override { return {name}; }
  bool takes_springs() const override { return true; }
  ActionPhase phase(TopologyEditor&) const override { return ActionPhase::parameters; }
  ActionResult apply(TopologyEditor& editor) const override {
    if (const int spring = editor.spring(name); spring >= 0) return editor.set_spring(spring, parameters);
    const int joint = editor.joint(name);
    if (joint < 0) return ActionResult::skipped(joint_is_gone);
    if (parameters == JointParameters{}) return ActionResult::skipped("a weld has no degree of freedom");
    JointParameters all;
    if (const JointParameters* own = editor.parameters(joint)) all = *own;
    const auto take = [](Values& to, const Values& from) {
      if (!from.empty()) to = from;
    };
    take(all.damping, parameters.damping);
    take(all.stiffness, parameters.stiffness);
    take(all.rest, parameters.rest);
    take(all.armature, parameters.armature);
    if (!parameters.effort.empty() || parameters.drive != nullptr) {  // as a whole
      all.effort = parameters.effort;
      all.drive = parameters.drive;
    }
    if (parameters.limits.any()) all.limits = parameters.limits;
    take(all.friction.coulomb, parameters.friction.coulomb);
    take(all.friction.speed, parameters.friction.speed);
    if (parameters.strength.any()) all.strength = parameters.strength;
    JointSpec spec = spec_of(editor.declared(joint));
    spec.parameters = all;
    for (const JointProblem& problem : check_joint(spec))
      return ActionResult::refused(problem.field + ": " + problem.what, problem.hint);
    if (ActionResult result = editor.supports(joint, all); result.outcome != ActionResult::Outcome::done) return result;
    if (ActionResult result = editor.is_within(editor.coordinates(joint), parameters.limits);
        result.outcome != ActionResult::Outcome::done)
      return result;
    if (ActionResult result = editor.can_be_stopped(joint, all); result.outcome != ActionResult::Outcome::done) return result;
    if (all.drive != nullptr && all.drive->moves() && editor.declared(joint).function >= 0)
      return ActionResult::refused("a function drives the joint, so its motion can't be prescribed", "remove the function first");
    if ((editor.declared(joint).locked & 1u) == 0) {
      all = editor.begun(joint, std::move(all));
      ActionResult follows = editor.can_follow(joint, all);
      if (follows.outcome != ActionResult::Outcome::done) return follows;
    }
    editor.set(joint, all);
    return ActionResult::done();
  }
};

}  // namespace momentree::actions
