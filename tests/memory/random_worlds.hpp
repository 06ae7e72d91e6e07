#pragma once
// Worlds for the memory tests: every joint kind in every variant, and all mechanisms with special kernels.
#include <cstdint>
#include <string>
#include <vector>

#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree::memory {

/// World number `seed`. A third have trees of all joint kinds, with joint forces and forces on bodies; a third have limbs on a
/// trunk, some of them isomorphic: revolute joints with and without armature and stops, prismatic joints and welds; a third have
/// planar mechanisms next to others. Every second world has no gravity; some have prescribed motions.
Model random_model(std::uint64_t seed);

/// Such a model after changes: joints that broke, were locked, or were reversed.
struct Changed {
  Tree tree;
  State state;
};
Changed random_world(std::uint64_t seed);

/// The variants that a test covered, so that none is assumed tested that never occurred.
struct Seen {
  bool kernels[9][5] = {};  ///< by kind and variant
  int planar = 0, branching = 0, reversed = 0, locked = 0, driven = 0, loaded = 0, weightless = 0;

  void note(const Tree& tree);
  /// The variants that are missing, as text; empty: none.
  std::string missing() const;
};

}  // namespace momentree::memory
