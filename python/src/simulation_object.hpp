#pragma once
// A simulation as Python holds it: who is using it, the arrays that follow its state, and exceptions of its callbacks.
#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <momentree/results/session.hpp>
#include <momentree/scenario/part_reader.hpp>

#include "binding.hpp"

namespace momentree::python {

/// The arrays q, v, p and effort of one topology. They follow the state: numbers that Python writes are taken over before the
/// next operation, and the state is copied into them after it. When the topology changes they are filled with NaN, and `alive`
/// becomes false: their use through StateView is then an error.
struct StateArrays {
  bool alive = true, with_v = false, with_effort = false;
  std::uint64_t topology = 0;
  std::vector<int> layout;  ///< by joint number: its kind, or −1; the numbers belong to the same joints as long as it is the same
  struct Numbers {
    std::vector<double> now, last;  ///< as Python sees them, and as they were copied from the state
    bool written() const;
  };
  Numbers q, v, p, effort;
  std::vector<double> qdot, pdot;  ///< of the last evaluation
};

/// The Python objects that show them, made when they are first asked for. They keep the arrays alive, not the other way round.
struct StateViews {
  nb::object q, v, p, effort, rates;
};

/// A StateView (an ndarray) of numbers in `arrays`, which it keeps alive.
nb::object state_view(const std::shared_ptr<StateArrays>& arrays, std::vector<double>& numbers, const char* name);

/// What a callback is doing: it limits what Python code that is called from inside a run may do with the simulation.
enum class Inside { nothing, observer, measure, drive };

/// Kinds of use, see Use.
enum class Access { read, schedule, change };

class SimulationObject : public std::enable_shared_from_this<SimulationObject> {
 public:
  SimulationObject(std::shared_ptr<const io::Scenario> scenario, std::unique_ptr<io::Session> session);
  /// A branch of another one.
  explicit SimulationObject(SimulationObject& from);
  ~SimulationObject();
  SimulationObject(const SimulationObject&) = delete;
  SimulationObject& operator=(const SimulationObject&) = delete;

  Simulation& simulation() { return branch_ ? *branch_ : session_->simulation(); }
  const io::Scenario& scenario() const { return *scenario_; }
  const std::shared_ptr<const io::Scenario>& shared_scenario() const { return scenario_; }
  io::Armed armed() const { return branch_ ? session_->armed(*branch_) : session_->armed(); }
  std::vector<io::Diagnostic> warnings() const { return branch_ ? std::vector<io::Diagnostic>{} : session_->warnings; }
  void warn(io::Diagnostic warning) { session_->warnings.push_back(std::move(warning)); }

  /// The arrays of the present topology.
  const std::shared_ptr<StateArrays>& arrays();
  /// Takes over what Python wrote.
  void push();
  /// Copies the state into the arrays, or makes them stale if the topology has changed.
  void pull();
  void drop_arrays();
  bool written() const;
  StateViews views;

  /// Runs with the GIL released. Throws what a callback threw, and RunError for a run that failed.
  RunResult run_until(double time);
  void step(double dt);
  [[noreturn]] static void throw_run_error(const RunResult& result);

  /// Calls Python from a drive: what it throws is kept, and thrown when the run ends; NaN ends it.
  template <class Call>
  bool guarded(const Call& call) noexcept;

  /// A function on a joint and an extra effort share one function of the engine.
  struct JointInput {
    nb::handle function;        ///< null: none; the Python object of the simulation keeps it alive
    std::vector<double> extra;  ///< one per DoF; empty: none
  };
  void set_drive(const std::string& joint, nb::handle function);
  void set_efforts(const std::vector<double>& packed);
  /// True if Python functions drive joints, act on bodies or measure conditions.
  bool has_functions();
  /// Extra efforts that act, by joint number.
  std::vector<std::pair<int, std::vector<double>>> efforts();
  /// By the joint's name, which a joint that closes a loop keeps when it takes the place of a broken joint in the tree.
  using Inputs = std::map<std::string, std::shared_ptr<JointInput>, std::less<>>;
  /// Copies, for snapshots and branches: the engine's functions refer to inputs, so that two simulations must not share any.
  Inputs copy_inputs() const;
  void set_inputs(const Inputs& inputs);
  /// Those to which the functions of the engine refer already.
  void adopt(Inputs inputs) { inputs_ = std::move(inputs); }

  /// The simulation that is in use in this thread, which calls functions; null: none.
  static SimulationObject* current();

  /// A function with the time and the number of steps, about ten times a second during a run; null: none.
  nb::object progress;
  Inside inside = Inside::nothing;

  /// The thread that is using it: see Use.
  std::atomic<std::thread::id> user{};

 private:
  void watch();
  bool look_around(double time);
  void install(int joint, const std::shared_ptr<JointInput>& input);
  void rethrow();

  std::shared_ptr<const io::Scenario> scenario_;
  std::shared_ptr<io::Session> session_;  // of a branch: the session of the simulation that was loaded, whose events it has
  std::optional<Simulation> branch_;
  std::shared_ptr<StateArrays> arrays_;
  bool same_layout();
  void fill_efforts();
  Inputs inputs_;
  std::shared_ptr<JointInput> input_of(int joint);
  std::exception_ptr pending_;
  std::chrono::steady_clock::time_point looked_{};
  unsigned steps_since_look_ = 0;
};

/// One operation on a simulation. Throws Error if another thread is using it, or if the operation is not allowed inside the
/// callback that makes it. The outermost one keeps the arrays and the state equal.
class Use {
 public:
  Use(SimulationObject& object, Access access);
  ~Use();
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  SimulationObject& object_;
  Access access_;
  bool outermost_;
  SimulationObject* before_ = nullptr;
};

/// The state of the surrounding callback is restored by the destructor.
class Within {
 public:
  Within(SimulationObject& object, Inside what) : object_(object), before_(object.inside) { object.inside = what; }
  ~Within() { object_.inside = before_; }
  Within(const Within&) = delete;
  Within& operator=(const Within&) = delete;

 private:
  SimulationObject& object_;
  Inside before_;
};

using SimulationPtr = std::shared_ptr<SimulationObject>;

/// Python functions as conditions, drives and forces (callbacks.cpp). They are called for the simulation that is in use. They are
/// borrowed: the Python object of the simulation keeps them, where the garbage collector sees cycles through them.
Measure measure_of(nb::handle function);
JointFunction drive_of(std::shared_ptr<SimulationObject::JointInput> input);
BodyFunction force_of(nb::handle function);

template <class Call>
bool SimulationObject::guarded(const Call& call) noexcept {
  try {
    call();
    return true;
  } catch (...) {
    if (!pending_) pending_ = std::current_exception();
    return false;
  }
}

}  // namespace momentree::python
