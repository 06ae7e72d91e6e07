#pragma once
// Releases a locked joint, or some of its DoFs, from its present position; no velocity changes.
#include <momentree/simulate/actions/lock.hpp>

namespace momentree::actions {

struct Unlock : Lock {
  std::string_view key() const override { return "unlock"; }
  const char* summary() const override { return "Releases a locked joint, or some of its DoFs"; }
  JointEffect effect() const override { return JointEffect::released; }
  /// A prescribed motion that resumes imposes its speed, like one that is newly set.
  ActionPhase phase(TopologyEditor& editor) const override {
    const JointParameters* p = parameters(editor);
    return p != nullptr && p->drive != nullptr && p->drive->moves() ? ActionPhase::parameters : ActionPhase::release;
  }
  ActionResult apply(TopologyEditor& editor) const override {
    unsigned wanted = 0;
    const ActionResult result = check(editor, wanted);
    if (result.outcome != ActionResult::Outcome::done) return result;
    const int joint = editor.joint(name);
    if ((wanted & editor.locked(joint)) == 0) return ActionResult::skipped("it is not locked");
    ActionResult possible = editor.can_hold(joint, editor.locked(joint) & ~wanted);
    if (possible.outcome != ActionResult::Outcome::done) return possible;
    if (const JointParameters* p = parameters(editor)) {
      const JointParameters all = editor.begun(joint, *p);
      ActionResult follows = editor.can_follow(joint, all);
      if (follows.outcome != ActionResult::Outcome::done) return follows;
      if (!(all == *p)) editor.set(joint, all);
    }
    editor.unlock(joint, wanted);
    return result;
  }

 private:
  const JointParameters* parameters(const TopologyEditor& editor) const {
    const int joint = editor.joint(name);
    return joint < 0 ? nullptr : editor.parameters(joint);
  }
};

}  // namespace momentree::actions
