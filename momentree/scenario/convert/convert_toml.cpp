#include <momentree/scenario/convert/convert.hpp>

#include <filesystem>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <unordered_set>

#include <momentree/base/check.hpp>
#include <momentree/base/error.hpp>
#include <momentree/scenario/convert/describe.hpp>
#include <momentree/scenario/convert/scenario_names.hpp>
#include <momentree/scenario/convert/toml_writer.hpp>
#include <momentree/scenario/keys/keys.hpp>

namespace momentree::io {

namespace {

using namespace document_values;
namespace fs = std::filesystem;

std::string mechanism_of(const Model& model, BodyId body) {
  const std::string& name = model[body].name;
  return name.substr(0, name.find('/'));
}

// Indices of bodies by the mechanism prefix of their names, in the order of the model.
std::unordered_map<std::string, std::vector<int>> by_mechanism(const Model& model) {
  std::unordered_map<std::string, std::vector<int>> all;
  for (int b = 0; b < model.size(); ++b) all[mechanism_of(model, {b})].push_back(b);
  return all;
}

bool is_zero(const Value* number) {
  return number && ((number->real() && *number->real() == 0) || (number->integer() && *number->integer() == 0));
}

const std::string* string_at(const Value& table, const char* key) {
  const Value::Entry* entry = table.find(key);
  return entry ? entry->value.string() : nullptr;
}

// Adds a comment to moving bodies without mass that carry one other body: they only connect two joints.
void explain_carriers(Value& mechanism) {
  Value::Entry* bodies = mechanism.find("body");
  if (!bodies || !bodies->value.array()) return;
  struct Carried {
    int count = 0;
    std::string name;
  };
  std::unordered_map<std::string, Carried> carried;
  for (const Value& body : *bodies->value.array()) {
    const Value::Entry* joint = body.find("joint");
    const std::string *name = string_at(body, "name"), *parent = joint ? string_at(joint->value, "parent") : nullptr;
    if (!name || !parent) continue;
    Carried& on = carried[parent->substr(parent->rfind('/') + 1)];
    ++on.count, on.name = *name;
  }
  for (Value& body : *bodies->value.array()) {
    const Value::Entry *mass = body.find("mass"), *joint = body.find("joint");
    const std::string* name = string_at(body, "name");
    if (!name || !mass || !is_zero(&mass->value) || !joint) continue;
    const std::string* kind = string_at(joint->value, "kind");
    const auto child = carried.find(*name);
    if (!kind || *kind == "weld" || child == carried.end() || child->second.count != 1) continue;
    const std::string what = "no mass: the joints of " + *name + " and " + child->second.name + " are in series";
    body.table()->insert(body.table()->begin(), {comment_key, {}, text(what)});
  }
}

class Converter {
 public:
  Converter(const Scenario& scenario, std::string folder, const MeshNames* meshes = nullptr)
      : scenario_(scenario), folder_(std::move(folder)), meshes_(meshes) {
    from_ = fs::path(scenario.path).parent_path().string();
    bodies_ = by_mechanism(scenario.model);
  }

  Converted convert() {
    Value::Table document;
    std::vector<const char*> keys{"format", "title", "state", "world", "mechanism", "force", "loop"};
    for (const ElementTable& element : element_tables()) keys.push_back(element.keys->definition);
    for (const char* key : {"contact", "event", "integrate", "output"}) keys.push_back(key);
    for (const char* const key : keys) {
      const Value::Entry* entry = scenario_.document->find(key);
      if (std::string_view(key) == "coupling" &&
          springs_of(entry) < describe_couplings(scenario_.model).size()) {  // one for each follower of a model file, too
        add(document, key, value(describe_couplings(scenario_.model)));
        continue;
      }
      if (std::string_view(key) == "loop") {
        if (Value all = loops(entry); !all.array()->empty()) add(document, key, std::move(all));
        continue;
      }
      if (std::string_view(key) == "spring" || std::string_view(key) == "cable") {
        if (Value all = springs(entry, std::string_view(key) == "cable"); !all.array()->empty())
          add(document, key, std::move(all));
        continue;
      }
      if (!entry) continue;
      Value value = entry->value;
      if (entry->key == "mechanism") value = mechanisms(value);
      if (entry->key == "world") move_collision(value);
      if (entry->key == "state" && value.string()) value = text(moved(*value.string()));
      if (entry->key == "title" && value.string() && value.string()->empty()) continue;
      if (value.table() && value.table()->empty()) continue;
      add(document, key, std::move(value));
    }
    left_out_.colliders += ground_of_files();
    if (!scenario_.document->find("format")) document.insert(document.begin(), {"format", {}, Value(std::int64_t{1}, Place{})});
    if (left_out_.meshes > 0)
      say(Severity::warning,
          counted(left_out_.meshes, "mesh is", "meshes are") + " left out: not found in the folder of the " +
              "output file or below it",
          "copy the files there; they do not affect the motion");
    if (left_out_.flat > 0)
      say(Severity::warning, counted(left_out_.flat, "shape", "shapes") + " without extent left out: they are for pictures only",
          "");
    if (left_out_.colliders > 0)
      say(Severity::warning, counted(left_out_.colliders, "collision element", "collision elements") + " of model files left out",
          "their bodies no longer touch anything: give them a collision");
    Converted result{toml_text(value(std::move(document))), std::move(diagnostics_)};
    check(result.text);
    return result;
  }

 private:
  static std::string counted(int n, const char* one, const char* many) { return std::to_string(n) + " " + (n == 1 ? one : many); }

  void say(Severity severity, std::string what, std::string hint) {
    diagnostics_.push_back({severity, scenario_.path, 0, 0, std::move(what), std::move(hint), ""});
  }

  // How many planes and solids model files have in the world.
  int ground_of_files() const {
    const std::vector<Collider>& all = scenario_.model.colliders();
    auto count = std::count_if(all.begin(), all.end(), [](const Collider& each) { return each.body == ground; });
    for (std::size_t i = 0; i < scenario_.collision_shapes.size(); ++i)
      if (all[i].body == ground && scenario_.collision_shapes[i].part) --count;
    const Value::Entry* const world = scenario_.document->find("world");
    if (const auto* floor = world ? world->value.find("floor") : nullptr;
        floor && (!floor->value.boolean() || *floor->value.boolean()))
      --count;
    if (const auto* own = world ? world->value.find("collision") : nullptr)
      count -= own->value.array() ? static_cast<std::ptrdiff_t>(own->value.array()->size()) : 1;
    return static_cast<int>(count);
  }

  // The path of a file that the scenario names, relative to the output's folder.
  std::string moved(const std::string& file) const {
    if (file.empty() || fs::path(file).is_absolute()) return file;
    std::error_code failed;
    const fs::path path = fs::proximate(fs::path(from_.empty() ? "." : from_) / file, folder_.empty() ? "." : folder_, failed);
    return failed ? file : path.generic_string();
  }

  Value mechanisms(const Value& list) {
    Value::Array all;
    for (const Value& mechanism : *list.array()) {
      Value one = string_at(mechanism, "model") ? value(expanded(mechanism)) : kept(mechanism);
      explain_carriers(one);
      all.push_back(std::move(one));
    }
    return value(std::move(all));
  }

  static std::size_t springs_of(const Value::Entry* entry) {
    return entry != nullptr && entry->value.array() ? entry->value.array()->size() : 0;
  }
  // The springs or cables of model files, which come first in the model, then the scenario's own.
  Value springs(const Value::Entry* entry, bool cables) const {
    const std::size_t own = springs_of(scenario_.document->find("spring")) + springs_of(scenario_.document->find("cable"));
    Value::Array all;
    for (std::size_t s = 0; s + own < scenario_.model.springs().size(); ++s)
      if (const Spring& spring = scenario_.model.springs()[s]; spring.inextensible == cables)
        all.push_back(value(describe_spring(spring, scenario_.model)));
    if (springs_of(entry) > 0) all.insert(all.end(), entry->value.array()->begin(), entry->value.array()->end());
    return value(std::move(all));
  }
  // The loop tables: one for each loop joint of a model file, and the scenario's own.
  Value loops(const Value::Entry* own) const {
    Value::Array all;
    std::unordered_set<std::string_view> given;
    if (own)
      for (const Value& loop : *own->value.array())
        if (const std::string* name = string_at(loop, "name")) given.insert(*name);
    for (const LoopSpec& loop : scenario_.model.loops())
      if (!given.contains(loop.name)) all.push_back(value(describe_loop(loop, scenario_.model)));
    if (own) all.insert(all.end(), own->value.array()->begin(), own->value.array()->end());
    return value(std::move(all));
  }

  // The mechanism of a model file: its bodies and joints, as this scenario attaches and initialises them.
  Value::Table expanded(const Value& mechanism) {
    const std::string& name = *string_at(mechanism, "name");
    const std::string* state = string_at(mechanism, "state");
    const fs::path model = fs::path(from_.empty() ? "." : from_) / *string_at(mechanism, "model");
    for (const Collider& collider : scenario_.model.colliders())
      if (collider.body != ground && mechanism_of(scenario_.model, collider.body) == name) ++left_out_.colliders;
    const MeshFolders folders{model.parent_path().string(), folder_.empty() ? "." : folder_, meshes_};
    return describe_mechanism(name, scenario_.model, bodies_.at(name), scenario_.shapes, folders, state ? moved(*state) : "",
                              left_out_);
  }

  // The mechanism as written in the scenario, with the paths of files adjusted.
  Value kept(Value mechanism) {
    if (Value::Entry* state = mechanism.find("state"); state && state->value.string())
      state->value = text(moved(*state->value.string()));
    if (Value::Entry* chain = mechanism.find("chain")) move_shapes(chain->value);
    Value::Entry* bodies = mechanism.find("body");
    if (!bodies || !bodies->value.array()) return mechanism;
    for (Value& body : *bodies->value.array()) {
      move_collision(body);
      move_shapes(body);
    }
    return mechanism;
  }

  // The shapes that a body or the links of a chain are drawn with, without meshes that the output may not name.
  void move_shapes(Value& body) {
    Value::Entry* shape = body.find("shape");
    if (!shape) return;
    Value::Array* several = shape->value.array();
    if (several) std::erase_if(*several, [this](Value& each) { return !move_mesh(each); });
    if (several ? several->empty() : !move_mesh(shape->value))
      std::erase_if(*body.table(), [](const Value::Entry& entry) { return entry.key == "shape"; });
  }

  // Throws Error for meshes that the output may not name: without them the motion would differ.
  void move_collision(Value& body) {
    Value::Entry* collision = body.find("collision");
    if (!collision) return;
    const bool drawn = collision->value.string() && *collision->value.string() == "shape";
    const Value::Entry* shape = body.find("shape");
    if (drawn && !shape) return;
    Value copy = drawn ? shape->value : Value{};
    Value& all = drawn ? copy : collision->value;
    const auto move = [&](Value& each) {
      const std::string* mesh = string_at(each, "mesh");
      if (!mesh) return;
      touches_with_meshes_ = true;
      const std::string name = *mesh;
      if (!move_mesh(each))
        throw_error({"cannot be written as TOML there: a body touches others with the mesh '" + name +
                         "', which is not in the folder of the output file or below it",
                     scenario_.path, "write it in the folder of the mesh, or above it"});
    };
    if (Value::Array* several = all.array())
      for (Value& each : *several) move(each);
    else
      move(all);
  }

  // False if the mesh is not among the files that the output may name.
  bool move_mesh(Value& shape) {
    Value::Entry* mesh = shape.find("mesh");
    if (!mesh || !mesh->value.string() || meshes_) return true;
    const std::string path = mesh_path(*mesh->value.string(), {from_.empty() ? "." : from_, folder_.empty() ? "." : folder_});
    if (!path.empty()) {
      mesh->value = text(path);
      return true;
    }
    ++left_out_.meshes;
    return false;
  }

  // A valid scenario must be read back without errors. Only meshes that bodies touch with need the files that the text names.
  void check(const std::string& text) const {
    const ReadResult again = touches_with_meshes_ && !meshes_
                                 ? read_scenario_from(text, (fs::path(folder_) / "written.toml").string(), "written", folder_)
                                 : read_scenario_text(text, scenario_.path + " as TOML");
    if (again.scenario) return;
    for (const Diagnostic& each : again.diagnostics)
      if (each.severity == Severity::error) throw_error({"cannot be written as TOML: " + each.what, scenario_.path, each.hint});
  }

  const Scenario& scenario_;
  std::string folder_, from_;
  const MeshNames* meshes_;
  std::unordered_map<std::string, std::vector<int>> bodies_;
  LeftOut left_out_;
  bool touches_with_meshes_ = false;
  std::vector<Diagnostic> diagnostics_;
};

}  // namespace

namespace {

// `bodies`: of the mechanism, in the order of its tables.
void add_collisions(const Model& model, const std::vector<int>& bodies, const std::vector<Shape>& shapes, Value& described) {
  Value::Array& tables = *described.find("body")->value.array();
  for (std::size_t i = 0; i < tables.size(); ++i) {
    Value all = describe_collision(model, {bodies[i]}, shapes);
    Value::Table& body = *tables[i].table();
    if (!all.array()->empty()) body.insert(body.end() - 1, {"collision", {}, std::move(all)});
    if (Value::Table belt = describe_belt(model, {bodies[i]}); !belt.empty())
      body.insert(body.end() - 1, {"belt", {}, value(std::move(belt))});
  }
}

}  // namespace

Converted to_toml(const Scenario& scenario, const std::string& folder) {
  MT_REQUIRE(scenario.document != nullptr, "a scenario that was read");
  return Converter(scenario, folder).convert();
}

Converted to_toml(const Scenario& scenario, const MeshNames& meshes) {
  MT_REQUIRE(scenario.document != nullptr, "a scenario that was read");
  return Converter(scenario, "", &meshes).convert();
}

std::string to_toml(const Model& given, const std::vector<Shape>& shapes, bool contact,
                    const std::vector<Shape>& collision_shapes) {
  const Model model = with_scenario_names(given);
  Value::Table document, world;
  add(document, "format", Value(std::int64_t{1}, Place{}));
  const Vec3 g = model.gravity(), usual = Model().gravity();
  if (g.x != usual.x || g.y != usual.y || g.z != usual.z) add(world, "gravity", list(g));
  contact = contact && !model.colliders().empty();
  if (Value::Table floor = contact ? describe_floor(model) : Value::Table{}; !floor.empty())
    add(world, "floor", value(std::move(floor)));
  if (Value solids = contact ? describe_collision(model, ground, collision_shapes) : Value{}; contact && !solids.array()->empty())
    add(world, "collision", std::move(solids));
  if (!world.empty()) add(document, "world", value(std::move(world)));
  LeftOut left_out;
  Value::Array mechanisms, forces, loops, springs, cables, couplings = describe_couplings(model);
  const auto bodies = by_mechanism(model);
  for (int b = 0; b < model.size(); ++b) {
    const std::string mechanism = mechanism_of(model, {b});
    if (bodies.at(mechanism).front() != b) continue;
    mechanisms.push_back(value(describe_mechanism(mechanism, model, bodies.at(mechanism), shapes, {}, "", left_out)));
    explain_carriers(mechanisms.back());
    if (contact) add_collisions(model, bodies.at(mechanism), collision_shapes, mechanisms.back());
  }
  for (const BodyForce& force : model.forces()) forces.push_back(value(describe_force(force, model)));
  for (const LoopSpec& loop : model.loops()) loops.push_back(value(describe_loop(loop, model)));
  for (const Spring& spring : model.springs())
    (spring.inextensible ? cables : springs).push_back(value(describe_spring(spring, model)));
  add(document, "mechanism", value(std::move(mechanisms)));
  if (!forces.empty()) add(document, "force", value(std::move(forces)));
  if (!loops.empty()) add(document, "loop", value(std::move(loops)));
  if (!springs.empty()) add(document, "spring", value(std::move(springs)));
  if (!cables.empty()) add(document, "cable", value(std::move(cables)));
  for (auto& [key, tables] : describe_elements(model)) add(document, key, value(std::move(tables)));
  if (!couplings.empty()) add(document, "coupling", value(std::move(couplings)));
  if (Value all = contact ? describe_contacts(model) : value(Value::Array{}); !all.array()->empty())
    add(document, "contact", std::move(all));
  return toml_text(value(std::move(document)));
}

}  // namespace momentree::io
