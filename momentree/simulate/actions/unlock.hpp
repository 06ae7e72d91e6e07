#pragma once
// Lets a locked joint, or some of its freedoms, move again from where it stands; no velocity changes.
#include <momentree/simulate/actions/lock.hpp>

namespace momentree::actions {

struct Unlock : Lock {
  std::string_view key() const override { return "unlock"; }
  /// A motion that goes on brings its speed, as one that is set.
  ActionPhase phase(Surgery& surgery) const override {
    const JointParameters* p = parameters(surgery);
    return p != nullptr && p->drive != nullptr && p->drive->moves() ? ActionPhase::parameters : ActionPhase::release;
  }
  Verdict apply(Surgery& surgery) const override {
    unsigned wanted = 0;
    const Verdict verdict = check(surgery, wanted);
    if (verdict.outcome != Verdict::Outcome::done) return verdict;
    const int joint = surgery.joint(name);
    if ((wanted & surgery.locked(joint)) == 0) return Verdict::skipped("it is not locked");
    if (const JointParameters* p = parameters(surgery)) {
      const JointParameters all = surgery.begun(joint, *p);
      Verdict follows = surgery.can_follow(joint, all);
      if (follows.outcome != Verdict::Outcome::done) return follows;
      if (!(all == *p)) surgery.set(joint, all);
    }
    surgery.unlock(joint, wanted);
    return verdict;
  }

 private:
  const JointParameters* parameters(const Surgery& surgery) const {
    const int joint = surgery.joint(name);
    return joint < 0 ? nullptr : surgery.tree().parameters(surgery.tree().carrier(joint));
  }
};

}  // namespace momentree::actions
