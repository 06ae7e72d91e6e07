#pragma once
// The parts of a scenario file, one reader each. Internal to the reader: other code uses scenario.hpp.
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <momentree/base/wildcard.hpp>
#include <momentree/contact/uniform_mass.hpp>
#include <momentree/models/import/model_file.hpp>
#include <momentree/models/import/solid_mesh.hpp>
#include <momentree/scenario/keys/fields.hpp>
#include <momentree/scenario/scenario.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree::io {

/// The places of the values in [integrate] and [output]; the place of the table, or none, for absent values.
struct IntegratePlaces {
  Place step{}, until{}, rtol{}, atol{}, max_step{}, event_tolerance{}, every{}, variables{};
};

/// The place of an exact coupling: in the scenario, or an element of a model file.
struct CouplingPlace {
  Place place{};
  XmlFile* file = nullptr;
  XmlElement element{};
};

/// State shared by the part readers while one file is read.
struct Reading {
  Scenario& scenario;
  Diagnostics& out;
  std::string folder;   ///< the scenario's folder, for the files that it names
  Enclosure enclosure;  ///< the folders that may contain its meshes
  bool looks_at_files = true;
  bool direct = false;  ///< a model without a scenario

  /// Model files by the names that mechanisms use, and the places of their joints.
  std::vector<std::pair<std::string, std::shared_ptr<Import>>> models{};
  std::unordered_map<std::string, BodySpots> from_model{};

  /// First places of complete names ("mechanism/joint"), for reporting duplicates and for finding the targets of events.
  std::unordered_map<std::string, Place> mechanisms{}, bodies{}, joints{}, springs{}, events{};
  std::unordered_map<std::string, std::string> body_of_joint{};  ///< if the names differ
  /// Mechanisms whose bodies cannot be determined: names in them are not checked.
  std::unordered_set<std::string> opaque{};
  /// Joints that weld and attach actions of events make, by their names.
  std::unordered_map<std::string, Place> made{};
  std::vector<std::string_view> sorted_joints{}, sorted_bodies{};  ///< for wildcards; filled once all names are known
  /// Uses of joints that can be checked only once all events are read: joints named by actions, and parameters that are set.
  struct JointUse {
    std::string name, key;
    Place place{};
    double time = 0;
    bool of_parameters = false;  ///< of an action that sets parameters, which comes after the other actions of its instant
    bool springs_too = false;    ///< the name may be that of a spring
  };
  /// Quantities of contacts: whether their bodies can touch is known once everything is read.
  struct SolidUse {
    std::shared_ptr<const momentree::Quantity> what;
    Place place{};
  };
  struct LateEntry {
    std::shared_ptr<ActionBase> action;
    const Value* value = nullptr;
    std::string match;  ///< the match of the name's wildcard
    double time = 0;
  };
  std::vector<JointUse> joint_uses{};
  std::vector<SolidUse> solid_uses{};
  /// Collision elements of model files: they count only if there is something else to touch, or the mechanism asks for them.
  struct ModelColliders {
    std::shared_ptr<Import> import;
    std::string mechanism;
    int first = 0;  ///< number of its first body
    Pose pose{};    ///< of the file's axes in the world
    Place place{};
    bool always = false;
    std::optional<double> split{};  ///< of its meshes, see Shape::split; nothing: as the file says
  };
  std::vector<ModelColliders> model_colliders{};
  std::optional<ContactRule> floor_rule{};
  std::vector<Place> element_places{};        ///< places of the model's elements between joints
  std::vector<CouplingPlace> exact_places{};  ///< places of the model's exact couplings
  std::vector<LateEntry> late{};
  IntegratePlaces integrate{};
  long suggestions_left = 2'000'000;  ///< remaining budget of name comparisons for suggestions
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

  /// False, with a report, if the name is invalid or was given before.
  bool note(std::unordered_map<std::string, Place>& names, const std::string& name, Place place, const char* what);
  /// did_you_mean over the names, while the budget lasts.
  std::string suggest(const std::string& name, const std::unordered_map<std::string, Place>& names);
};

/// A body while its mechanism is read: its parent is still a name.
struct BodyEntry {
  BodySpec spec;
  Shape shape;
  std::vector<contact::Solid> collision;  ///< what it touches with
  std::vector<Shape> collision_shapes{};  ///< of which these are made, by solid; see Scenario::collision_shapes
  const Value* table = nullptr;
  const Value* joint = nullptr;  ///< the joint's table, or null
  std::string bare_name, bare_joint, parent;
  Place name_place{}, parent_place{};
  bool rooted = false;  ///< joined to the ground
  bool named = false;   ///< its name is given in the file: others may refer to it
};

/// A mechanism's `state`, by the bare names of its joints.
struct MechanismState {
  std::unordered_map<std::string, const Value*> joints;
  const Value* velocity = nullptr;
};

/// The value of `root`.
enum class Held { unsaid, fixed, free };

/// The keys of a mechanism that concern its model file.
/// How joints of a model file that follow others do so.
struct Mimic {
  enum class How { spring, exact, independent };
  How how = How::spring;
  elements::SpringCoupling spring{};  ///< its stiffness and damping
};

struct ModelChoice {
  Held held = Held::unsaid;
  Pose pose{};
  MechanismState state{};
  std::optional<bool> limits{};     ///< whether the file's limits are used
  std::optional<Mimic> mimic{};     ///< how joints follow others according to the file
  std::optional<bool> collision{};  ///< whether its collision elements are used
  std::optional<double> split{};    ///< of its meshes, see Shape::split
  Place model_place{}, root_place{}, limits_place{}, mimic_place{};
};

BodyEntry read_body(const Value& table, const std::string& mechanism, Reading& reading);
/// Reads a shape table, or a list of them. A drawn mesh that does not exist is a warning; otherwise the caller judges it.
enum class ShapeUse { drawn, body, ground };
Shape read_shape(const Value& value, Reading& reading, ShapeUse use = ShapeUse::drawn);
/// The value of `split` of a mesh.
double read_split(const Value& value, Diagnostics& out);
/// Reads kind, geometry, parameters, initial values and parent of a joint.
void read_joint(const Value& table, BodyEntry& body, Reading& reading);
/// Initial values that a mechanism's state gives under a joint's name: a number for kinds with one DoF, a list of coordinates,
/// or a table with the keys of a joint's initial values.
void read_joint_state(const Value& value, std::string_view joint, BodySpec& spec, Diagnostics& out);

/// Reads q, v, angle, position and speed.
void read_start(Fields& fields, const KindInfo& kind, Values& q, Values& v, Diagnostics& out);
/// A joint whose motion is prescribed starts on that motion; `q` and `v`: the places that give different values in the file.
void start_motion(BodySpec& spec, const std::optional<Place>& q, const std::optional<Place>& v, Diagnostics& out);

class JointTables;

void read_mechanism(const Value& table, Reading& reading);
/// `errors`: the number of errors before this mechanism. Its bodies are added only if there are no new errors.
void read_chain(const Value& table, const std::string& mechanism, bool free_root, const Pose& pose, const MechanismState& state,
                JointTables& joints, std::size_t errors, Reading& reading);
/// Reads the bodies of a model file. `errors`: as above.
void read_model(const Value& file, const std::string& mechanism, const ModelChoice& choice, JointTables& joints,
                std::size_t errors, Reading& reading);
/// Gives a joint the stops of its model file, if the mechanism requests them and the joint has no others. Returns true if so.
bool take_limits(const JointLimits& limits, const ModelChoice& choice, const std::string& joint, JointParameters& parameters,
                 Reading& reading);
/// Adds the loop joints of a model file, whose bodies begin at `first`. `errors`: as above.
void read_model_loops(const Import& import, const std::string& mechanism, const ModelChoice& choice, JointTables& joints,
                      int first, std::size_t errors, Reading& reading);
/// Reports start values that the mechanism's state gives to joints that close loops.
bool check_loop_starts(const Import& import, const MechanismState& state, Reading& reading);
/// Why a loop joint has no start values.
inline constexpr const char* no_loop_start = "closes a loop and has no start values: its position follows from the other joints";
inline constexpr const char* no_loop_start_hint = "give start values to the joints of the tree";
/// The order of a mechanism's bodies: root first and parents before children, otherwise as in the file. Empty, with reports, if
/// the number of roots is not that of the mechanism, a parent is unknown, or the joints form a cycle.
std::vector<std::size_t> order_of(const std::vector<BodyEntry>& bodies, const std::string& mechanism, Place place,
                                  std::size_t roots, Reading& reading);
/// The root's velocity (m/s, rad/s), in its own axes at its frame's origin, as the velocities of a free joint.
void read_root_velocity(const Value& value, BodySpec& root, Diagnostics& out);

/// Reads kind, axis, axis2, pitch and parameters of a joint that an action makes. `keeps_axes`: axes that are not given stay
/// unchanged.
void read_description(Fields& fields, bool keeps_axes, JointDescription& joint, Diagnostics& out);
/// Reads the parameters of a joint of that kind; null: the kind is unknown, and numbers are in SI units.
void read_parameters(Fields& fields, const KindInfo* kind, JointParameters& parameters, Diagnostics& out);
/// Reports the findings of check_joint() at the keys; true if there are any.
bool report_problems(const JointSpec& joint, const Fields& fields, Diagnostics& out);

/// The part of a name before the first '/'.
std::string mechanism_of(const std::string& name);
/// The joints that match a name with `*`, in the order of the model; with `springs_too` then the springs.
std::vector<std::string> matching_joints(const std::string& pattern, bool springs_too, Reading& reading);
std::vector<std::string> matching_bodies(const std::string& pattern, Reading& reading);

void read_force(const Value& table, Reading& reading);

/// The value of a body's `collision`; it has its shape already.
void read_collision(const Value& value, BodyEntry& body, Reading& reading);
/// See contact::Solid::belt.
Vec3 read_belt(const Value& value, Diagnostics& out);
void add_colliders(BodyId body, const std::vector<contact::Solid>& solids, Model& model);
struct ShapeReports {
  ReportOnShape refuse;    ///< it touches nothing: it has no volume, or cannot be read
  ReportOnShape warn;      ///< a mesh differs from what touches
  ReportOnShape unclosed;  ///< a mesh that was to be split is not closed: its hull touches
  ReportOnShape fail;      ///< a mesh was to be split, and could not be
};
/// What a shape touches with, in the body's frame: one solid, or the parts of a mesh. Nothing, with a report, if it touches
/// nothing.
std::vector<contact::Solid> solids_of(const Shape& shape, const ShapeReports& report);
/// A plane, or what a shape touches with, as colliders of the ground; `pose`: of the shape's frame. Nothing: as solids_of().
std::vector<Collider> ground_colliders(Shape shape, const Pose& pose, const ShapeReports& report);
/// Adds the collision elements of model files and their friction, then the floor's friction. `[[contact]]` comes after it.
void add_model_colliders(bool rules, Reading& reading);
void read_floor(const Value& value, Reading& reading);
/// The value of `collision` of the world.
void read_ground(const Value& value, Reading& reading);
void read_contact(const Value& table, Reading& reading);
/// The pair that overlaps most at the start. Pairs within one model file pass through each other, with a warning.
std::optional<Overlap> overlap_between_models(Reading& reading);
/// Errors for conditions on bodies that can't touch each other.
void check_solid_uses(const Model& model, const std::vector<Reading::SolidUse>& uses, Diagnostics& out);
/// What can be checked only once the whole model is read.
void check_contacts(Reading& reading);

void read_loop(const Value& table, Reading& reading);
/// False, with a report, if the loops need more memory than is reasonable.
bool loops_fit(Reading& reading);
/// Reports loops that cannot be closed at the start.
void check_loops(Reading& reading);

void read_spring(const Value& table, Reading& reading);
void read_cable(const Value& table, Reading& reading);

void read_coupling(const Value& table, Reading& reading);
/// The joint of a name, if it has one DoF and, `driven`, may be driven by a function; else −1, with a report.
JointId coupled_joint(const Value& value, const char* key, bool driven, Reading& reading);
/// Adds an exact coupling, with a warning if the joint is given another start value than the coupling requires.
void add_exact_coupling(const Coupling& coupling, const CouplingPlace& place, Reading& reading);
/// Reads stiffness and damping; `along_axis`: of a joint whose coordinate is a length, in N/m and N s/m.
void read_coupling_spring(Fields& fields, bool along_axis, elements::SpringCoupling& spring);
/// Adds the coupling, with a warning if the joint does not start at the position that the coupling requires.
void add_spring_coupling(const elements::SpringCoupling& coupling, Place place, Reading& reading);
/// Reports joints that follow themselves through others, and events that change joints that are coupled or have elements: the
/// effect of such a change is not defined.
void check_couplings(Reading& reading);

/// One match of a wildcard in a condition. Actions of the event with the same wildcard act on this match: on the joint, or on
/// the body that it carries.
struct TriggerMatch {
  std::string pattern, joint, body;
};
/// The matches of a wildcard in an event's `when`; nothing if there is no wildcard, and empty, with a report, if nothing
/// matches.
std::optional<std::vector<TriggerMatch>> matches_of_trigger(const Value& event, Reading& reading);
/// Reads a table that names one quantity and nothing else, called `what` in messages; null, with a report, if it is wrong.
std::shared_ptr<momentree::Quantity> read_quantity(const Value& table, const std::string& what, Reading& reading);
/// Reads at, when, after or every, and the keys that go with them. `match`: the match of the condition's wildcard; null: it has
/// none.
void read_trigger(Fields& fields, ScenarioEvent& event, const TriggerMatch* match, Reading& reading);
void read_event(const Value& table, int number, Reading& reading);
/// The keys of the actions that scenario files can use.
const std::vector<std::string>& scenario_actions();
/// True for an action that sets parameters of a joint: their units depend on its kind, which another event may determine.
bool sets_parameters(WithArguments& action);
/// Reads one key of an event: a name, a table, or a list of them. Actions whose names contain a wildcard become separate events
/// in `wild`. If the event itself belongs to one `match` of its condition's wildcard, its actions stay with it: an action with
/// the same wildcard acts on that match, any other on all matches of its own wildcard.
void read_actions(const Value& value, const std::string& key, ScenarioEvent& event, const TriggerMatch* match,
                  std::vector<ScenarioEvent>& wild, Reading& reading);
/// Checks that need all events: the joints that they make, unknown names, parameters that are set.
void finish_events(Reading& reading);
/// Reports actions that will be impossible or have no effect, by carrying all events out in order in a dry run.
void check_events(Reading& reading);

void read_world(const Value& table, Reading& reading);
void read_integrate(const Value& table, Reading& reading);
/// Checks steps, tolerances and the length of the run, together and against the model.
void check_integration(Reading& reading);
/// Warns if a tolerance is finer than the momenta of this mechanism can resolve.
void check_tolerance(Reading& reading);
void read_output(const Value& table, Reading& reading);

}  // namespace momentree::io
