#pragma once
// How `momentree bench` measures: shortest of many calls, each at other coordinates, and only where the result is right.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include <momentree/dynamics/work.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree::cli {

using Clock = std::chrono::steady_clock;
inline double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// What the compiler may not leave out.
inline void keep(const void* p) { asm volatile("" : : "g"(p) : "memory"); }

/// Shortest time of one call, in batches that a clock can tell, for `budget` seconds, seven batches at least.
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

/// Largest error of the momenta that the velocities just found belong to, relative to the largest momentum.
double momentum_error(const Tree& tree, const double* q, const double* p, const Work<double>& work);
/// A second set of coordinates, near the first.
std::vector<double> moved(const Tree& tree, std::vector<double> q);

}  // namespace momentree::cli
