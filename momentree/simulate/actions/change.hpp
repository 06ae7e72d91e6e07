#pragma once
// Changes the kind or the axes of a joint. This is an impact unless the new joint keeps all DoFs of the old one.
#include <momentree/simulate/topology_editor.hpp>

namespace momentree::actions {

struct Change : ActionBase {
  std::string name;
  JointDescription to;

  std::string_view key() const override { return "change"; }
  std::string target() const override { return name + " to " + info(to.spec.kind).name; }
  void fields(ActionFields& fields) override {
    fields.joint("joint", name);
    fields.description(to);
  }
  std::vector<std::string> joints() const override { return {name}; }
  unsigned reshapes() const override { return ~0u; }
  ActionPhase phase(TopologyEditor& editor) const override;
  ActionResult prepare(TopologyEditor& editor) const override;
  ActionResult apply(TopologyEditor& editor) const override;

 protected:
  /// The joint that results, starting from its present pose.
  ActionResult plan(TopologyEditor& editor, JointPlan& plan) const;
};

}  // namespace momentree::actions
