#pragma once
// Bodies that overlap at the start.
#include <optional>
#include <string>

#include <momentree/tree/model.hpp>

namespace momentree {

/// Two bodies that overlap.
struct Overlap {
  std::string one, other;  ///< bodies, or "ground"
  double depth = 0;        ///< m
};

/// The pair of bodies that can touch and overlaps most at the start of the model, if any do. Throws Error where World does.
std::optional<Overlap> deepest_overlap(const Model& model);

}  // namespace momentree
