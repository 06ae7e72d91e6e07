#pragma once
// Makes a body the root of its free mechanism: no pose, velocity or acceleration changes.
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree::actions {

struct Reroot : ActionBase {
  std::string body;

  std::string_view key() const override { return "reroot"; }
  const char* summary() const override { return "Makes a body the root of its free mechanism"; }
  const char* hint() const override { return R"(for example reroot = "arm/hand")"; }
  bool in_scenarios() const override { return false; }  // other actions re-root as needed
  std::string target() const override { return body; }
  const char* plain_argument() const override { return "body"; }
  void arguments(const ArgumentVisitor& visit) override { visit({"body", argument::Body{body}}); }
  std::vector<std::string> bodies() const override { return {body}; }
  ActionPhase phase(TopologyEditor&) const override { return ActionPhase::release; }
  ActionResult apply(TopologyEditor& editor) const override {
    const int b = editor.body(body);
    if (b < 0) return ActionResult::refused("there is no body '" + body + "'");
    if (!floats(editor.tree(), {b}))
      return ActionResult::refused("mechanism '" + editor.mechanism_of(b) + "' is attached to the ground: its root can't change",
                                   "break its root joint first");
    if (editor.tree().parent(b) < 0) return ActionResult::skipped("it is already the root");
    editor.reroot(b);
    return ActionResult::done();
  }
};

}  // namespace momentree::actions
