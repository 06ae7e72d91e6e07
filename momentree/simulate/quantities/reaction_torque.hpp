#pragma once
// Norm of the total torque through a joint, about the origin of the joint's frame on the child (N m).
#include <momentree/simulate/events/load.hpp>

namespace momentree::quantities {

struct ReactionTorque : Load {
  std::string_view key() const override { return "reaction_torque"; }
  const char* summary() const override { return "Norm of the reaction torque of a joint, about the joint's frame (N m)"; }
  ReactionParts reaction_parts() const override { return torque_parts; }
  Dimension dimension() const override { return dimension::torque; }
  std::optional<double> of(const Wrench& wrench) const override { return norm(wrench.torque); }
};

}  // namespace momentree::quantities
