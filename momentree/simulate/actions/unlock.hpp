#pragma once
// Lets a locked joint, or some of its freedoms, move again from where it stands; no velocity changes.
#include <momentree/simulate/actions/lock.hpp>

namespace momentree::actions {

struct Unlock : Lock {
  std::string_view key() const override { return "unlock"; }
  ActionPhase phase(Surgery&) const override { return ActionPhase::release; }
  Verdict apply(Surgery& surgery) const override {
    unsigned wanted = 0;
    const Verdict verdict = check(surgery, wanted);
    if (verdict.outcome != Verdict::Outcome::done) return verdict;
    const int joint = surgery.joint(name);
    if ((wanted & surgery.locked(joint)) == 0) return Verdict::skipped("it is not locked");
    surgery.unlock(joint, wanted);
    return verdict;
  }
};

}  // namespace momentree::actions
