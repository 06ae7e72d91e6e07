#pragma once
// A complete failure that keeps the joint: six DoFs relative to the same parent.
#include <momentree/simulate/actions/change.hpp>

namespace momentree::actions {

struct Free : Change {
  Free() { to.spec.kind = Kind::free; }
  std::string_view key() const override { return "free"; }
  const char* summary() const override { return "Gives a joint six DoFs, relative to the same parent"; }
  const char* hint() const override { return R"(a name, or for example { joint = "arm/elbow" })"; }
  std::string target() const override { return name; }
  const char* plain_argument() const override { return "joint"; }
  void arguments(const ArgumentVisitor& visit) override { visit({"joint", argument::Joint{name}}); }
  JointEffect effect() const override { return JointEffect::released; }
};

}  // namespace momentree::actions
