#pragma once
// Joins a body to another mechanism or to the ground by a joint of any kind: a plastic impact in the directions that the joint
// constrains.
#include <momentree/joint/motion.hpp>
#include <momentree/math/unit.hpp>
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree::actions {

struct Attach : ActionBase {
  std::string body, to = "ground", name;
  JointDescription joint;
  std::optional<Pose> at;

  std::string_view key() const override { return "attach"; }
  const char* summary() const override { return "Joins a body to another, or to the ground, by a joint of any kind"; }
  const char* hint() const override { return R"(for example attach = { body = "load/hook", to = "crane/rope", kind = "ball" })"; }
  std::string target() const override { return body + " to " + to; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"body", argument::Body{body}});
    visit({"to", argument::OtherBody{to}});
    visit({"at", at, Field{"Placement of the joint's frame in the frame of `to`"}});
    visit({"joint", argument::Description{joint, false}});
    visit({"name", argument::MadeJoint{name}});
  }
  std::vector<std::string> bodies() const override {
    return to == "ground" ? std::vector<std::string>{body} : std::vector<std::string>{body, to};
  }
  std::string makes() const override { return to + "+" + body; }
  std::string made_name() const override { return name; }
  std::optional<Kind> resulting_kind() const override { return joint.spec.kind; }
  ActionPhase phase(TopologyEditor&) const override { return ActionPhase::impact; }
  ActionResult apply(TopologyEditor& editor) const override {
    const int one = editor.body(body), other = editor.body(to);
    if (one < 0) return ActionResult::refused("there is no body '" + body + "' to join to another");
    if (other < -1) return ActionResult::refused("there is no body '" + to + "' to join to");
    JointSpec spec = joint.spec;
    for (const JointProblem& problem : check_joint(spec))
      return ActionResult::refused(problem.field + ": " + problem.what, problem.hint);
    if (ActionResult result = editor.is_within(joint_zero(spec.kind), spec.parameters.limits, true);
        result.outcome != ActionResult::Outcome::done)
      return result;
    if (at && !is_placement(*at)) return ActionResult::refused("at: the placement must be finite, with a quaternion of length 1");
    if (info(spec.kind).axis) spec.axis = normalized(spec.axis);
    if (info(spec.kind).axis2) spec.axis2 = normalized(spec.axis2);
    return editor.attach(one, other, spec, at);
  }
};

}  // namespace momentree::actions
