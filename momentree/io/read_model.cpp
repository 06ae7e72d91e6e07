// A mechanism that a model file describes: where it stands, how it is held and starts, what of the file is taken up.
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <momentree/base/error.hpp>
#include <momentree/io/scenario_parts.hpp>

namespace momentree::io {

namespace {

namespace fs = std::filesystem;

// The model of a file, read once; null, with a report, where there is none.
const Import* model_of(const Value& file, Reading& reading) {
  const auto name = read_string(file, "model", reading.out);
  if (!name) return nullptr;
  if (name->empty()) {
    reading.out.error(file.place, "model: expected the name of a file", "a .urdf, relative to the scenario");
    return nullptr;
  }
  if (const Import* known = reading.model_named(*name)) return known;
  if (!reading.looks_at_files) {
    reading.out.error(file.place, "model: a scenario that is read from a text names no files", "read it from its file");
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

// Stops of the file.
void take_limits(const ImportedBody& body, const ModelChoice& choice, BodySpec& spec, Reading& reading) {
  if (!body.limits.any() || !choice.limits.value_or(false)) return;
  spec.joint.parameters.limits = body.limits;
  for (int i = 0; i < std::max(body.limits.lower.size(), body.limits.upper.size()); ++i) {
    const double q = i < spec.q.size() ? spec.q[i] : 0;
    const double lower = body.limits.lower_of(i), upper = body.limits.upper_of(i);
    if (q >= lower && q <= upper) continue;
    char text[120];
    std::snprintf(text, sizeof text, " starts at %.6g, beyond its limits of %.6g and %.6g", q, lower, upper);
    reading.out.error(choice.limits_place, "limits: joint " + in_quotes(body.spec.joint_name) + text,
                      "give it a start in state = { joints = { … } }");
  }
}

void warn_of_limits(const Import& import, const ModelChoice& choice, Reading& reading) {
  const auto& bodies = import.model.bodies;
  const auto limited = std::count_if(bodies.begin(), bodies.end(), [](const ImportedBody& body) { return body.limits.any(); });
  if (limited > 0 && !choice.limits)
    reading.out.warning(choice.model_place,
                        "the limits of " + std::to_string(limited) + (limited == 1 ? " joint" : " joints") + " are not taken up",
                        "write limits = true or limits = false");
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

// What `root` and a velocity mean; false where it is not clear whose velocity it is.
bool check_roots(const Import& import, const ModelChoice& choice, Reading& reading) {
  std::size_t roots = 0;
  bool taken = false;
  for (const ImportedBody& body : import.model.bodies) {
    if (body.spec.parent != ground) continue;
    ++roots;
    taken = taken || !body.own_joint;
  }
  if (choice.held != Held::unsaid && !taken)
    reading.out.error(choice.root_place, "root: every root of this model has a joint of its own to the ground",
                      "leave 'root' out");
  if (choice.state.velocity && roots > 1)
    reading.out.error(choice.state.velocity->place,
                      "velocity: this model has " + std::to_string(roots) + " roots, and one velocity could be any of theirs",
                      "give v of their joints in state.joints");
  return roots == 1;
}

void check_state(const Import& import, const MechanismState& state, Reading& reading) {
  if (state.joints.empty()) return;
  std::unordered_map<std::string, Place> known;
  for (const ImportedBody& body : import.model.bodies) known.emplace(body.spec.joint_name, Place{});
  for (const auto& [name, value] : state.joints)
    if (!known.contains(name))
      reading.out.error(value->place, "state: there is no joint " + in_quotes(name) + " in this model",
                        reading.suggest(name, known));
}

void warn_of_followers(const Import& import) {
  for (const Follower& each : import.model.followers)
    each.file->warning(
        {each.element},
        "joint " + in_quotes(import.model.bodies[static_cast<std::size_t>(each.body)].spec.joint_name) + " should follow " +
            in_quotes(import.model.bodies[static_cast<std::size_t>(each.leader)].spec.joint_name) + ": it moves by itself here",
        "mimic = { stiffness = … } in the mechanism couples them by a spring");
}

// Where a joint starts, by the file, by the mechanism's state, or behind the joint that it follows.
double start_of(const Import& import, int body, const MechanismState& state, std::size_t depth = 0) {
  const auto& bodies = import.model.bodies;
  BodySpec spec = bodies[static_cast<std::size_t>(body)].spec;
  const auto given = state.joints.find(spec.joint_name);
  if (given != state.joints.end()) {
    Diagnostics said_elsewhere("", "");
    read_joint_state(*given->second, given->first, spec, said_elsewhere);
    return spec.q[0];
  }
  for (const Follower& each : import.model.followers)
    if (each.body == body && depth < import.model.followers.size())
      return each.multiplier * start_of(import, each.leader, state, depth + 1) + each.offset;
  return spec.q[0];
}

void couple_followers(const Import& import, const ModelChoice& choice, int first, Reading& reading) {
  const Model& model = reading.scenario.model;
  for (const Follower& each : import.model.followers) {
    const Body joint{first + each.body}, leader{first + each.leader};
    for (const Body end : {joint, leader})
      if (info(model[end].joint.kind).nv != 1)
        reading.out.error(choice.mimic_place, "mimic: joint " + in_quotes(model[end].joint_name) + " is not one of one freedom");
    if (info(model[joint].joint.kind).nv != 1 || info(model[leader].joint.kind).nv != 1) continue;
    add_coupling({joint, leader, each.multiplier, each.offset, choice.mimic->stiffness, choice.mimic->damping},
                 choice.mimic_place, reading);
  }
}

}  // namespace

void read_model(const Value& file, const std::string& mechanism, const ModelChoice& choice, std::size_t errors,
                Reading& reading) {
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
  warn_of_limits(*import, choice, reading);
  if (fresh && !choice.mimic) warn_of_followers(*import);
  std::unordered_map<const ImportedBody*, double> behind;  // starts of followers
  if (choice.mimic)
    for (const Follower& each : import->model.followers)
      behind.emplace(&import->model.bodies[static_cast<std::size_t>(each.body)], start_of(*import, each.body, choice.state));

  const int first = reading.scenario.model.size();
  for (const ImportedBody& body : import->model.bodies) {
    BodySpec spec = body.spec;
    if (spec.parent == ground) {
      hold(spec, body, choice);
      if (one_root && choice.state.velocity) read_root_velocity(*choice.state.velocity, spec, reading.out);
    }
    const auto state = choice.state.joints.find(spec.joint_name);
    if (state != choice.state.joints.end()) read_joint_state(*state->second, state->first, spec, reading.out);
    if (const auto start = behind.find(&body); start != behind.end()) spec.q = {start->second};
    take_limits(body, choice, spec, reading);
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
  if (choice.mimic && errors == reading.out.errors()) couple_followers(*import, choice, first, reading);
}

}  // namespace momentree::io
