#include <algorithm>

#include <momentree/base/error.hpp>
#include <momentree/models/import/massless.hpp>
#include <momentree/scenario/keys/joint_tables.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

using namespace type;

constexpr Key velocity_entries[] = {
    {"linear", vector(dimension::speed), "Velocity of the origin of its frame", "[0, 0, 0]"},
    {"angular", vector(dimension::angular_speed), "Angular velocity", "[0, 0, 0]"},
};
constexpr KeyTable velocity_table{"velocity", "", "Velocity of a free root body, in its own axes", velocity_entries};

constexpr Key state_entries[] = {
    {"joints",
     other(R"({"type": "object", "additionalProperties": {"anyOf": [{"type": ["number", "string"]},
      {"type": "array", "items": {"type": ["number", "string"]}}, @]}})",
           joint_start_table),
     "By the names of the joints: a number, a list of coordinates, or a table"},
    {"velocity", table(velocity_table), ""},
};
constexpr KeyTable state_table{"state", "", "Initial values", state_entries};

constexpr Key mechanism_entries[] = {
    {"name", string, "Prefix of the names of its bodies and joints", nullptr, "for example name = \"arm\""},
    {"root", choice("fixed|free"), "How to hold a root body that has no joint", R"("fixed")"},
    {"pose", table(placement_table), "Placement of the mechanism's frame in the world"},
    {"roots", other(R"({"type": "integer", "minimum": 1, "maximum": 1000000})"), "Number of bodies that are joined to the ground",
     "1"},
    {"chain", table(chain_table), ""},
    {"body", tables(body_table), "The bodies"},
    {"state", other(R"({"anyOf": [{"type": "string"}, @]})", state_table), "Initial values, or the name of a state document"},
    {"model", string, "Model file, relative to the scenario"},
    {"joint", other(R"({"type": "object", "additionalProperties": @})", joint_override_table),
     "For joints of a model or a chain, by their names; a * matches all joints that support the key"},
    {"limits", boolean, "Whether the limits of the model file are stops", "false"},
    {"collision", choice("file|none"),
     "Whether the collision elements of the model file touch other bodies; default: if there is a floor, "
     "a [[contact]], a body with a collision, or a plane or solid that the file has in the world"},
    {"split", other(R"({"anyOf": [{"type": "number", "minimum": 0.01, "maximum": 1}, {"const": false}]})"),
     "Closed meshes among these elements are split into convex parts of this concavity; false: none; default: as the file says"},
    {"mimic", other(R"({"anyOf": [{"const": "exact"}, {"const": "independent"}, @]})", mimic_table),
     "How joints that follow others according to the model file do so: exactly, not at all, or by a spring"},
};

MechanismState read_state(const Value& value, const std::string& mechanism, Reading& reading) {
  MechanismState state;
  Diagnostics& out = reading.out;
  if (const std::string* file = value.string()) {
    if (file->empty()) out.error(value.place, "state: expected the name of a file");
    reading.scenario.state_files.push_back(
        {reading.folder.empty() || file->front() == '/' ? *file : reading.folder + "/" + *file, mechanism, value.place});
    return state;
  }
  if (!value.table()) {
    out.error(value.place, std::string("state: expected a table or the name of a file, found ") + value.type_name());
    return state;
  }
  Fields fields(value, state_table, out);
  if (const Value* joints = fields.find("joints")) {
    if (!joints->table())
      out.error(joints->place, std::string("state.joints: expected a table, found ") + joints->type_name(),
                "write joints = { elbow = \"20 deg\" }: names and values");
    else
      for (const Value::Entry& entry : *joints->table()) state.joints.emplace(entry.key, &entry.value);
  }
  state.velocity = fields.find("velocity");
  fields.finish();
  return state;
}

Held read_root(Fields& fields, Diagnostics& out) {
  const auto text = fields.string("root");
  if (!text) return Held::unsaid;
  if (*text == "fixed") return Held::fixed;
  if (*text == "free") return Held::free;
  const std::string cure = cure_of_root(*text);
  out.error(fields.place_of("root"), "root: expected \"fixed\" or \"free\", found " + in_quotes(*text),
            cure.empty() ? did_you_mean(*text, {"fixed", "free"}) : cure);
  return Held::unsaid;
}

// The number of bodies of a mechanism that are joined to the ground.
std::size_t read_roots(Fields& fields, Diagnostics& out) {
  const Value* roots = fields.find("roots");
  if (!roots) return 1;
  const auto count = read_whole(*roots, "roots", 1, 1'000'000, out);
  if (count && !fields.has("body"))
    out.error(roots->place, "roots: this key is for a mechanism with [[mechanism.body]] tables", "");
  return static_cast<std::size_t>(count.value_or(1));
}

// Sets the joint of a root body to the ground.
void hold_root(BodyEntry& root, Held held, const std::optional<Pose>& given_pose, Place root_place, Diagnostics& out) {
  const Pose pose = given_pose.value_or(Pose{});
  BodySpec& spec = root.spec;
  if (root.joint) {
    if (held != Held::unsaid)
      out.error(root_place, "root: body " + in_quotes(root.bare_name) + " has its own joint to the ground",
                "leave out 'root', or that joint");
    if (given_pose) spec.at = pose * spec.at;
  } else if (held == Held::free) {
    const Quat& r = pose.rotation;
    spec.joint.kind = Kind::free;
    spec.q = {pose.position.x, pose.position.y, pose.position.z, r.w, r.x, r.y, r.z};
  } else {
    spec.at = pose;
  }
}

// The place in the file of a problem that check_body() found.
Place place_of(const BodyEntry& body, const std::string& field) {
  for (const Value* table : {body.table, body.joint}) {
    if (!table) continue;
    for (const char* key :
         {field.c_str(), field == "q" ? "angle" : "", field == "q" ? "position" : "", field == "v" ? "speed" : ""})
      if (const Value::Entry* entry = table->find(key)) return entry->value.place;
  }
  return body.name_place;
}

void apply_state(std::vector<BodyEntry>& bodies, const std::vector<std::size_t>& order, const MechanismState& state,
                 Reading& reading) {
  Diagnostics& out = reading.out;
  if (state.velocity && std::count_if(bodies.begin(), bodies.end(), [](const BodyEntry& body) { return body.rooted; }) > 1)
    out.error(state.velocity->place, "velocity: this mechanism has several roots, and one velocity is ambiguous",
              "give v for their joints");
  else if (state.velocity)
    read_root_velocity(*state.velocity, bodies[order.front()].spec, out);
  if (state.joints.empty()) return;
  std::unordered_map<std::string, Place> known;
  for (BodyEntry& body : bodies) {
    known.emplace(body.bare_joint, body.name_place);
    const auto found = state.joints.find(body.bare_joint);
    if (found != state.joints.end()) read_joint_state(*found->second, found->first, body.spec, out);
  }
  for (const auto& [name, value] : state.joints)
    if (!known.contains(name))
      out.error(value->place, "state: there is no joint " + in_quotes(name) + " in this mechanism", reading.suggest(name, known));
}

void check_bodies(const std::vector<BodyEntry>& bodies, Diagnostics& out) {
  for (const BodyEntry& body : bodies) {
    // the name is missing or invalid: reported already, and check_body() would report it again
    if (body.spec.name.empty()) continue;
    for (const BodyProblem& problem : check_body(body.spec))
      out.error(place_of(body, problem.field), problem.field + ": " + problem.what, problem.hint);
  }
}

// If the tree is unknown, so are the rigid groups: bodies that may belong to one are not checked.
void check_single_inertias(const std::vector<BodyEntry>& bodies, Diagnostics& out) {
  std::unordered_set<std::string_view> carriers;
  for (const BodyEntry& body : bodies)
    if (body.joint && body.spec.joint.kind == Kind::weld)
      carriers.insert(std::string_view(body.parent).substr(body.parent.rfind('/') + 1));
  for (const BodyEntry& body : bodies) {
    if (body.spec.joint.kind == Kind::weld || carriers.contains(body.bare_name)) continue;
    for (const auto& [index, problem] : check_masses({&body.spec, 1}))
      if (!problem.warning) out.error(place_of(body, "inertia"), problem.what, problem.hint);
  }
}

// Checks inertias; adds the bodies to the model if the mechanism has no errors.
void add_bodies(std::vector<BodyEntry>& bodies, const std::vector<std::size_t>& order, std::size_t errors, Reading& reading) {
  Diagnostics& out = reading.out;
  const int first = reading.scenario.model.size();
  std::vector<int> number(bodies.size(), -1);
  std::unordered_map<std::string_view, int> by_name;
  std::vector<BodySpec> specs;
  specs.reserve(order.size());
  for (const std::size_t b : order) {
    BodyEntry& body = bodies[b];
    if (!body.rooted) {
      const std::size_t slash = body.parent.rfind('/');
      body.spec.parent = {by_name.at(std::string_view(body.parent).substr(slash == std::string::npos ? 0 : slash + 1))};
    }
    by_name.emplace(body.bare_name, static_cast<int>(specs.size()));
    specs.push_back(std::move(body.spec));
  }
  for (const auto& [body, problem] : check_masses(specs)) {
    const Place place = place_of(bodies[order[static_cast<std::size_t>(body.index)]], "inertia");
    if (problem.warning)
      out.warning(place, problem.what, problem.hint);
    else
      out.error(place, problem.what, problem.hint);
  }
  if (errors != out.errors()) return;
  std::vector<const BodySpec*> each;
  each.reserve(specs.size());
  for (const BodySpec& spec : specs) each.push_back(&spec);
  for (const int b : massless_links(each))
    out.warning(place_of(bodies[order[static_cast<std::size_t>(b)]], "mass"),
                massless_link(specs[static_cast<std::size_t>(b)].name), massless_hint);
  reading.scenario.model.reserve(first + static_cast<int>(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    BodySpec& spec = specs[i];
    if (spec.parent != ground) spec.parent.index += first;
    const BodyId added = reading.scenario.model.add_unjudged(std::move(spec));
    add_colliders(added, bodies[order[i]].collision, reading.scenario.model);
    note_collision_shapes(reading.scenario.model, std::move(bodies[order[i]].collision_shapes),
                          reading.scenario.collision_shapes);
    reading.scenario.shapes.resize(static_cast<std::size_t>(reading.scenario.model.size()));
    reading.scenario.shapes.back() = std::move(bodies[order[i]].shape);
  }
}

void read_bodies(const Value& list, const std::string& mechanism, Held held, const std::optional<Pose>& pose, Place root_place,
                 Place place, const MechanismState& state, std::size_t roots, std::size_t errors, Reading& reading) {
  std::vector<BodyEntry> bodies;
  for (const Value* table : tables_of(list, "mechanism.body", reading.out)) {
    if (reading.bodies_left-- <= 0) {
      reading.out.error(table->place, "a scenario has at most 1000000 bodies");
      return;
    }
    bodies.push_back(read_body(*table, mechanism, reading));
    if (reading.out.full()) return;
  }
  if (bodies.empty()) return;
  for (BodyEntry& body : bodies)
    if (body.rooted) hold_root(body, held, pose, root_place, reading.out);
  const std::vector<std::size_t> order = order_of(bodies, mechanism, place, roots, reading);
  // If names are missing or duplicate, parents are ambiguous, and further messages would be guesses.
  const bool named = std::all_of(bodies.begin(), bodies.end(), [](const BodyEntry& body) { return body.named; });
  if (!order.empty() && named) apply_state(bodies, order, state, reading);
  check_bodies(bodies, reading.out);
  if (order.empty() || !named) return check_single_inertias(bodies, reading.out);
  add_bodies(bodies, order, errors, reading);
}

}  // namespace

constinit const KeyTable mechanism_table{"[[mechanism]]",
                                         "mechanism",
                                         "A tree of bodies: a model, a chain, or a list of bodies",
                                         mechanism_entries,
                                         {{KeyRule::How::one, "model chain body"}}};

void read_root_velocity(const Value& value, BodySpec& root, Diagnostics& out) {
  Fields fields(value, velocity_table, out);
  const Vec3 linear = fields.vec3("linear").value_or(Vec3{});
  const Vec3 angular = fields.vec3("angular").value_or(Vec3{});
  fields.finish();
  if (root.joint.kind != Kind::free) {
    out.error(value.place, "velocity: the root body is not free: its joint gives its velocity",
              "write root = \"free\", or the joint's start 'v'");
    return;
  }
  // From the body's frame to the joint's frame, which is at child_at in it.
  const Quat to_joint = conjugate(root.child_at.rotation);
  const Vec3 v = rotation_matrix(to_joint) * (linear + cross(angular, root.child_at.position)),
             w = rotation_matrix(to_joint) * angular;
  root.v = {v.x, v.y, v.z, w.x, w.y, w.z};
}

void read_mechanism(const Value& table, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  Fields fields(table, mechanism_table, out);
  fields.require("name");
  std::string name = fields.string("name").value_or("");
  if (fields.has("name") && table.find("name")->value.string() &&
      check_bare_name(name, fields.place_of("name"), "a mechanism", out))
    reading.note(reading.mechanisms, name, fields.place_of("name"), "mechanism");

  const Held held = read_root(fields, out);
  const std::optional<Pose> given_pose = fields.pose("pose");
  const Pose pose = given_pose.value_or(Pose{});
  const std::size_t roots = read_roots(fields, out);
  MechanismState state;
  const Value* chain = fields.find("chain");
  const Value* bodies = fields.find("body");
  const Value* given_state = fields.find("state");
  const Value* model = fields.find("model");
  const Value* joints = fields.find("joint");
  const auto limits = fields.boolean("limits",
                                     "true or false: whether the model's limits are used; give other limits to the joints: "
                                     "[mechanism.joint.elbow] with limits = { lower = …, upper = … }");
  std::optional<bool> collision;
  if (const auto word = fields.string("collision")) {
    if (*word != "file" && *word != "none")
      out.error(fields.place_of("collision"), "collision: expected \"file\" or \"none\", found " + in_quotes(*word),
                did_you_mean(*word, {"file", "none"}));
    collision = *word == "file";
    if (!model)
      out.warning(fields.place_of("collision"), "collision: only a model file has collision elements",
                  "give the bodies their collision, or the chain a radius");
  }
  std::optional<double> split;
  if (const Value* value = fields.find("split")) {
    split = value->boolean() && !*value->boolean() ? 0 : read_split(*value, out);
    if (!model)
      out.error(value->place, "split: only a model file has collision elements", "give it to the mesh of a body's collision");
  }
  std::optional<Mimic> mimic;
  if (const Value* spring = fields.find("mimic")) {
    if (const std::string* word = spring->string()) {
      if (*word != "exact" && *word != "independent")
        out.error(spring->place, "mimic: expected \"exact\", \"independent\" or a table of a spring, found " + in_quotes(*word),
                  "mimic = \"exact\"");
      mimic = Mimic{*word == "independent" ? Mimic::How::independent : Mimic::How::exact, {}};
    } else {
      Fields parts(*spring, mimic_table, out);
      mimic = Mimic{};
      read_coupling_spring(parts, false, mimic->spring);
      parts.finish();
    }
    if (!model)
      out.error(spring->place, "mimic: only a model has joints that follow others", "couple them with [[coupling]] tables");
  }
  if (given_state) state = read_state(*given_state, name, reading);
  const int ways = (chain ? 1 : 0) + (bodies ? 1 : 0) + (model ? 1 : 0);
  if (ways > 1) {
    const Value* second = bodies ? bodies : model;
    out.error(
        second->place,
        model ? "a mechanism is a model, a chain or bodies, and only one of them" : "a mechanism is a chain or bodies, not both",
        !model ? "give the chain its own [[mechanism]]"
        : bodies && second->place.option > 0
            ? "the bodies of a model file cannot be changed; `momentree convert` writes a scenario in which they can"
            : "give each its own [[mechanism]]");
  }
  if (ways == 0)
    out.error(fields.place(), "mechanism " + in_quotes(name) + " has no bodies",
              "add [[mechanism.body]] tables, a [mechanism.chain] or a model = \"robot.urdf\"");
  if (fields.has("limits") && !model)
    out.error(fields.place_of("limits"), "limits: only a model file has limits to be used or not",
              "give the joints their limits");
  if (chain && held == Held::fixed)
    out.error(fields.place_of("root"), "root: a chain is joined to the ground by a revolute joint",
              "leave out 'root'; \"free\" removes that joint");
  if (joints && !model && !chain && bodies)
    out.error(fields.place_of("joint"), "joint: a mechanism of bodies has its joints in the tables of the bodies",
              "write it in [mechanism.body.joint], which --set reaches by mechanism." + name + ".body.BODY.joint.damping=0.1");
  JointTables tables(model || chain ? joints : nullptr, model ? "model" : "chain", reading);
  if (model)
    read_model(*model, name,
               {held, pose, state, limits, mimic, collision, split, model->place, fields.place_of("root"),
                fields.place_of("limits"), fields.place_of("mimic")},
               tables, errors, reading);
  else if (chain)
    read_chain(*chain, name, held == Held::free, pose, state, tables, errors, reading);
  else if (bodies)
    read_bodies(*bodies, name, held, given_pose, fields.place_of("root"), fields.place(), state, roots, errors, reading);
  fields.finish();
}

}  // namespace momentree::io
