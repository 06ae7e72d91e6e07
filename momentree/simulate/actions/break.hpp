#pragma once
// Removes a joint: the child's subtree becomes a mechanism of its own (paper, section 4.1).
#include <momentree/simulate/surgery.hpp>

namespace momentree::actions {

struct Break : ActionBase {
  std::string name;

  std::string_view key() const override { return "break"; }
  std::string target() const override { return name; }
  const char* plain_field() const override { return "joint"; }
  void fields(ActionFields& fields) override { fields.joint("joint", name); }
  std::vector<std::string> joints() const override { return {name}; }
  unsigned reshapes() const override { return ~0u; }
  ActionPhase phase(Surgery&) const override { return ActionPhase::release; }
  Verdict apply(Surgery& surgery) const override {
    const int joint = surgery.joint(name);
    if (joint < 0) return Verdict::skipped("the joint is not there any more");
    if (!can_break(surgery.tree(), {surgery.tree().carrier(joint)})) return Verdict::skipped("nothing is held by it: it is free");
    surgery.break_off(joint);
    return Verdict::done();
  }
};

}  // namespace momentree::actions
