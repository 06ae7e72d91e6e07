#pragma once
// The state document (JSON): a whole world at an instant, changed topology included, as `run` and `evaluate` write it and as
// `--state` and `state = "file.json"` read it.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/world.hpp>

namespace momentree::io {

/// What has become of an event of the scenario so far.
struct ArmedEvent {
  std::string name;
  int fired = 0;  ///< how often it has happened
  /// Of each match of its wildcard, in the order of the model, or of the one event: where its condition stands, when it is due.
  /// Empty: nothing is known but the count.
  std::vector<EventQueue::Armed> each{};
  friend bool operator==(const ArmedEvent&, const ArmedEvent&) = default;
};
/// In the order of the file.
using Armed = std::vector<ArmedEvent>;

/// The document of a world. Numbers read back to the same bits; quaternions have w >= 0. `memory`: of an
/// adaptive method; with a next step of 0 nothing is said of it.
std::string state_json(const World& world, const Armed& armed, const StepMemory& memory = {});

/// What a document says, checked against the model that it is for.
struct RestoredState {
  std::string file;
  std::optional<double> time;
  Forest forest;                   ///< of a whole document; else empty
  std::vector<JointStart> joints;  ///< the joints that it names
  std::vector<std::string> where;  ///< of each of them: `file:line:col`
  Armed armed;
  StepMemory memory;  ///< of an adaptive method; with a next step of 0: unknown
};

/// Reads a document from its text. `mechanism`: take the joints of that mechanism alone, and neither time nor topology (empty:
/// the whole world). Throws Error, `file:line:col`, for the first thing that is wrong: syntax, unknown names (with the nearest
/// one), a wrong number of coordinates, a quaternion that is not one, impossible joints, joints that make no forest; in a
/// document without `mechanisms`, or for one mechanism, also what is not so in the model.
RestoredState read_state(const std::string& text, const std::string& file, const Model& model, const std::string& mechanism = "");

/// Sets a simulation to it, on top of the model's start; several documents: those of mechanisms after that of the world.
/// Where a joint has both v and p, p is used; throws Error where v is not what comes of it (to 1e-6 of the largest body
/// velocity).
void restore(Simulation& simulation, const std::vector<RestoredState>& documents);

}  // namespace momentree::io
