#pragma once
// What acts on the bodies of a tree beside their joints: forces, functions, and springs between points.
#include <span>
#include <vector>

#include <momentree/base/check.hpp>
#include <momentree/base/reserved.hpp>
#include <momentree/model/model.hpp>
#include <momentree/tree/parts/topology.hpp>

namespace momentree {

/// Those that act on single bodies.
struct TreeLoads {
  std::span<const BodyForce> forces;        ///< the model's, including those on removed bodies, which have no effect
  std::vector<Topology::Loaded> functions;  ///< at most one per body; also including removed bodies
  detail::Reserved<int> bodies;  ///< on which a force, function, spring or contact acts, and all inboard of them, inboard first
};

/// The model's springs between points of bodies, by number, including those without effect: see spring_acts().
struct TreeSprings {
  std::span<const Spring> declared;
  std::vector<Topology::SpringChange> states;  ///< by spring

  std::size_t size() const { return declared.size(); }
  int count() const { return static_cast<int>(declared.size()); }
  const Spring& operator[](std::size_t spring) const { return declared[spring]; }
  bool broken(int spring) const { return state(spring).broken; }
  /// Its present law: the model's, or as a change set it.
  const SpringLaw& law(int spring) const { return state(spring).law; }

 private:
  const Topology::SpringChange& state(int spring) const {
    const auto s = static_cast<std::size_t>(spring);
    MT_REQUIRE(s < states.size(), "the model has a spring of that number");
    return states[s];
  }
};

}  // namespace momentree
