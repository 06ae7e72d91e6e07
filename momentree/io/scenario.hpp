#pragma once
// A scenario file (TOML 1.0) as a model, what happens to it, and how it is run and recorded.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/value.hpp>
#include <momentree/io/coupling.hpp>
#include <momentree/io/diagnostic.hpp>
#include <momentree/io/shape.hpp>
#include <momentree/simulate/action.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/tree/model.hpp>

namespace momentree::io {

/// An event at an instant: what `[[event]]` says, names complete and wildcards resolved. An event whose names have a wildcard is
/// one event for each match, all of the same name.
struct ScenarioEvent {
  std::string name;                    ///< its name, or #1, #2 … by its place in the file
  bool named = false;                  ///< by its user: a joint that it makes then has that name
  bool wild = false;                   ///< one of the matches of a name with a wildcard
  double time = 0;                     ///< s; infinite where it is not known
  std::optional<Condition> condition;  ///< when it happens, or
  std::string after;                   ///< after which event,
  double delay = 0;                    ///< and how long after it (s), or
  double period = 0;                   ///< every so often from `time` on (s)
  Place after_place;
  std::vector<Action> actions;
  std::vector<Place> places;  ///< of the actions in the file
  Place place;                ///< of the event
};

/// A state document that a scenario starts from: for the whole world, or for the joints of one mechanism.
struct StateFile {
  std::string file;       ///< relative to the working folder
  std::string mechanism;  ///< empty: the whole world
  Place place;
};

struct Scenario {
  std::string path;  ///< as given
  std::string name;  ///< of the file, without folder and ending
  std::string title;
  std::string text;                         ///< as read
  std::shared_ptr<const Value> document{};  ///< the text as it was read, overrides applied; for a model alone what would name it
  std::string hash;                         ///< 16 hexadecimal digits over the text and the overrides: names the input of a run
  Model model;
  Integration integration;
  double until = 10;                     ///< s
  double output_every = 0;               ///< s; 0: every step
  std::vector<JointCoupling> couplings;  ///< for couple(), once the model is a simulation
  std::vector<ScenarioEvent> events;     ///< in the order of the file
  std::vector<StateFile> state_files;    ///< the world's first
  std::vector<Shape> shapes;             ///< by body number
};

struct ReadResult {
  std::optional<Scenario> scenario;        ///< absent where there is an error
  std::vector<Diagnostic> diagnostics;     ///< errors and warnings, in the order of the file
  std::vector<std::string> model_files{};  ///< that were read, as diagnostics name them
};

/// Reads and checks a scenario, or a model file (URDF, MJCF) as a scenario of that mechanism alone, named after the file.
/// `overrides` are KEY=VALUE: a dotted path and a TOML value, else a string. Every problem is a diagnostic; nothing is thrown.
ReadResult read_scenario(const std::string& path, const std::vector<std::string>& overrides = {});

/// The same from a text that stands in no file, as that of standard input. `path`: what messages call it; `name`: of the
/// scenario, or of the mechanism of a model; `folder`: where the files that it names are looked for, empty: the working folder.
ReadResult read_scenario_from(std::string text, const std::string& path, const std::string& name, const std::string& folder,
                              const std::vector<std::string>& overrides = {});

/// The same from a text. `path` is for messages and names alone: files that the scenario names are not looked for.
ReadResult read_scenario_text(std::string_view text, const std::string& path, const std::vector<std::string>& overrides = {});

}  // namespace momentree::io
