#pragma once
// Steps of a state by a method. The methods stand in kinds/, one file each.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/dynamics/forward.hpp>

namespace momentree {

/// Evaluates rates for a method and keeps count and time of it.
class Evaluator {
 public:
  Evaluator(const Tree& tree, Workspace<double>& workspace) : tree_(&tree), workspace_(&workspace) {}

  const Tree& tree() const { return *tree_; }
  Workspace<double>& workspace() const { return *workspace_; }
  /// Rates at (q, p) and the time t into work().qdot, work().pdot, their power into work().power: a stage, of no state.
  void operator()(double t, const double* q, const double* p) noexcept;
  /// The same without what resists motion (resistance.hpp), at the velocities that p has by the mass of `other`, which is tree()
  /// but for the numbers of its rotors.
  void without_resistance(const Tree& other, double t, const double* q, const double* p) noexcept;
  /// The same for a state; nothing to do if the work is of it already.
  void operator()(const State& state) noexcept;
  /// Code for the present topology, which stages run until the tree next changes; null: none.
  void use(RatesFunction generated) noexcept { generated_ = generated, generated_of_ = tree_->revision(); }
  /// Velocities H⁻¹ p at q into other.v; rates there are meaningless. Counts as an evaluation.
  void solve(const double* q, const double* p, Workspace<double>& other) noexcept;

  long count = 0;
  double seconds = 0;

 private:
  const Tree* tree_;
  Workspace<double>* workspace_;
  RatesFunction generated_ = nullptr;
  std::uint64_t generated_of_ = 0;  // the revision that it is for
};

/// Extra states that are integrated with the method: energy dissipated and work done since the start (J).
struct EnergyLedger {
  double dissipated = 0, work = 0;
};

/// What a step from coordinates q0 to q1 stored in soft stops was not dissipated.
void take_stored(const Tree& tree, const double* q0, const double* q1, EnergyLedger& ledger) noexcept;

/// How long steps are. Methods of fixed step read `step` alone; for adaptive ones it is the first step.
struct StepControl {
  double step = 1e-3;  ///< s
  /// Error of one step that is allowed, in every coordinate q and every velocity u: atol + rtol·|value|. A tolerance on momenta
  /// would say nothing: theirs are the units of mass times those of velocity, and light parts have tiny ones.
  double rtol = 1e-8, atol = 1e-10;
  double max_step = HUGE_VAL;  ///< s
};

class Integrator {
 public:
  /// For trees of no more bodies than this one has.
  Integrator(const Tree& tree, const StepControl& control);
  virtual ~Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  /// One step of h seconds from `state`, at which `evaluate` was last called; h is finite. Neither allocates nor throws.
  /// Returns false, and leaves the state, where the motion ran away: see `plausible` and `runaway_coordinate`.
  [[nodiscard]] virtual bool step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept = 0;

  /// One step of at most h seconds: an adaptive method takes less where its error asks for it, and changes its proposal. Returns
  /// the seconds stepped; 0 where the motion ran away or no step is short enough (the state is then what it was).
  [[nodiscard]] virtual double advance(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept {
    return step(evaluate, state, ledger, h) ? h : 0;
  }
  virtual bool adaptive() const { return false; }

  /// The step to try where `left` seconds are left to an instant that is to be hit: the method's own, `left` where that is not
  /// more; adaptive methods halve what would leave a sliver.
  double next_step(double left) const {
    if (left <= proposal_ * (1 + sliver)) return left;
    return adaptive() && left < 2 * proposal_ ? left / 2 : proposal_;
  }
  /// All that an adaptive method remembers from step to step (s): to come back to with the very bits.
  double proposal() const { return proposal_; }
  void set_proposal(double seconds) { proposal_ = seconds; }

  /// Where in q the last step that failed ran away, and how far it would have moved (rad, m; NaN: a momentum became NaN, in the
  /// joint of that coordinate). Nothing where no step was short enough.
  struct Runaway {
    int coordinate = 0;
    double moved = 0;
  };
  const std::optional<Runaway>& runaway_coordinate() const { return runaway_; }

  /// True for a method with dense output.
  virtual bool dense() const { return false; }
  /// The state at fraction theta (0 … 1) of the last step, from the rates of its stages; quaternions of length one. May evaluate
  /// more stages where it is first asked for in a step, and leaves evaluate.work() as it is. False where the method keeps nothing
  /// for that. What was changed after the step is not seen.
  virtual bool interpolate([[maybe_unused]] Evaluator& evaluate, [[maybe_unused]] double theta, [[maybe_unused]] double* q,
                           [[maybe_unused]] double* p) noexcept {
    return false;
  }

 protected:
  /// What is left of a step's length that is taken along instead of by a step of its own. The clock adds up rounded steps: a
  /// hundred thousand of 10 µs are off by some 1e-6 of one.
  static constexpr double sliver = 1e-4;

  /// `plausible`, and where it is not, notes what ran away.
  bool sound(const Tree& tree, const double* q0, const double* q, const double* p) noexcept;

  /// What each step starts with: the evaluator's work is of this state, and the step can be taken.
  void require_ready(const Evaluator& evaluate, const State& state, double h) const noexcept;

  const StepControl control_;
  double proposal_;
  std::optional<Runaway> runaway_;

 private:
  int bodies_;
};

/// The method of that name for trees of this many bodies; null if there is none.
std::unique_ptr<Integrator> make_integrator(std::string_view method, const Tree& tree, const StepControl& control = {});
/// How well velocities are known, at coordinates q, where momenta are what is stored: velocities of one become momenta and then
/// velocities again, and the largest error is returned. About 1e-16 on a single body; long chains of light links lose digits with
/// the fourth power of their number. A relative tolerance below that asks for what is not there. Set-up only: allocates.
double velocity_resolution(const Tree& tree, std::span<const double> q);
/// True for a method that chooses its steps.
bool is_adaptive(std::string_view method);
/// Names of all methods.
std::vector<std::string> integration_methods();

/// What a step ends with, at its end t: quaternions of length one, prescribed motions where their curves have them.
void end_step(const Tree& tree, double t, double* q, double* p) noexcept;
/// Brings quaternions back to length one: once per step, not inside stages.
void normalise(const Tree& tree, double* q) noexcept;
/// Further than this no coordinate moves in one step (rad, m): what does has diverged, long before its numbers overflow.
inline constexpr double runaway = 1e6;
/// True where a step from coordinates q0 to (q, p) is one of a motion that did not run away: finite, and within `runaway`.
bool plausible(const Tree& tree, const double* q0, const double* q, const double* p) noexcept;

/// Scratch of a method, not written yet: pages that no topology needs cost nothing.
inline std::unique_ptr<double[]> scratch(long n) {
  return std::make_unique_for_overwrite<double[]>(static_cast<std::size_t>(std::max(n, 1L)));
}

}  // namespace momentree
