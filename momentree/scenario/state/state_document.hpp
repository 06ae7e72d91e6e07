#pragma once
// The state document (JSON): a whole world at an instant, changed topology included. `run` and `evaluate` write it; `--state`
// and `state = "file.json"` read it.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/world/world.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

/// The progress of one event of the scenario.
struct ArmedEvent {
  std::string name;
  int fired = 0;  ///< how often it has happened
  /// For each match of its wildcard, in the order of the model, or for the one event: the state of its condition, and when it
  /// is due. Empty: only the count is known.
  std::vector<EventStatus> each{};
  friend bool operator==(const ArmedEvent&, const ArmedEvent&) = default;
};
/// In the order of the file.
using Armed = std::vector<ArmedEvent>;

/// The document of a world. Numbers read back to the same bits; quaternions have w >= 0. `memory`: what the run carries from step
/// to step.
std::string state_json(const World& world, const Armed& armed, const StepMemory& memory = {});

/// The contents of a document, checked against the model.
struct RestoredState {
  std::string file;
  std::optional<double> time;
  Forest forest;                   ///< of a whole document; else empty, apart from gravity, springs and contacts that it names
  std::vector<JointStart> joints;  ///< the joints that it names
  std::vector<std::string> where;  ///< the position of each of them: `file:line:col`
  Armed armed;
  StepMemory memory;  ///< with a next step of 0: that of an adaptive method is unknown
};

/// Reads a document from its text. `mechanism`: read the joints of that mechanism alone, and neither time nor topology (empty:
/// the whole world). Nothing, with all `problems` in the order of the file, if something is wrong: unknown keys and names (with
/// the nearest one), a wrong number of coordinates, a quaternion that does not have length 1, invalid joints, joints that form no
/// forest; in a document without `mechanisms`, or for one mechanism, also any difference from the model. Throws Error for text
/// that is not JSON.
std::optional<RestoredState> read_state(const std::string& text, const std::string& file, const Model& model,
                                        const std::string& mechanism, std::vector<Diagnostic>& problems);
/// The same; throws the problems as an InputError.
RestoredState read_state(const std::string& text, const std::string& file, const Model& model, const std::string& mechanism = "");

/// Sets a simulation to the state, on top of the model's initial state; with several documents, those of mechanisms are applied
/// after that of the world. If a joint has both v and p, p is used; throws Error if v differs from the velocity that follows
/// from p (by more than 1e-6 of the largest body velocity). Start values that loops and couplings changed are a warning.
std::vector<Diagnostic> restore(Simulation& simulation, const std::vector<RestoredState>& documents);

}  // namespace momentree::io
