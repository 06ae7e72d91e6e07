#pragma once
// Norm of the linear impulse through a joint at an instantaneous change (N s).
#include <algorithm>

#include <momentree/simulate/events/condition.hpp>

namespace momentree::quantities {

struct ReactionImpulse : Quantity {
  std::string joint;

  std::string_view key() const override { return "reaction_impulse"; }
  const char* summary() const override { return "Norm of the linear impulse through a joint at an instantaneous change (N s)"; }
  Dimension dimension() const override { return dimension::force * dimension::time; }
  void arguments(const ArgumentVisitor& visit) override { visit({"joint", argument::Joint{joint}}); }
  std::vector<std::string> joints() const override { return {joint}; }
  bool is_load() const override { return true; }
  bool never_negative() const override { return true; }
  bool is_impulsive() const override { return true; }
  std::optional<double> value(const World&, std::span<const Event> now) const override {
    double most = 0;
    for (const Event& event : now)
      for (const auto& [name, S] : event.impulse)
        if (name == joint) most = std::max(most, norm(Vec3{S[0], S[1], S[2]}));
    return most;
  }
};

}  // namespace momentree::quantities
