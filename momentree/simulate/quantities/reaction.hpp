#pragma once
// One component of the wrench through a joint, about the joint's frame on the child, in the child's axes (N, N m).
#include <momentree/simulate/events/load.hpp>

namespace momentree::quantities {

struct Reaction : Load {
  std::string component = "fx";

  std::string_view key() const override { return "reaction"; }
  const char* summary() const override { return "One component of the reaction of a joint, in the child's axes (N or N m)"; }
  bool never_negative() const override { return false; }
  Dimension dimension() const override { return component.starts_with('m') ? dimension::torque : dimension::force; }
  void arguments(const ArgumentVisitor& visit) override {
    visit({"joint", argument::Joint{joint}});
    visit({"component", argument::Component{component}});
  }
  ReactionParts reaction_parts() const override { return 1u << ((component[0] == 'm' ? 3 : 0) + (component[1] - 'x')); }
  std::optional<double> of(const Wrench& wrench) const override {
    const Vec3& v = component[0] == 'm' ? wrench.torque : wrench.force;
    return component[1] == 'x' ? v.x : component[1] == 'y' ? v.y : v.z;
  }
};

}  // namespace momentree::quantities
