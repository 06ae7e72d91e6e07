#pragma once
// Locks a joint, or some of its DoFs, where it is: a plastic impact that removes their momenta.
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree::actions {

struct Lock : ActionBase {
  std::string name;
  std::vector<int> dofs;  ///< indices in the order of v; empty: all

  std::string_view key() const override { return "lock"; }
  const char* summary() const override { return "Locks a joint, or some of its DoFs, in its current position"; }
  const char* hint() const override { return R"(a name, or for example { joint = "arm/elbow", freedoms = [0] })"; }
  std::string target() const override { return name + listed(); }
  const char* plain_argument() const override { return "joint"; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"joint", argument::Joint{name}});
    visit({"freedoms", argument::Dofs{dofs}});
  }
  std::vector<std::string> joints() const override { return {name}; }
  unsigned reshapes() const override { return mask(); }
  JointEffect effect() const override { return JointEffect::held; }
  ActionPhase phase(TopologyEditor&) const override { return ActionPhase::impact; }
  ActionResult apply(TopologyEditor& editor) const override {
    unsigned wanted = 0;
    const ActionResult result = check(editor, wanted);
    if (result.outcome != ActionResult::Outcome::done) return result;
    const int joint = editor.joint(name);
    if ((wanted & ~editor.locked(joint)) == 0) return ActionResult::skipped("it is already locked");
    editor.lock(joint, wanted);
    return result;
  }

 protected:
  unsigned mask() const {
    unsigned bits = dofs.empty() ? ~0u : 0;
    for (const int i : dofs)
      if (i >= 0 && i < 32) bits |= 1u << i;  // others are refused
    return bits;
  }
  std::string listed() const {
    std::string text;
    for (const int i : dofs) text += (text.empty() ? " [" : ", ") + std::to_string(i);
    return text.empty() ? text : text + "]";
  }
  ActionResult check(const TopologyEditor& editor, unsigned& wanted) const {
    const int joint = editor.joint(name);
    if (joint < 0) return ActionResult::skipped(joint_is_gone);
    const KindInfo& kind = info(editor.declared(joint).kind);
    if (kind.nv == 0) return ActionResult::skipped("a " + std::string(kind.name) + " has no degree of freedom");
    for (const int i : dofs)
      if (i < 0 || i >= kind.nv)
        return ActionResult::refused(
            "joint '" + name + "' has no degree of freedom " + std::to_string(i),
            "a " + std::string(kind.name) + " joint has degrees of freedom 0 to " + std::to_string(kind.nv - 1));
    wanted = mask() & ((1u << kind.nv) - 1);
    return ActionResult::done();
  }
};

}  // namespace momentree::actions
