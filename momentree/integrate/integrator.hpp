#pragma once
// Steps of a state by a method. The methods stand in kinds/, one file each.
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/dynamics/forward.hpp>

namespace momentree {

/// Evaluates rates for a method and keeps count and time of it.
class Evaluator {
 public:
  Evaluator(const Tree& tree, Work<double>& work) : tree_(&tree), work_(&work) {}

  const Tree& tree() const { return *tree_; }
  Work<double>& work() const { return *work_; }
  /// Rates at (q, p) into work().qdot, work().pdot, their power into work().power: a stage, of no state.
  void operator()(const double* q, const double* p) noexcept;
  /// The same for a state; nothing to do if the work is of it already.
  void operator()(const State& state) noexcept;

  long count = 0;
  double seconds = 0;

 private:
  const Tree* tree_;
  Work<double>* work_;
};

/// Extra states that are integrated with the method: energy dissipated and work done since the start (J).
struct Books {
  double dissipated = 0, work = 0;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  /// One step of h seconds from `state`, at which `evaluate` was last called. Neither allocates nor throws.
  /// Returns false, and leaves the state, where the motion ran away: see `plausible`.
  virtual bool step(Evaluator& evaluate, State& state, Books& books, double h) noexcept = 0;
};

/// The method of that name for trees of this many bodies; null if there is none.
std::unique_ptr<Integrator> make_integrator(std::string_view method, const Tree& tree);
/// Names of all methods.
std::vector<std::string> integration_methods();

/// Brings quaternions back to length one: once per step, not inside stages.
void normalise(const Tree& tree, double* q) noexcept;
/// Further than this no coordinate moves in one step (rad, m): what does has diverged, long before its numbers overflow.
inline constexpr double runaway = 1e6;
/// True where a step from coordinates q0 to (q, p) is one of a motion that did not run away: finite, and within `runaway`.
bool plausible(const Tree& tree, const double* q0, const double* q, const double* p) noexcept;

}  // namespace momentree
