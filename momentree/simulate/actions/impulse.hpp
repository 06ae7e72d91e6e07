#pragma once
// An external impulsive wrench on a body.
#include <momentree/math/unit.hpp>
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree::actions {

struct Impulse : ActionBase {
  std::string body;
  Vec3 force{}, torque{}, point{};

  std::string_view key() const override { return "impulse"; }
  const char* summary() const override { return "Applies an impulsive wrench to a body, in world axes"; }
  const char* hint() const override { return R"(for example impulse = { body = "arm/hand", force = ["2 N s", 0, 0] })"; }
  std::string target() const override { return body; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"body", argument::Body{body}});
    visit({"force", force, Field{"Impulse at `point`", dimension::force * dimension::time}});
    visit({"torque", torque, Field{"Angular impulse", dimension::torque * dimension::time}});
    visit({"point", point, Field{"Point of application in the body's frame", dimension::length}});
  }
  std::vector<std::string> bodies() const override { return {body}; }
  ActionPhase phase(TopologyEditor&) const override { return ActionPhase::impulse; }
  ActionResult apply(TopologyEditor& editor) const override {
    const int b = editor.body(body);
    if (b < 0) return ActionResult::refused("there is no body '" + body + "'");
    for (const Vec3& a : {force, torque, point})
      if (!is_finite(a)) return ActionResult::refused("the impulse and its point must be finite numbers");
    editor.push(b, force, torque, point);
    return ActionResult::done();
  }
};

}  // namespace momentree::actions
