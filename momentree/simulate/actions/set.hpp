#pragma once
// New parameters for a joint: velocities stay.
#include <momentree/simulate/surgery.hpp>

namespace momentree::actions {

struct Set : ActionBase {
  std::string name;
  JointParameters parameters;  ///< those that are not empty replace the joint's own

  std::string_view key() const override { return "set"; }
  std::string target() const override { return name; }
  void fields(ActionFields& fields) override {
    fields.joint("joint", name);
    fields.parameters(name, parameters);
  }
  std::vector<std::string> joints() const override { return {name}; }
  ActionPhase phase(Surgery&) const override { return ActionPhase::parameters; }
  Verdict apply(Surgery& surgery) const override {
    const int joint = surgery.joint(name);
    if (joint < 0) return Verdict::skipped("the joint is not there any more");
    JointParameters all;
    if (const JointParameters* own = surgery.tree().parameters(surgery.tree().carrier(joint))) all = *own;
    const auto take = [](Values& to, const Values& from) {
      if (!from.empty()) to = from;
    };
    take(all.damping, parameters.damping);
    take(all.stiffness, parameters.stiffness);
    take(all.rest, parameters.rest);
    take(all.armature, parameters.armature);
    // A drive is replaced as a whole.
    if (!parameters.effort.empty() || parameters.drive) all.effort = parameters.effort, all.drive = parameters.drive;
    if (parameters.limits.any()) all.limits = parameters.limits;
    if (!parameters.friction.coulomb.empty()) all.friction = parameters.friction;
    if (parameters.strength.any()) all.strength = parameters.strength;
    JointSpec spec = spec_of(surgery.declared(joint));
    spec.parameters = all;
    for (const JointProblem& problem : check_joint(spec))
      return Verdict::refused(problem.field + ": " + problem.what, problem.hint);
    surgery.set(joint, all);
    return Verdict::done();
  }
};

}  // namespace momentree::actions
