#pragma once
// A model at a random state, for comparisons with other engines: coordinates and velocities of every joint, and the accelerations
// that follow.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/world/world.hpp>
#include <tests/oracle/prng.hpp>

namespace momentree::peers {

/// A model file of this repository, as `momentree run FILE --set …` would have it.
inline Model read(const std::string& file, const std::vector<std::string>& overrides) {
  const io::ReadResult result = io::read_scenario(MOMENTREE_SOURCE_DIR "/scenarios/models/" + file, overrides);
  CAPTURE(io::rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return result.scenario->model;
}

inline BodySpec at_random_state(BodySpec spec, oracle::Prng& random) {
  const KindInfo& kind = info(spec.joint.kind);
  Values q, v;
  for (int i = 0; i < kind.nq; ++i) {
    if (kind.q_units[i] == 'n') {
      const Quat r = normalized(Quat{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
      q.push_back(r.w), q.push_back(r.x), q.push_back(r.y), q.push_back(r.z);
      break;
    }
    q.push_back(kind.q_units[i] == 'r' ? random.uniform(-3, 3) : random.uniform(-0.5, 0.5));
  }
  for (int i = 0; i < kind.nv; ++i) v.push_back(random.uniform(-2, 2));
  spec.q = q;
  spec.v = v;
  return spec;
}

/// The same bodies, somewhere else.
inline Model at_random_state(const Model& model, oracle::Prng& random) {
  Model moved({.gravity = model.gravity()});
  for (const BodySpec& spec : model.bodies()) moved.add_unjudged(at_random_state(spec, random));
  return moved;
}

/// Largest difference of accelerations that may be, relative to the largest of them.
inline constexpr double bound = 1e-9;

}  // namespace momentree::peers
