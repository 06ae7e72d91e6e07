#pragma once
// Norm of the total force through a joint, or the force of a spring (N).
#include <momentree/simulate/events/load.hpp>

namespace momentree::quantities {

struct ReactionForce : Load {
  std::string_view key() const override { return "reaction_force"; }
  const char* summary() const override { return "Norm of the reaction force of a joint, or of the force of a spring (N)"; }
  ReactionParts reaction_parts() const override { return force_parts; }
  Dimension dimension() const override { return dimension::force; }
  bool takes_springs() const override { return true; }
  std::optional<double> of(const Wrench& wrench) const override { return norm(wrench.force); }
};

}  // namespace momentree::quantities
