#pragma once
// Integration methods and their steps. Each method is one file in kinds/.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>

namespace momentree {

/// Evaluates rates for a method; records the number of evaluations and their time.
class Evaluator {
 public:
  Evaluator(const Tree& tree, Workspace<double>& workspace) : tree_(&tree), workspace_(&workspace) {}

  const Tree& tree() const { return *tree_; }
  Workspace<double>& workspace() const { return *workspace_; }
  /// What y is: the variables of the state that was evaluated last.
  Variables variables() const { return variables_; }
  /// Rates at (q, y) and time t (s) in workspace().qdot and ydot(), their power in workspace().power: a stage, which belongs to
  /// no state.
  void operator()(double t, const double* q, const double* y) noexcept;
  /// Of the last evaluation: ṗ, or u̇ for a state in velocities.
  const double* ydot() const { return (variables_ == Variables::momenta ? workspace_->pdot : workspace_->a).get(); }
  /// The same without the forces of resistance.hpp, at the velocities that p has with the mass matrix of `other`, which equals
  /// tree() except for the values of its armatures.
  void without_resistance(const Tree& other, double t, const double* q, const double* p) noexcept;
  /// The same for a state; does nothing if the workspace already holds its evaluation.
  void operator()(const State& state) noexcept;
  /// Code for the present topology, which stages run until the tree next changes; null: none.
  void use(GeneratedRates generated) noexcept { generated_ = generated, generated_of_ = tree_->revision(); }
  /// The same evaluation in another workspace, not counted here.
  Evaluator in(Workspace<double>& other) const {
    Evaluator copy(*tree_, other);
    copy.variables_ = variables_;
    return copy;
  }
  /// Closes the loops at (q, y) and time t (s): see close_loops and close_loops_in_momenta.
  [[nodiscard]] bool close(double t, double* q, double* y, double& energy) noexcept;
  /// Writes the changes of velocities H⁻¹ p that belong to changes of momenta p at q, with loops those that keep them closed, to
  /// other.v; the rates there are meaningless.
  /// Counts as an evaluation.
  void solve(const double* q, const double* p, Workspace<double>& other) noexcept;

  long count = 0;
  double seconds = 0;

 private:
  const Tree* tree_;
  Workspace<double>* workspace_;
  Variables variables_ = Variables::momenta;
  GeneratedRates generated_;
  std::uint64_t generated_of_ = 0;  // the tree's revision for which it is valid
  int stages_ = 0, untimed_ = 0;    // so far, up to some number; since the last one that was timed
};

/// Energy ledger, integrated with the method: energy dissipated and work done since the start (J).
struct EnergyLedger {
  double dissipated = 0, work = 0;
  double projection = 0;  ///< brought in by closing loops after steps, and by removing overlaps
  double impacts = 0;     ///< lost at contacts that are stepped through: in their impacts, and by friction
};

/// Subtracts from `dissipated` the energy that a step from coordinates q0 to q1 stored in soft stops.
void take_stored(const Tree& tree, const double* q0, const double* q1, EnergyLedger& ledger) noexcept;

/// Step sizes. Fixed-step methods use only `step`; for adaptive ones it is the first step.
struct StepControl {
  double step = 1e-3;  ///< s
  /// Tolerated error of one step, in every coordinate q and every velocity u: atol + rtol·|value|. Tolerances on momenta would be
  /// meaningless: their units are mass times velocity, and light parts have tiny momenta.
  double rtol = 1e-8, atol = 1e-10;
  double max_step = HUGE_VAL;  ///< s
};

class StepContacts;

class Integrator {
 public:
  /// For trees with at most as many bodies as this one.
  Integrator(const Tree& tree, const StepControl& control);
  virtual ~Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  /// One step of h seconds from `state`, on which `evaluate` was last called; h must be finite. Neither allocates nor throws.
  /// Returns false, and leaves the state unchanged, if the motion diverged: see `plausible` and `runaway_coordinate`.
  [[nodiscard]] virtual bool step(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept = 0;

  /// One step of at most h seconds: an adaptive method takes a shorter one if the error requires it, and updates its proposal.
  /// Returns the seconds stepped; 0 if the motion diverged or no step is short enough (the state is then unchanged).
  [[nodiscard]] virtual double advance(Evaluator& evaluate, State& state, EnergyLedger& ledger, double h) noexcept {
    return step(evaluate, state, ledger, h) ? h : 0;
  }
  virtual bool adaptive() const { return false; }
  /// Sets what completes the steps of a method that steps through contacts; others ignore it.
  virtual void use([[maybe_unused]] StepContacts* contacts) {}
  /// Several steps may be tried from one state: notes what the method remembers of the step before, and returns to that.
  virtual void note_start() {}
  virtual void return_to_start() {}
  /// Whether the steps of lanes (batch/stepper.hpp) are those of this method.
  virtual bool is_that_of_lanes() const { return false; }

  /// The step to try if `left` seconds remain to an instant that must be hit: the method's proposal, or `left` if that is not
  /// longer; adaptive methods halve what would leave a sliver.
  double next_step(double left) const {
    if (left <= proposal_ * (1 + sliver)) return left;
    return adaptive() && left < 2 * proposal_ ? left / 2 : proposal_;
  }
  /// The only memory of an adaptive method between steps (s): restoring it continues a run bit for bit.
  double proposal() const { return proposal_; }
  void set_proposal(double seconds) { proposal_ = seconds; }

  /// The index in q at which the last failed step diverged, and how far it would have moved (rad, m; NaN: a momentum or
  /// velocity of that coordinate's joint became NaN). Empty if no step was short enough.
  struct Runaway {
    int coordinate = 0;
    double moved = 0;
  };
  const std::optional<Runaway>& runaway_coordinate() const { return runaway_; }
  /// True if the last failed step ended where the loops cannot be closed.
  bool loops_open() const { return loops_open_; }

  /// True for a method with dense output.
  virtual bool dense() const { return false; }
  /// The state at fraction theta (0 … 1) of the last step, from the rates of its stages; quaternions are normalised. May evaluate
  /// more stages at the first call after a step, and leaves evaluate.workspace() unchanged. Returns false if the method has no
  /// dense output for that step. Changes after the step are not included.
  virtual bool interpolate([[maybe_unused]] Evaluator& evaluate, [[maybe_unused]] double theta, [[maybe_unused]] double* q,
                           [[maybe_unused]] double* y) noexcept {
    return false;
  }

 protected:
  /// A remainder of this part of a step is included in the step instead of being taken separately. The clock adds up rounded
  /// steps: after a hundred thousand steps of 10 µs it is off by about 1e-6 of one.
  static constexpr double sliver = 1e-4;

  /// Completes a step with loops or contacts: closes them at its end t (s), at the result (q, y), in the evaluator's workspace.
  /// False if they cannot be closed.
  bool close(Evaluator& evaluate, double t, double* q, double* y) noexcept {
    const Tree& tree = evaluate.tree();
    return (!tree.has_loops() && tree.contacts().empty()) || close_loops_of(evaluate, t, q, y);
  }
  /// Adds ṗ* − ṗ, which the closing made, to rates ṗ of the state that it led to: see add_gauge_rates.
  static void add_gauge(const Evaluator& evaluate, const double* q, double* rates) noexcept;
  /// Books the closing with the step that was accepted.
  void book_closing(const Evaluator& evaluate, State& state, EnergyLedger& ledger) const noexcept {
    if (evaluate.tree().has_loops() || !evaluate.tree().contacts().empty()) book_loops(evaluate, state, ledger);
  }

  /// Calls `plausible` and, if it returns false, records the coordinate that diverged.
  bool sound(const Tree& tree, const double* q0, const double* q, const double* y) noexcept;

  /// At the start of each step, which requires that the evaluator's workspace belongs to this state.
  void begin_step(const Evaluator& evaluate, const State& state, double h) noexcept;

  const StepControl control_;
  double proposal_;
  std::optional<Runaway> runaway_;

 private:
  bool close_loops_of(Evaluator& evaluate, double t, double* q, double* y) noexcept;
  void book_loops(const Evaluator& evaluate, State& state, EnergyLedger& ledger) const noexcept;

  int bodies_;
  double closing_energy_ = 0;
  double stored_in_loops_ = 0;  // in soft stops of loop joints, when the step began
  bool loops_open_ = false;
};

/// Creates a method by name for trees of at most this size; null if there is no such method.
std::unique_ptr<Integrator> make_integrator(std::string_view method, const Tree& tree, const StepControl& control = {});
/// The accuracy of velocities at coordinates q if momenta are stored: converts velocities of one to momenta and back,
/// and returns the largest error. About 1e-16 for a single body; long chains of light links lose digits with the fourth power of
/// their number. A smaller relative tolerance cannot be met. Set-up only: allocates.
double velocity_resolution(const Tree& tree, std::span<const double> q);
/// True for a method that chooses its steps.
bool is_adaptive(std::string_view method);
/// The variables that a method integrates by default, and false for a method that solves for momenta.
Variables default_variables(std::string_view method);
bool takes_velocities(std::string_view method);
/// False for a method that solves for the end of its steps: contacts would open and close during the iteration.
bool supports_contact(std::string_view method);
/// True for a method that does not locate contacts: see step_contacts.hpp. There is one.
bool steps_through_contacts(std::string_view method);
/// The name of that method.
std::string contact_stepping_method();
/// "momenta" or "velocities"; and the variables of that name, if there are any.
const char* name_of(Variables variables);
std::optional<Variables> variables_of(std::string_view name);
std::vector<std::string> variable_names();
/// Names of all methods.
std::vector<std::string> integration_methods();
/// The same, and what the literature calls some of them.
std::vector<std::string> method_names();
/// The method of one of these names; an unknown name as it is.
std::string method_named(std::string_view name);

/// Completes a step ending at time t (s): normalises quaternions, sets prescribed motions to their curves.
void end_step(const Tree& tree, double t, double* q, double* y) noexcept;
/// Normalises quaternions: once per step, not inside stages.
void normalise(const Tree& tree, double* q) noexcept;
/// Largest plausible motion of a coordinate in one step (rad, m): a larger one means divergence, long before numbers overflow.
inline constexpr double runaway = 1e6;
/// True if a step from coordinates q0 to (q, y) did not diverge: finite, and within `runaway`.
bool plausible(const Tree& tree, const double* q0, const double* q, const double* y) noexcept;

/// Uninitialised scratch of a method: memory pages that no topology needs cost nothing.
inline std::unique_ptr<double[]> scratch(long n) {
  return std::make_unique_for_overwrite<double[]>(static_cast<std::size_t>(std::max(n, 1L)));
}

}  // namespace momentree
