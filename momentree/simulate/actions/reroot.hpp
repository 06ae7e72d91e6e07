#pragma once
// Makes a body the root of its free mechanism: no pose, velocity or acceleration changes for it.
#include <momentree/simulate/surgery.hpp>

namespace momentree::actions {

struct Reroot : ActionBase {
  std::string body;

  std::string_view key() const override { return "reroot"; }
  std::string target() const override { return body; }
  const char* plain_field() const override { return "body"; }
  void fields(ActionFields& fields) override { fields.body("body", body, false); }
  std::vector<std::string> bodies() const override { return {body}; }
  ActionPhase phase(Surgery&) const override { return ActionPhase::release; }
  Verdict apply(Surgery& surgery) const override {
    const int b = surgery.body(body);
    if (b < 0) return Verdict::refused("there is no body '" + body + "'");
    if (!floats(surgery.tree(), b))
      return Verdict::refused("mechanism '" + surgery.mechanism_of(b) + "' is held to the ground: its root can't be another",
                              "break its root joint first");
    if (surgery.tree().parent(b) < 0) return Verdict::skipped("it is the root already");
    surgery.reroot(b);
    return Verdict::done();
  }
};

}  // namespace momentree::actions
