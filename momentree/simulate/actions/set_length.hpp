#pragma once
// Another length for a cable, or another rest length for a spring.
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree::actions {

struct SetLength : ActionBase {
  std::string name;
  double length = 0;

  std::string_view key() const override { return "set_length"; }
  const char* summary() const override { return "Sets the length of a cable, or the rest length of a spring"; }
  const char* hint() const override { return R"(for example set_length = { cable = "tether", length = "5 m" })"; }
  std::string target() const override { return name; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"cable", argument::Joint{name}, Field{"Name of a cable or a spring; * matches within a name"}});
    visit({"length", length, Field{"Its new length", dimension::length, Range::not_negative}});
  }
  std::vector<std::string> joints() const override { return {name}; }
  bool takes_springs() const override { return true; }
  ActionPhase phase(TopologyEditor&) const override { return ActionPhase::parameters; }
  ActionResult apply(TopologyEditor& editor) const override {
    const int spring = editor.spring(name);
    if (spring < 0) return ActionResult::refused("'" + name + "' is no cable or spring", "set has the parameters of joints");
    return editor.set_spring(spring, {.rest = length});
  }
};

}  // namespace momentree::actions
