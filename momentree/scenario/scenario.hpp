#pragma once
// A scenario file (TOML 1.0): the model, its events, and how it is run and recorded.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <momentree/base/value.hpp>
#include <momentree/model/model.hpp>
#include <momentree/models/import/shape.hpp>
#include <momentree/simulate/events/action.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/text/diagnostic.hpp>

namespace momentree::io {

/// One `[[event]]`, with complete names and wildcards resolved. An event whose names contain a wildcard becomes one event per
/// match, all of the same name.
struct ScenarioEvent {
  std::string name;                    ///< its name, or #1, #2 … by its position in the file
  bool named = false;                  ///< named by the user: a joint that the event makes gets that name
  bool wild = false;                   ///< one of the matches of a name with a wildcard
  double time = 0;                     ///< s; infinite if unknown
  std::optional<Condition> condition;  ///< its condition, or
  std::string after;                   ///< the event that it follows,
  double delay = 0;                    ///< with this delay (s), or
  double period = 0;                   ///< its period, from `time` on (s)
  Place after_place;
  std::vector<Action> actions;
  std::vector<Place> places;  ///< of the actions in the file
  Place place;                ///< of the event
};

/// A state document that gives the initial state: of the whole world, or of the joints of one mechanism.
struct StateFile {
  std::string file;       ///< relative to the working folder
  std::string mechanism;  ///< empty: the whole world
  Place place;
};

class InputCache;

struct Scenario {
  std::string path;  ///< as given
  std::string name;  ///< the file's name without folder and extension
  std::string title;
  std::string text;  ///< as read
  /// the parsed text with overrides applied; for a bare model, a scenario that names it
  std::shared_ptr<const Value> document{};
  std::string hash;  ///< 16 hexadecimal digits over the text and the overrides: names the input of a run
  Model model;
  Integration integration;
  double until = 10;                   ///< s
  double output_every = 0;             ///< s; 0: every step
  std::vector<ScenarioEvent> events;   ///< in the order of the file
  std::vector<StateFile> state_files;  ///< the document of the whole world first
  std::vector<Shape> shapes;           ///< by body number
  /// By collider; none, or missing: it was not given as a shape of a body. Of a mesh that is split the first part has the shape.
  std::vector<Shape> collision_shapes;
  std::shared_ptr<InputCache> inputs{};  ///< files that further readings need not read again; null: they read them
};

/// Appends the shapes of the colliders that were added last to those of all colliders of a model.
void note_collision_shapes(const Model& model, std::vector<Shape> added, std::vector<Shape>& all);

struct ReadResult {
  std::optional<Scenario> scenario;        ///< absent if there is an error
  std::vector<Diagnostic> diagnostics;     ///< errors and warnings, in the order of the file
  std::vector<std::string> model_files{};  ///< the model files that were read, as diagnostics name them
};

/// Reads and checks a scenario, or a model file (URDF, SDF, MJCF) as a scenario with a single mechanism, named after the file.
/// `overrides` are KEY=VALUE: a dotted path and a TOML value, else a string. Every problem is a diagnostic; nothing is thrown.
ReadResult read_scenario(const std::string& path, const std::vector<std::string>& overrides = {});

/// Reads a scenario again with other overrides, without reading and parsing its text: for many variations. `scenario` was read
/// without overrides. Model files are read again, unless they are in its InputCache.
ReadResult read_scenario_again(const Scenario& scenario, const std::vector<std::string>& overrides);

/// Like read_scenario, from a text that is not in a file, such as standard input. `path`: how messages name it; `name`: the
/// name of the scenario, or of the mechanism of a model; `folder`: where the files that it names are located, empty: the
/// working folder.
ReadResult read_scenario_from(std::string text, const std::string& path, const std::string& name, const std::string& folder,
                              const std::vector<std::string>& overrides = {});

/// Like read_scenario, from a text. `path` is for messages and names alone: files that the scenario names are not accessed.
ReadResult read_scenario_text(std::string_view text, const std::string& path, const std::vector<std::string>& overrides = {});

}  // namespace momentree::io
