#pragma once
// Freezes a joint, or some of its freedoms, where it is: a plastic impact that drops their momenta.
#include <momentree/simulate/surgery.hpp>

namespace momentree::actions {

struct Lock : ActionBase {
  std::string name;
  std::vector<int> freedoms;  ///< in the order of v; empty: all

  std::string_view key() const override { return "lock"; }
  std::string target() const override { return name + listed(); }
  const char* plain_field() const override { return "joint"; }
  void fields(ActionFields& fields) override {
    fields.joint("joint", name);
    fields.freedoms("freedoms", name, freedoms);
  }
  std::vector<std::string> joints() const override { return {name}; }
  unsigned reshapes() const override { return mask(); }
  ActionPhase phase(Surgery&) const override { return ActionPhase::impact; }
  Verdict apply(Surgery& surgery) const override {
    unsigned wanted = 0;
    const Verdict verdict = check(surgery, wanted);
    if (verdict.outcome != Verdict::Outcome::done) return verdict;
    const int joint = surgery.joint(name);
    if ((wanted & ~surgery.locked(joint)) == 0) return Verdict::skipped("it is locked already");
    surgery.lock(joint, wanted);
    return verdict;
  }

 protected:
  unsigned mask() const {
    unsigned bits = freedoms.empty() ? ~0u : 0;
    for (const int i : freedoms)
      if (i >= 0 && i < 32) bits |= 1u << i;  // others are refused
    return bits;
  }
  std::string listed() const {
    std::string text;
    for (const int i : freedoms) text += (text.empty() ? " [" : ", ") + std::to_string(i);
    return text.empty() ? text : text + "]";
  }
  Verdict check(const Surgery& surgery, unsigned& wanted) const {
    const int joint = surgery.joint(name);
    if (joint < 0) return Verdict::skipped("the joint is not there any more");
    const KindInfo& kind = info(surgery.declared(joint).kind);
    if (kind.nv == 0) return Verdict::skipped("a " + std::string(kind.name) + " has no freedom");
    for (const int i : freedoms)
      if (i < 0 || i >= kind.nv)
        return Verdict::refused("joint '" + name + "' has no freedom " + std::to_string(i),
                                "a " + std::string(kind.name) + " joint has freedoms 0 to " + std::to_string(kind.nv - 1));
    wanted = mask() & ((1u << kind.nv) - 1);
    return Verdict::done();
  }
};

}  // namespace momentree::actions
