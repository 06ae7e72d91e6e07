#pragma once
// A run of a scenario, with everything that can be compared.
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <cli/input.hpp>

namespace momentree::fuzz {

/// Settings of a run.
struct RunPlan {
  std::string state{};         ///< the document to start from; empty: the scenario's start
  double until = 0;            ///< s
  long most_steps = 1L << 40;  ///< it is interrupted after this many steps
  /// After each of these numbers of steps, in ascending order, the run is saved as a checkpoint and continued in a new session.
  std::vector<long> saved_after{};
  std::function<void(const Simulation&)> at_rows{};      ///< called at each row
  std::function<void(const Simulation&)> after_steps{};  ///< called at the end of each step, before and after its events
};

struct Trace {
  Status status = Status::ok;
  std::string message;
  std::string refused;              ///< why it could not start; all other members are empty then
  std::string state;                ///< the document at the end
  std::vector<std::string> events;  ///< as in events.jsonl, without wall-clock
  std::vector<std::string> rows;    ///< time, coordinates, momenta and energies at each row
  std::vector<double> times;        ///< of the rows
  std::vector<Event> certificates;
  std::map<std::string, std::string> joints_before, joints_after;  ///< its joints at the start and at the end, by name
  std::vector<std::string> mechanisms_before, mechanisms_after;    ///< by body, its mechanism
  EnergyBalance energy;
  std::string counts;  ///< its steps, evaluations and energies, and the events that it missed, by how much
  double time = 0, step_work = 0;
  long steps = 0;
  bool cut = false;  ///< by most_steps
};

Trace traced_run(const io::Scenario& scenario, const RunPlan& plan);

/// One event as text, without values that differ from run to run.
std::string event_text(Event event);
/// One joint as text.
std::string joint_text(const JointRecord& joint);
/// The state of a world at an instant, exact to the last bit.
std::string row_text(const Simulation& simulation);
/// The first difference of two texts with its context, for messages.
std::string difference(const std::string& one, const std::string& other);

}  // namespace momentree::fuzz
