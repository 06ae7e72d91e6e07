#pragma once
// The laws that every tree obeys at every state, measured against the oracle.
#include <cstdint>

#include <vector>

#include <momentree/dynamics/work.hpp>
#include <tests/oracle/oracle.hpp>

namespace momentree::oracle {

/// One law, measured.
struct Measure {
  const char* law;
  double error, bound;
  bool holds() const { return error <= bound; }  ///< not for a NaN
  double ratio() const { return bound > 0 ? error / bound : 0; }
};

struct StateMeasures {
  std::vector<Measure> laws;
  Spectrum range;
};

/// All laws at one state of a tree that stands for `system`. The work is evaluated here.
StateMeasures measure_state(const System& system, const Tree& tree, const State& state, Work<double>& work);

/// Laws of p from velocities `given`: p = M v, and back again. `start` was made from them.
std::vector<Measure> measure_round_trip(const System& system, const std::vector<double>& given, const Tree& tree,
                                        const State& start, Work<double>& work);

/// Euclidean norms, in long double.
Real norm(const std::vector<Real>& a);
Real distance(const std::vector<Real>& a, const std::vector<Real>& b);

}  // namespace momentree::oracle
