#pragma once
// The parts of a scenario file, one reader each. Internal to the reader: scenario.hpp is what others use.
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <momentree/io/fields.hpp>
#include <momentree/io/model/model_file.hpp>
#include <momentree/io/scenario.hpp>

namespace momentree::io {

/// Where [integrate] and [output] say what; the table, or nowhere, where they don't.
struct IntegratePlaces {
  Place step{}, until{}, rtol{}, atol{}, max_step{}, event_tolerance{}, every{};
};

/// What the parts share while one file is read.
struct Reading {
  Scenario& scenario;
  Diagnostics& out;
  std::string folder;   ///< of the scenario, for the files that it names
  Enclosure enclosure;  ///< where the meshes that it names stand
  bool looks_at_files = true;
  bool direct = false;  ///< a model without a scenario

  /// Model files by the names that mechanisms call them by, and where the joints of those stand.
  std::vector<std::pair<std::string, std::unique_ptr<Import>>> models{};
  std::unordered_map<std::string, BodySpots> from_model{};

  /// First places of names, complete ("mechanism/joint"): duplicates name both, events find their targets.
  std::unordered_map<std::string, Place> mechanisms{}, bodies{}, joints{}, events{};
  std::unordered_map<std::string, std::string> body_of_joint{};  ///< where they differ
  /// Mechanisms whose bodies this version can't know: names in them are not judged.
  std::unordered_set<std::string> opaque{};
  /// Joints that welds and attachments of events make, by the names that they get.
  std::unordered_map<std::string, Place> made{};
  std::vector<std::string_view> sorted_joints{}, sorted_bodies{};  ///< for wildcards; filled once all are known
  /// What can be judged only once all events are known: joints that actions name, and parameters that are set.
  struct JointUse {
    std::string name, key;
    Place place{};
    double time = 0;
  };
  struct LateEntry {
    std::shared_ptr<ActionBase> action;
    const Value* value = nullptr;
    std::string match;  ///< of its name with a wildcard
    double time = 0;
  };
  std::vector<JointUse> joint_uses{};
  std::vector<Place> coupling_places{};  ///< of the scenario's couplings
  std::vector<LateEntry> late{};
  IntegratePlaces integrate{};
  long suggestions_left = 2'000'000;  ///< names that may yet be compared to find the nearest
  int bodies_left = 1'000'000, actions_left = 1'000'000;

  std::size_t model_errors() const {
    std::size_t count = 0;
    for (const auto& [name, import] : models) count += import->errors();
    return count;
  }
  const Import* model_named(std::string_view file) const {
    for (const auto& [name, import] : models)
      if (name == file) return import.get();
    return nullptr;
  }

  /// False, with a report, where the name is no name or was given before.
  bool note(std::unordered_map<std::string, Place>& names, const std::string& name, Place place, const char* what);
  /// did_you_mean over names, as long as that is cheap.
  std::string suggest(const std::string& name, const std::unordered_map<std::string, Place>& names);
};

/// A body while its mechanism is read: its parent is still a name.
struct BodyEntry {
  BodySpec spec;
  Shape shape;
  const Value* table = nullptr;
  const Value* joint = nullptr;  ///< the joint's table, or null
  std::string bare_name, bare_joint, parent;
  Place name_place{}, parent_place{};
  bool rooted = false;  ///< joined to the ground
  bool named = false;   ///< its name is its own: others may refer to it
};

/// A mechanism's `state`, by its joints' bare names.
struct MechanismState {
  std::unordered_map<std::string, const Value*> joints;
  const Value* velocity = nullptr;
};

/// What `root` says.
enum class Held { unsaid, fixed, free };

/// What a mechanism says of its model.
struct ModelChoice {
  Held held = Held::unsaid;
  Pose pose{};
  MechanismState state{};
  std::optional<bool> limits{};           ///< the file's are taken up
  std::optional<CouplingSpring> mimic{};  ///< by which joints follow others where the file says so
  Place model_place{}, root_place{}, limits_place{}, mimic_place{};
};

/// Bare names of bodies and joints: what a path, a column or a wildcard could not carry is refused.
bool check_bare_name(const std::string& name, Place place, std::string_view what, Diagnostics& out);

BodyEntry read_body(const Value& table, const std::string& mechanism, Reading& reading);
/// A table, or a list of them.
Shape read_shape(const Value& value, Reading& reading);
/// kind, geometry, parameters, start and parent of a joint.
void read_joint(const Value& table, BodyEntry& body, Reading& reading);
/// Start values as a mechanism's state gives them under a joint's name: a number for kinds with one freedom, a list of
/// coordinates, or a table with the keys of a joint's start.
void read_joint_state(const Value& value, std::string_view joint, BodySpec& spec, Diagnostics& out);

/// q, v, angle, position and speed.
void read_start(Fields& fields, const KindInfo& kind, Values& q, Values& v, Diagnostics& out);
/// A joint whose motion is prescribed starts where that starts; `q` and `v`: where the file gives them otherwise.
void start_motion(BodySpec& spec, const std::optional<Place>& q, const std::optional<Place>& v, Diagnostics& out);

class JointTables;

void read_mechanism(const Value& table, Reading& reading);
/// `errors`: how many there were before this mechanism. Its bodies are added where none came since.
void read_chain(const Value& table, const std::string& mechanism, bool free_root, const Pose& pose, const MechanismState& state,
                JointTables& joints, std::size_t errors, Reading& reading);
/// The bodies of a model file. `errors`: as above.
void read_model(const Value& file, const std::string& mechanism, const ModelChoice& choice, JointTables& joints,
                std::size_t errors, Reading& reading);
/// Puts the bodies of a mechanism, root first and parents before children, in the order of the file as far as that allows; empty,
/// with reports, where there are not as many roots as the mechanism says, a parent is unknown or the joints go round in a circle.
std::vector<std::size_t> order_of(const std::vector<BodyEntry>& bodies, const std::string& mechanism, Place place,
                                  std::size_t roots, Reading& reading);
/// The root's velocity, in its own axes at its frame's origin, as velocities of a free joint.
void read_root_velocity(const Value& value, BodySpec& root, Diagnostics& out);

/// kind, axis, axis2, pitch and parameters of a joint that an action makes. `keeps_axes`: axes that are not given stay.
void read_description(Fields& fields, bool keeps_axes, JointDescription& joint, Diagnostics& out);
/// Parameters for a joint of that kind.
void read_parameters(Fields& fields, const KindInfo& kind, JointParameters& parameters, Diagnostics& out);
/// The same where the kind is not known: numbers in SI.
void read_plain_parameters(Fields& fields, JointParameters& parameters, Diagnostics& out);
/// What check_joint() finds, at the keys; true if it found something.
bool report_problems(const JointSpec& joint, const Fields& fields, Diagnostics& out);

/// `*` matches any run of characters but '/'.
bool matches_wildcard(std::string_view pattern, std::string_view name);
/// What a name with `*` stands for, in the order of the model.
std::vector<std::string> matching_joints(const std::string& pattern, Reading& reading);
std::vector<std::string> matching_bodies(const std::string& pattern, Reading& reading);

void read_force(const Value& table, Reading& reading);

void read_coupling(const Value& table, Reading& reading);
/// stiffness and damping; `slides`: of a joint that slides, in N/m and N s/m.
CouplingSpring read_coupling_spring(Fields& fields, bool slides);
/// Takes it up, with a warning where the joint does not start where it should.
void add_coupling(const JointCoupling& coupling, Place place, Reading& reading);
/// None follows itself by way of others. And coupled joints do not become others: what a change would have to do with the spring
/// is not said.
void check_couplings(Reading& reading);

/// One of the names that a wildcard in a condition stands for; where the event's actions have the same wildcard, they act on it:
/// on the joint, or on the body that it carries.
struct TriggerMatch {
  std::string pattern, joint, body;
};
/// What a wildcard in an event's `when` stands for; nothing where it has none, and empty, with a report, where nothing matches.
std::optional<std::vector<TriggerMatch>> matches_of_trigger(const Value& event, Reading& reading);
/// at, when, after or every, and what goes with them. `match`: for this match of the condition's wildcard; null: it has none.
void read_trigger(Fields& fields, ScenarioEvent& event, const TriggerMatch* match, Reading& reading);
void read_event(const Value& table, int number, Reading& reading);
/// One key of an event with all that it holds: names, tables, or a list of them. Actions whose names have a wildcard become
/// events of their own, in `wild`; but where the event is itself for one `match` of its condition's wildcard, they belong to it:
/// on what matches, where the wildcard is the same, or else on all that theirs stands for.
void read_actions(const Value& value, const std::string& key, ScenarioEvent& event, const TriggerMatch* match,
                  std::vector<ScenarioEvent>& wild, Reading& reading);
/// What only all events together show: which joints they make, which names mean nothing, what is set.
void finish_events(Reading& reading);
/// What will be impossible or do nothing: tried by carrying all events out in their order.
void check_events(Reading& reading);

void read_world(const Value& table, Reading& reading);
void read_integrate(const Value& table, Reading& reading);
/// Judges steps, tolerances and the length of the run, together and for the model.
void check_integration(Reading& reading);
/// Warns where a tolerance asks for more than the momenta of this mechanism can tell.
void check_tolerance(Reading& reading);
void read_output(const Value& table, Reading& reading);

}  // namespace momentree::io
