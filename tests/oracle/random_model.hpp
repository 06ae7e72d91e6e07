#pragma once
// Deterministic random worlds for the law tests: trees with all joint kinds and every parameter.
#include <cstdint>

#include <vector>

#include <momentree/model/model.hpp>
#include <tests/oracle/prng.hpp>

namespace momentree::oracle {

enum class Shape { chain, bushy, mixed };
enum class Root { welded, free, jointed };  ///< jointed: attached to the ground by a joint other than a weld

struct RandomTree {
  Model model;
  Shape shape = Shape::chain;
  Root root = Root::welded;
};

struct RandomTreeOptions {
  int min_bodies = 1, max_bodies = 100;
  bool several_mechanisms = true;
  bool all_free = false;  ///< every root is free, whatever the seed
  bool gravity = true;
  bool parameters = true;     ///< damping, springs, armature, efforts on some joints
  bool conservative = false;  ///< of these only springs with a potential, and armatures
  bool drives = false;        ///< also friction, soft stops, time-dependent efforts and position control
  std::vector<Kind> kinds{};  ///< kinds of joints other than free or welded roots; empty: all
};

/// Tree number `seed`: a third are pure chains, a third are bushy; of each, a third is welded to the ground, free, or attached to
/// the ground by another joint. Masses from 0.01 to 100 kg; random q, v within ±1.
RandomTree random_tree(std::uint64_t seed, const RandomTreeOptions& options = {});

/// All kinds, with free and weld last; and one of them.
const std::vector<Kind>& every_kind();
Kind random_kind(Prng& random);

/// A joint of `kind` with random geometry; `parameters` as in the options.
JointSpec random_joint(Prng& random, Kind kind, const RandomTreeOptions& options);

/// Coordinates of a joint kind, with unit quaternions.
Values random_coordinates(Prng& random, Kind kind);
Values random_velocities(Prng& random, Kind kind);

/// Number of momenta of the model.
int dofs(const Model& model);

}  // namespace momentree::oracle
