// A mechanism described by a model file: its placement, its root joint, its initial values, and the parts of the file that are
// used.
#include <algorithm>
#include <deque>
#include <filesystem>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/model/start.hpp>
#include <momentree/scenario/keys/joint_tables.hpp>
#include <momentree/text/files/input_cache.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

namespace fs = std::filesystem;

// The model of a file, read once; null, with a report, if it cannot be read.
const Import* model_of(const Value& file, Reading& reading) {
  const auto name = read_string(file, "model", reading.out);
  if (!name) return nullptr;
  if (name->empty()) {
    reading.out.error(file.place, "model: expected the name of a file", "a .urdf, relative to the scenario");
    return nullptr;
  }
  if (const Import* known = reading.model_named(*name)) return known;
  if (InputCache* const inputs = reading.scenario.inputs.get())
    if (std::shared_ptr<Import> kept = inputs->model(*name)) return reading.models.emplace_back(*name, kept).second.get();
  if (!reading.looks_at_files) {
    reading.out.error(file.place, "model: a scenario read from text cannot name files", "read it from its file");
    return nullptr;
  }
  const fs::path path = fs::path(reading.folder) / *name;
  std::string text;
  Unreadable why;
  if (!read_whole_file(path.string(), "model", largest_model, text, why)) {
    reading.out.error(file.place, "model: " + in_quotes(path.string()) + ": " + why.what, why.hint);
    return nullptr;
  }
  const std::string folder = path.parent_path().string();
  auto import = read_model_text(path.string(), std::move(text), folder.empty() ? "." : folder);
  return reading.models.emplace_back(*name, std::move(import)).second.get();
}

// `limits`: those of the file.
void check_within_limits(const BodySpec& spec, const JointLimits& limits, const ModelChoice& choice, Reading& reading) {
  if (!limits.any() || !(spec.joint.parameters.limits == limits)) return;  // not used
  for (int i = 0; i < spec.q.size(); ++i) {
    const double lower = limits.lower_of(i), upper = limits.upper_of(i);
    if (spec.q[i] >= lower && spec.q[i] <= upper) continue;
    reading.out.error(choice.limits_place,
                      "limits: joint " + in_quotes(spec.joint_name) + " starts at " + rounded_text(spec.q[i], 6) +
                          ", beyond its limits of " + rounded_text(lower, 6) + " and " + rounded_text(upper, 6),
                      "give it a start within them, in state = { joints = { … } } or [mechanism.joint." + spec.joint_name + "]");
  }
}

// `limited`: the number of joints whose limits in the file are not used.
void warn_of_limits(std::ptrdiff_t limited, const std::string& mechanism, const ModelChoice& choice, Reading& reading) {
  if (limited > 0 && !choice.limits)
    reading.out.warning(choice.model_place,
                        "the limits of " + std::to_string(limited) + (limited == 1 ? " joint" : " joints") + " are not used",
                        reading.direct ? "choose with --set mechanism." + mechanism + ".limits=true, or false"
                                       : "write limits = true or limits = false");
}

void hold(BodySpec& spec, const ImportedBody& body, const ModelChoice& choice) {
  if (body.own_joint) {
    spec.at = choice.pose * spec.at;
  } else if (choice.held == Held::free || (choice.held == Held::unsaid && body.floats)) {
    const Pose start = choice.pose * spec.at;
    const Quat& r = start.rotation;
    spec.joint.kind = Kind::free;
    spec.at = {};
    spec.q = {start.position.x, start.position.y, start.position.z, r.w, r.x, r.y, r.z};
  } else {
    spec.at = choice.pose * spec.at;
  }
}

// Checks `root` and the velocity; false if it is ambiguous whose velocity it is.
bool check_roots(const Import& import, const ModelChoice& choice, Reading& reading) {
  std::size_t roots = 0;
  bool taken = false;
  for (const ImportedBody& body : import.model.bodies) {
    if (body.spec.parent != ground) continue;
    ++roots;
    taken = taken || !body.own_joint;
  }
  if (choice.held != Held::unsaid && !taken)
    reading.out.error(choice.root_place, "root: every root of this model has its own joint to the ground", "leave 'root' out");
  if (choice.state.velocity && roots > 1)
    reading.out.error(choice.state.velocity->place,
                      "velocity: this model has " + std::to_string(roots) + " roots, and one velocity is ambiguous",
                      "give v for their joints in state.joints");
  return roots == 1;
}

void check_state(const Import& import, const MechanismState& state, Reading& reading) {
  if (state.joints.empty()) return;
  std::unordered_map<std::string, Place> known;
  if (!check_loop_starts(import, state, reading)) return;
  for (const ImportedBody& body : import.model.bodies) known.emplace(body.spec.joint_name, Place{});
  for (const auto& [name, value] : state.joints)
    if (!known.contains(name))
      reading.out.error(value->place, "state: there is no joint " + in_quotes(name) + " in this model",
                        reading.suggest(name, known));
}

void warn_of_followers(const Import& import) {
  for (const Follower& each : import.model.followers) {
    if (each.exact) continue;
    const BodySpec &own = import.model.bodies[static_cast<std::size_t>(each.body)].spec,
                   &leader = import.model.bodies[static_cast<std::size_t>(each.leader)].spec;
    const std::string follows = "joint " + in_quotes(own.joint_name) + " should follow " + in_quotes(leader.joint_name);
    if (info(own.joint.kind).nv != 1 || info(leader.joint.kind).nv != 1)
      each.file->warning({each.element}, follows + ", but joints without one degree of freedom can't be coupled",
                         "let it follow a joint that moves, or leave out the <mimic>");
    else
      each.file->warning({each.element}, follows + ", but moves independently here",
                         "mimic = \"exact\" in the mechanism couples them; mimic = { stiffness = … } does so by a spring");
  }
}

// Those that a mechanism couples exactly, and those that it couples by springs.
bool is_exact(const Follower& each, const ModelChoice& choice) {
  if (!choice.mimic) return each.exact;
  return choice.mimic->how == Mimic::How::exact || (choice.mimic->how == Mimic::How::spring && !each.linear());
}
bool by_spring(const Follower& each, const ModelChoice& choice) {
  return choice.mimic && choice.mimic->how == Mimic::How::spring && each.linear();
}

// Joints that follow others can be coupled if they have one DoF each.
bool check_followers(const Import& import, const ModelChoice& choice, Reading& reading) {
  const auto& bodies = import.model.bodies;
  const auto name = [&](int body) { return in_quotes(bodies[static_cast<std::size_t>(body)].spec.joint_name); };
  const std::size_t errors = reading.out.errors();
  for (const Follower& each : import.model.followers)
    for (const int end : {each.body, each.leader})
      if (end >= 0 && (by_spring(each, choice) || is_exact(each, choice)) &&
          info(bodies[static_cast<std::size_t>(end)].spec.joint.kind).nv != 1)
        reading.out.error(
            choice.mimic_place,
            "mimic: joint " + name(end) + " does not have one degree of freedom, but joint " + name(each.body) +
                (end == each.body ? " follows " + (each.leader < 0 ? "nothing" : name(each.leader)) : " follows it") + " (" +
                each.file->path() + ", " + each.file->line_of(each.element) + ")",
            "couple the others with [[coupling]] tables");
  return errors == reading.out.errors();
}

// The initial values of joints that follow by a spring are computed from their leaders, unless the mechanism gives others. Those
// of exact couplings are not given: they follow when the world starts.
void start_followers(const Import& import, const ModelChoice& choice, const JointTables& joints, std::deque<BodySpec>& specs) {
  std::unordered_map<int, const Follower*> waiting;
  for (const Follower& each : import.model.followers) {
    const std::string& name = specs[static_cast<std::size_t>(each.body)].joint_name;
    if (!by_spring(each, choice) && !is_exact(each, choice)) continue;
    if (!choice.state.joints.contains(name) && !joints.start_of(name)) waiting.emplace(each.body, &each);
  }
  std::unordered_map<int, double> follows;
  const auto start_of = [&](int body) {
    const auto known = follows.find(body);
    return known != follows.end() ? known->second : start_coordinates(specs[static_cast<std::size_t>(body)])[0];
  };
  while (!waiting.empty()) {
    std::vector<const Follower*> path;  // from a follower to a leader with a known position
    for (auto at = waiting.begin(); at != waiting.end(); at = waiting.find(path.back()->leader)) {
      path.push_back(at->second);
      waiting.erase(at);
    }
    for (; !path.empty(); path.pop_back()) {
      const Follower& each = *path.back();
      const double own = each.coupling(0).value(each.leader < 0 ? 0 : start_of(each.leader));
      Values& q = specs[static_cast<std::size_t>(each.body)].q;
      if (is_exact(each, choice))
        q = {};
      else if (own != start_of(each.body))
        q = {own};
      follows.emplace(each.body, own);
    }
  }
}

// A spring cannot move a joint whose motion is prescribed.
bool check_motions(const Import& import, const ModelChoice& choice, const std::deque<BodySpec>& specs, Reading& reading) {
  const std::size_t errors = reading.out.errors();
  for (const Follower& each : import.model.followers)
    for (const int end : {each.body, each.leader}) {
      if (!by_spring(each, choice)) continue;
      const BodySpec& spec = specs[static_cast<std::size_t>(end)];
      if (const auto& drive = spec.joint.parameters.drive; drive && drive->moves())
        reading.out.error(choice.mimic_place, "mimic: the motion of joint " + in_quotes(spec.joint_name) + " is prescribed",
                          "drive it by position control: drive = { pd = { … } }");
    }
  return errors == reading.out.errors();
}

// The mechanism gives the initial position of a joint.
bool gives_position(const ModelChoice& choice, const JointTables& joints, const BodySpec& spec) {
  if (joints.gives_position(spec.joint_name, spec.joint.kind)) return true;
  const auto state = choice.state.joints.find(spec.joint_name);
  if (state == choice.state.joints.end()) return false;
  const Value& value = *state->second;
  return !value.table() || value.find("q") || value.find("angle") || value.find("position");
}

// Takes the limits of the file. Many models rest outside their own limits: joints whose position nobody chose start at the
// nearest limit.
void take_limits_of(const Import& import, const ModelChoice& choice, const JointTables& joints, std::deque<BodySpec>& specs,
                    Reading& reading) {
  std::set<int> coupled;  // their positions follow from others
  for (const Follower& each : import.model.followers)
    if (by_spring(each, choice) || is_exact(each, choice)) coupled.insert(each.body);
  constexpr int shown = 3;
  int moved = 0;
  std::string text;
  for (std::size_t b = 0; b < specs.size(); ++b) {
    BodySpec& spec = specs[b];
    const Values rest = start_coordinates(spec);
    if (!take_limits(import.model.bodies[b].limits, choice, spec.joint_name, spec.joint.parameters, reading)) continue;
    if (coupled.contains(static_cast<int>(b)) || gives_position(choice, joints, spec)) continue;
    if (!spec.q.empty()) spec.q = within_stops(spec.joint.parameters.limits, rest);  // the file gives a position
    const Values start = start_coordinates(spec);
    for (int i = 0; i < rest.size(); ++i)
      if (start[i] != rest[i] && ++moved <= shown)
        text += (moved > 1 ? ", " : "") + in_quotes(spec.joint_name) + " at " + rounded_text(start[i], 6) + " instead of " +
                rounded_text(rest[i], 6);
  }
  if (moved == 0) return;
  if (moved > shown) text += " and " + std::to_string(moved - shown) + " more";
  reading.out.warning(
      choice.limits_place,
      "limits: the model rests outside its limits; joints that no loop or coupling moves start at the nearest limit: " + text,
      "choose another start in state = { joints = { … } } or [mechanism.joint.NAME]");
}

void couple_followers(const Import& import, const ModelChoice& choice, int first, Reading& reading) {
  for (const Follower& each : import.model.followers) {
    if (by_spring(each, choice)) {
      elements::SpringCoupling spring = choice.mimic->spring;
      spring.joint = {first + each.body}, spring.follows = {first + each.leader};
      spring.multiplier = each.multiplier, spring.offset = each.offset;
      add_spring_coupling(spring, choice.mimic_place, reading);
    } else if (is_exact(each, choice))
      add_exact_coupling(each.coupling(first),
                         {choice.mimic ? choice.mimic_place : Place{}, choice.mimic ? nullptr : each.file, each.element},
                         reading);
  }
}

// Springs of the file, named after the mechanism; `first`: the number of its first body.
void add_springs(const Import& import, const ModelChoice& choice, const std::string& mechanism, int first, Reading& reading) {
  for (const ImportedSpring& each : import.model.springs) {
    Spring spring = each.spring;
    spring.name = mechanism + "/" + spring.name;
    while (reading.joints.contains(spring.name) || reading.springs.contains(spring.name)) spring.name += "~spring";
    for (SpringEnd* end : {&spring.from, &spring.to})
      if (end->body == ground)
        end->point = choice.pose * end->point;
      else
        end->body.index += first;
    reading.springs.emplace(spring.name, choice.model_place);
    reading.scenario.model.add_spring(std::move(spring));
  }
}

}  // namespace

void read_model(const Value& file, const std::string& mechanism, const ModelChoice& choice, JointTables& joints,
                std::size_t errors, Reading& reading) {
  const bool fresh = reading.direct || !file.string() || !reading.model_named(*file.string());
  const Import* import = model_of(file, reading);
  if (!import || import->errors() > 0 || import->model.bodies.empty()) {
    reading.opaque.insert(mechanism);
    return;
  }
  if (reading.bodies_left < static_cast<int>(import->model.bodies.size())) {
    reading.out.error(choice.model_place, "a scenario has at most 1000000 bodies");
    reading.opaque.insert(mechanism);
    return;
  }
  reading.bodies_left -= static_cast<int>(import->model.bodies.size());
  const bool one_root = check_roots(*import, choice, reading);
  check_state(*import, choice.state, reading);
  if (fresh && !choice.mimic) warn_of_followers(*import);
  bool coupled = check_followers(*import, choice, reading);
  if (joints.any()) {
    std::vector<std::pair<std::string, Kind>> names;
    std::unordered_map<std::string, std::string> of_bodies;
    for (const ImportedBody& body : import->model.bodies) {
      BodySpec held;
      held.joint.kind = body.spec.joint.kind;
      if (body.spec.parent == ground) hold(held, body, choice);
      names.emplace_back(body.spec.joint_name, held.joint.kind);
      if (body.spec.name != body.spec.joint_name) of_bodies.emplace(body.spec.name, body.spec.joint_name);
    }
    for (const ImportedLoop& loop : import->model.loops) names.emplace_back(loop.spec.name, loop.spec.joint.kind);
    joints.read(names, of_bodies);
  }

  const int first = reading.scenario.model.size();
  reading.scenario.model.reserve(first + static_cast<int>(import->model.bodies.size()));
  std::deque<BodySpec> specs;  // a deque, since the elements are large and should not be moved
  std::ptrdiff_t limited = 0;
  for (const ImportedBody& body : import->model.bodies) {
    BodySpec& spec = specs.emplace_back(body.spec);
    if (spec.parent == ground) {
      hold(spec, body, choice);
      if (one_root && choice.state.velocity) read_root_velocity(*choice.state.velocity, spec, reading.out);
    }
    joints.apply(spec.joint_name, spec);
    limited += body.limits.any() && !spec.joint.parameters.limits.any();
    if (const auto state = choice.state.joints.find(spec.joint_name); state != choice.state.joints.end()) {
      check_start(joints, state->first, *state->second, reading.out);
      read_joint_state(*state->second, state->first, spec, reading.out);
    }
    joints.check(spec.joint_name, spec);
  }
  for (const ImportedLoop& loop : import->model.loops) limited += loop.limits.any();
  warn_of_limits(limited, mechanism, choice, reading);
  coupled = coupled && check_motions(*import, choice, specs, reading);
  take_limits_of(*import, choice, joints, specs, reading);
  if (coupled) start_followers(*import, choice, joints, specs);
  for (const ImportedBody& body : import->model.bodies) {
    BodySpec spec = std::move(specs.front());
    specs.pop_front();
    check_within_limits(spec, body.limits, choice, reading);
    spec.name = mechanism + "/" + spec.name;
    spec.joint_name = mechanism + "/" + spec.joint_name;
    if (spec.parent != ground) spec.parent.index += first;
    reading.bodies.emplace(spec.name, choice.model_place);
    reading.joints.emplace(spec.joint_name, choice.model_place);
    if (spec.joint_name != spec.name) reading.body_of_joint.emplace(spec.joint_name, spec.name);
    if (errors != reading.out.errors()) continue;
    reading.from_model.emplace(spec.joint_name, body.spots);
    reading.scenario.model.add_unjudged(std::move(spec));
    auto& shapes = reading.scenario.shapes;
    shapes.resize(static_cast<std::size_t>(reading.scenario.model.size()));
    const std::vector<Shape>& given = body.shapes;
    if (given.empty()) continue;
    shapes.back() = given.front();
    shapes.back().more.assign(given.begin() + 1, given.end());
  }
  const auto& bodies = import->model.bodies;
  const auto collides = [](const ImportedSolids& part) { return !part.collision.empty(); };
  const auto has_plane = [](const ImportedSolids& part) {
    return std::any_of(part.collision.begin(), part.collision.end(), [](const Shape& shape) { return is_of_ground(shape.kind); });
  };
  const bool has_ground = collides(import->model.ground) || std::any_of(bodies.begin(), bodies.end(), has_plane);
  if ((has_ground || std::any_of(bodies.begin(), bodies.end(), collides)) && choice.collision.value_or(true) &&
      errors == reading.out.errors())
    for (const auto& [name, kept] : reading.models)
      if (kept.get() == import)
        reading.model_colliders.push_back(
            {kept, mechanism, first, choice.pose, choice.model_place, has_ground || choice.collision.has_value(), choice.split});
  read_model_loops(*import, mechanism, choice, joints, first, errors, reading);
  if (coupled && errors == reading.out.errors()) couple_followers(*import, choice, first, reading);
  if (errors == reading.out.errors()) add_springs(*import, choice, mechanism, first, reading);
  if (errors != reading.out.errors()) reading.opaque.insert(mechanism);  // its springs are missing, at least
}

bool take_limits(const JointLimits& limits, const ModelChoice& choice, const std::string& joint, JointParameters& parameters,
                 Reading& reading) {
  if (!choice.limits.value_or(false) || !limits.any() || parameters.limits.any()) return false;
  if (parameters.drive && parameters.drive->moves()) {
    reading.out.note(choice.limits_place,
                     "limits: joint " + in_quotes(joint) + " does not use those of the model: its motion is prescribed");
    return false;
  }
  parameters.limits = limits;
  return true;
}

}  // namespace momentree::io
