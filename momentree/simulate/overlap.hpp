#pragma once
// Bodies that overlap at the start.
#include <cstddef>
#include <optional>
#include <string>

#include <momentree/tree/model.hpp>

namespace momentree {

/// Two bodies that overlap.
struct Overlap {
  std::string one, other;  ///< bodies, or "ground"
  double depth = 0;        ///< m
};

/// Colliders of a model at most: pairs of them have a number of 31 bits.
inline constexpr std::size_t most_colliders = 40'000;

/// The pair of bodies that can touch and overlaps most at the start of the model, if any do. Throws Error where World does.
std::optional<Overlap> deepest_overlap(const Model& model);

}  // namespace momentree
