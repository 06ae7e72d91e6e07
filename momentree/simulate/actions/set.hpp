#pragma once
// New parameters for a joint; velocities stay.
#include <momentree/simulate/topology_editor.hpp>

namespace momentree::actions {

struct Set : ActionBase {
  std::string name;
  JointParameters parameters;  ///< those given replace the joint's own; a drive or an effort replaces the whole drive

  std::string_view key() const override { return "set"; }
  const char* summary() const override { return "Sets new parameters of a joint; those that are not given stay"; }
  const char* hint() const override { return R"(for example set = { joint = "arm/elbow", damping = 0.1 })"; }
  std::string target() const override { return name; }
  void fields(ActionFields& fields) override {
    fields.joint("joint", name);
    fields.parameters(name, parameters);
  }
  std::vector<std::string> joints() const override { return {name}; }
  ActionPhase phase(TopologyEditor&) const override { return ActionPhase::parameters; }
  ActionResult apply(TopologyEditor& editor) const override {
    const int joint = editor.joint(name);
    const JointId loop = editor.loop(name);
    if (joint < 0 && loop.index < 0) return editor.missing(name);
    JointParameters all;
    if (const JointParameters* own = editor.parameters(name)) all = *own;
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
    if (loop.index >= 0) return set_loop(editor, loop, all);
    JointSpec spec = spec_of(editor.declared(joint));
    spec.parameters = all;
    for (const JointProblem& problem : check_joint(spec))
      return ActionResult::refused(problem.field + ": " + problem.what, problem.hint);
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

 private:
  static ActionResult set_loop(TopologyEditor& editor, JointId loop, const JointParameters& all) {
    const Loop& now = *editor.tree().find_loop(loop.index - first_loop);
    LoopSpec spec;
    spec.name = editor.joint_name(loop.index), spec.body = {now.body}, spec.to = {now.to};
    spec.joint = spec_of(now.joint);
    spec.joint.parameters = all;
    for (const BodyProblem& problem : check_loop(spec, editor.tree().bodies()))
      return ActionResult::refused(problem.field + ": " + problem.what, problem.hint);
    editor.set_loop(loop, all);
    return ActionResult::done();
  }
};

}  // namespace momentree::actions
