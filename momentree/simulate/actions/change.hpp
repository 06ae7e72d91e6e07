#pragma once
// Makes a joint one of another kind or on other axes. Where the freedoms become fewer or others, that is an impact.
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
  /// What the joint shall become, from where it is now.
  ActionResult plan(TopologyEditor& editor, JointPlan& plan) const;
};

}  // namespace momentree::actions
