#pragma once
// How `momentree bench` measures: the shortest of many calls, each at other coordinates, and only if the result is right.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/topology/change.hpp>

namespace momentree::cli {

using Clock = std::chrono::steady_clock;
inline double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Keeps the compiler from optimising `p` away.
inline void keep(const void* p) { asm volatile("" : : "g"(p) : "memory"); }

/// Shortest time of one call (s), in batches long enough for the clock, for `budget` seconds and at least seven batches.
template <class F>
double shortest(double budget, F&& call) {
  long count = 1;
  for (;; count *= 2) {
    const auto begin = Clock::now();
    for (long i = 0; i < count; ++i) call();
    if (since(begin) > 2e-4) break;
  }
  double best = HUGE_VAL;
  const auto start = Clock::now();
  for (int batch = 0; batch < 7 || since(start) < budget; ++batch) {
    const auto begin = Clock::now();
    for (long i = 0; i < count; ++i) call();
    best = std::min(best, since(begin) / static_cast<double>(count));
  }
  return best;
}

/// Shortest time of a topology change alone (s), without the evaluations before and after it. `energy`: the kinetic energy
/// after the change, relative to that before it.
template <class Change>
double shortest_change(double budget, const Change& change, const Tree& first, const State& begin, Workspace<double>& work,
                       double& energy) {
  const double before = totals(first, begin, work).kinetic;
  Tree tree = first;
  State state = begin;
  double best = HUGE_VAL;
  const auto start = Clock::now();
  for (int repeat = 0; repeat < 15 || since(start) < budget; ++repeat) {
    tree = first;
    state = begin;
    forward_dynamics(tree, state, work);
    const auto at = Clock::now();
    keep(&tree);
    apply(change, tree, state, work);
    keep(&tree);
    best = std::min(best, since(at));
  }
  energy = totals(tree, state, work).kinetic / before;
  return best;
}

/// Largest error of the momenta recomputed from the velocities just found, relative to the largest momentum.
double momentum_error(const Tree& tree, const double* q, const double* p, const Workspace<double>& work);
/// A second set of coordinates, near the first.
std::vector<double> moved(const Tree& tree, std::vector<double> q);

}  // namespace momentree::cli
