#pragma once
// Worlds for the tests of memory: every kind of joint in every variant, and what the sweeps have ways of their own for.
#include <cstdint>
#include <string>
#include <vector>

#include <momentree/tree/state.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree::memory {

/// Number `seed`. Of three, one has trees of all kinds of joint, with forces in joints and on bodies; one has limbs on a trunk,
/// some of them alike: pins with and without rotors and stops, slides and welds; one has mechanisms in a plane beside others.
/// Every second one is without gravity; in some, motions are prescribed.
Model random_model(std::uint64_t seed);

/// Such a model after changes: joints that broke, were locked, and carry their parents.
struct Changed {
  Tree tree;
  State state;
};
Changed random_world(std::uint64_t seed);

/// What the worlds of a test had, so that nothing is taken for tested that never came about.
struct Seen {
  bool kernels[9][5] = {};  ///< by kind and variant
  int planar = 0, twins = 0, forks = 0, reversed = 0, locked = 0, driven = 0, loaded = 0, weightless = 0;

  void note(const Tree& tree);
  /// What is missing, in words; empty: nothing.
  std::string missing() const;
};

}  // namespace momentree::memory
