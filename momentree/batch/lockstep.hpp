#pragma once
// Several simulations that advance together, one per SIMD lane.
#include <memory>
#include <span>
#include <vector>

#include <momentree/batch/stepper.hpp>
#include <momentree/simulate/simulation.hpp>

namespace momentree {

namespace batch {
class Group;
}

/// A simulation and the time (s) to run to.
struct LockstepRun {
  Simulation* simulation;
  double until;
  RunResult result{};  ///< afterwards, as of run_until()
};

/// Runs simulations as run_until() does, but computes the steps of those that have the same topology and the same variables
/// together, in SIMD lanes.
/// Events, observers, samplers and watchers work as usual; a simulation whose topology changes goes on with others of its new
/// topology. Its states have the bits of run_until(), whatever simulations run beside it; on x86-64 those in baseline lanes, for
/// which no machine code is made, equal it to round-off.
///
/// What a step costs beside the integration is left out: the energies dissipated, put in by forces and brought in by closing
/// loops (`dissipated`, `work`, `projection` and `error` of Simulation::energy()) are not booked, watchers are called at least
/// every 256 steps instead of after each, and times of statistics() do not include the steps.
class Lockstep {
 public:
  explicit Lockstep(Isa widest = Isa::avx512);
  ~Lockstep();
  Lockstep(const Lockstep&) = delete;
  Lockstep& operator=(const Lockstep&) = delete;

  Isa isa() const { return isa_; }
  /// The number of simulations that one step advances at most.
  int lanes() const { return isa_ == Isa::avx512 ? 8 : isa_ == Isa::avx2 ? 4 : 2; }
  /// Whether run() would compute the next steps in lanes: with the method rk4, without generated code, and without what has to be
  /// looked at after each step or is not computed in lanes: conditions, hard stops, strengths, functions, forces on bodies,
  /// springs between them, and closed loops in momenta.
  [[nodiscard]] static bool fits(const Simulation& simulation);
  /// Whether two simulations that fit would share lanes at present: they have the same topology, constants, parameters and
  /// variables.
  [[nodiscard]] static bool share(const Simulation& a, const Simulation& b);
  /// Runs all of them. Simulations that do not fit, or no longer fit after an event, run alone. Exceptions of callbacks
  /// propagate; the results of the other simulations are then undefined.
  void run(std::span<LockstepRun> runs);

 private:
  struct Member;
  static constexpr int steps_between_calls = 256;

  batch::Group& group_of(const Simulation::Impl& impl);
  /// Seats the member in a group for its next steps; false: it has ended.
  bool board(Member& member);
  void leave(Member& member);
  void set_step(Member& member);
  /// After a step: whether the member stays in its seat.
  void after_step(Member& member);
  static void take_state(Member& member);
  static void finish(Member& member);

  Isa isa_;
  // For momenta, for velocities, and for loops; made when a simulation needs it.
  struct Steps {
    std::unique_ptr<batch::Stepper> stepper;
    int capacity = 0;
  };
  Steps& steps_of(Variables variables, bool loops) { return steps_[loops ? 2 : variables == Variables::momenta ? 0 : 1]; }
  Steps steps_[3];
  std::vector<std::unique_ptr<batch::Group>> groups_;
  std::vector<Member> members_;
};

}  // namespace momentree
