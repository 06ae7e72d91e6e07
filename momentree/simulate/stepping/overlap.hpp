#pragma once
// Bodies that overlap.
#include <cstddef>
#include <optional>
#include <string>

#include <momentree/base/error.hpp>
#include <momentree/model/model.hpp>

namespace momentree {

/// Two bodies that overlap, or a cable that is too short for its ends.
struct Overlap {
  std::string one, other;  ///< bodies, or "ground"
  double depth = 0;        ///< m; of a cable, the distance of its ends less its length
  std::string cable{};     ///< its name; empty: the bodies overlap
  int a = -1, b = -1;      ///< numbers of the bodies; −1: the ground
  /// "'crate' and 'ground' overlap by 0.01 m", or by "up to " that.
  std::string text(const char* up_to = "") const;
  bool same_pair(const Overlap& x) const { return x.one == one && x.other == other && x.cable == cable; }
  friend bool operator==(const Overlap&, const Overlap&) = default;
};

/// States from time stepping may have overlaps of up to this (m); deeper ones are errors.
inline constexpr double left_by_steps = 1e-3;

/// What pushing overlapping bodies apart did.
struct Separation {
  double largest = 0;             ///< the largest displacement of a centre of mass (m); 0: nothing overlapped
  std::string body{};             ///< whose it is
  std::optional<Overlap> left{};  ///< the deepest overlap that could not be removed
  /// The error if one is left.
  std::optional<Error> error() const;
};

/// Colliders of a model at most: pairs of them have a number of 31 bits.
inline constexpr std::size_t most_colliders = 40'000;
/// The number of a pair of colliders, in either order, one of which may be a plane; and that of a cable.
int pair_of_colliders(const Model& model, int one, int other);
int pair_of_cable(int spring);

/// The pair of bodies that can touch and overlaps most at the start of the model, if any do. Throws Error where World does.
std::optional<Overlap> deepest_overlap(const Model& model);

/// What Integration::resolve does at the start of the model.
Separation separation_of(const Model& model);

}  // namespace momentree
