#pragma once
// Changes the kind or the axes of a joint. This is an impact unless the new joint keeps all DoFs of the old one.
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree::actions {

struct Change : ActionBase {
  std::string name;
  JointDescription to;

  std::string_view key() const override { return "change"; }
  const char* summary() const override { return "Changes a joint to another kind, or to other axes"; }
  const char* hint() const override { return R"(for example change = { joint = "arm/elbow", kind = "ball" })"; }
  std::string target() const override { return name + " to " + info(to.spec.kind).name; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"joint", argument::Joint{name}});
    visit({"to", argument::Description{to, true}});
  }
  std::vector<std::string> joints() const override { return {name}; }
  unsigned reshapes() const override { return ~0u; }
  JointEffect effect() const override { return JointEffect::replaced; }
  std::optional<Kind> resulting_kind() const override { return to.spec.kind; }
  ActionPhase phase(TopologyEditor& editor) const override;
  ActionResult prepare(TopologyEditor& editor) const override;
  ActionResult apply(TopologyEditor& editor) const override;

 protected:
  /// The joint that results, starting from its present pose.
  ActionResult plan(TopologyEditor& editor, JointPlan& plan) const;
};

}  // namespace momentree::actions
