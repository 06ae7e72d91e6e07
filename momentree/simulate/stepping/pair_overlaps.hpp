#pragma once
// Pairs of solids that overlap, and those that pass through each other because the joint between their bodies ended while they
// did.
#include <optional>
#include <vector>

#include <momentree/simulate/stepping/stepped_pairs.hpp>

namespace momentree {

class PairOverlaps {
 public:
  PairOverlaps(const ContactWorld& world, const ContactPairs& pairs, const SteppedPairs& stepped)
      : world_(&world), pairs_(&pairs), stepped_(&stepped) {}

  /// The pair that overlaps most at present, if any do: of contacts that are located, or of all; the latter of one body, or
  /// without cables.
  std::optional<Overlap> of_located() const;
  std::optional<Overlap> of_all() const;
  std::optional<Overlap> of_bodies() const;
  std::optional<Overlap> with(BodyId body) const;
  /// The depth of the deepest of all (m).
  double deepest() const;
  /// The overlap of a pair of solids, or of the ends of a cable, with that depth (m).
  Overlap overlap(int pair, double depth) const;

  /// Lets pairs that overlap after the joint between their bodies has ended pass through each other until they are apart.
  /// `before`: what joints connected. Returns the deepest one of each two bodies, with a point.
  struct Parted {
    Overlap overlap;
    Vec3 point;  // m
  };
  std::vector<Parted> let_pass(const Connections& before) const;
  /// Pairs that have come apart touch from now on.
  void forget_apart() const;

 private:
  template <class Counts, class Depth>
  std::optional<Overlap> deepest_of(Counts counts, Depth depth) const;

  const ContactWorld* world_;
  const ContactPairs* pairs_;
  const SteppedPairs* stepped_;
};

/// What can touch in a world, and what does.
struct ContactGeometry {
  ContactGeometry(World& of, Evaluator& evaluator) : world(of, evaluator) {}
  ContactGeometry(const ContactGeometry&) = delete;
  ContactGeometry& operator=(const ContactGeometry&) = delete;

  ContactWorld world;
  ContactPairs pairs{world};
  SteppedPairs stepped{world, pairs};
  PairOverlaps overlaps{world, pairs, stepped};
};

}  // namespace momentree
