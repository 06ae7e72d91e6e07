#pragma once
// Removes a joint: the child's subtree becomes a separate mechanism (paper, section 4.1). Or removes a spring.
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree::actions {

struct Break : ActionBase {
  std::string name;

  std::string_view key() const override { return "break"; }
  const char* summary() const override {
    return "Removes a joint: the child's subtree becomes a separate mechanism; or a spring";
  }
  const char* hint() const override { return R"(a name, or for example { joint = "arm/elbow" })"; }
  std::string target() const override { return name; }
  const char* plain_field() const override { return "joint"; }
  void fields(ActionFields& fields) override { fields.joint("joint", name); }
  std::vector<std::string> joints() const override { return {name}; }
  bool takes_springs() const override { return true; }
  unsigned reshapes() const override { return ~0u; }
  JointEffect effect() const override { return JointEffect::removed; }
  ActionPhase phase(TopologyEditor&) const override { return ActionPhase::release; }
  ActionResult apply(TopologyEditor& editor) const override {
    if (const int spring = editor.spring(name); spring >= 0) {
      if (!spring_acts(editor.tree(), spring)) return ActionResult::skipped("the spring is broken already");
      editor.break_spring(spring);
      return ActionResult::done();
    }
    const int joint = editor.joint(name);
    if (joint < 0) return ActionResult::skipped(joint_is_gone);
    if (!is_loop({joint}) && !can_break(editor.tree(), {joint}))
      return ActionResult::skipped("it holds nothing: the body is already free");
    editor.break_off(joint);
    return ActionResult::done();
  }
};

}  // namespace momentree::actions
