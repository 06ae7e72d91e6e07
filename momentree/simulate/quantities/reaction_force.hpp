#pragma once
// Norm of the total force through a joint (N).
#include <momentree/simulate/load.hpp>

namespace momentree::quantities {

struct ReactionForce : Load {
  std::string_view key() const override { return "reaction_force"; }
  const char* summary() const override { return "Norm of the reaction force of a joint (N)"; }
  Dimension dimension() const override { return dimension::force; }
  std::optional<double> of(const Wrench& wrench) const override { return norm(wrench.force); }
};

}  // namespace momentree::quantities
