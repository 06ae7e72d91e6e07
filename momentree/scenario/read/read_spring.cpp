// [[spring]] and [[cable]]: springs and cables between two points of bodies.
#include <momentree/base/characters.hpp>
#include <momentree/scenario/keys/described.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

namespace {

// Names may have one '/', so that springs of a model file carry the name of their mechanism.
bool check_spring_name(const std::string& name, Place place, Diagnostics& out) {
  const std::size_t slash = name.find('/');
  if (slash == std::string::npos) return check_bare_name(name, place, "a spring", out);
  return check_bare_name(name.substr(0, slash), place, "a spring", out) &&
         check_bare_name(name.substr(slash + 1), place, "a spring", out);
}

std::string read_name(Fields& fields, const char* what, Reading& reading) {
  Diagnostics& out = reading.out;
  fields.require("name");
  const auto name = fields.string("name");
  if (!name || !check_spring_name(*name, fields.place_of("name"), out)) return {};
  reading.note(reading.springs, *name, fields.place_of("name"), what);
  if (const auto joint = reading.joints.find(*name); joint != reading.joints.end())
    out.error(fields.place_of("name"),
              "name: there is a joint " + in_quotes(*name) + " already, on " + out.name_of(joint->second),
              "events refer to springs, cables and joints by their names: give the " + std::string(what) + " another one");
  return *name;
}

// The body's name; nothing, with a report, if there is none.
std::optional<std::string> body_of_end(const std::string& name, Place place, const char* key, Reading& reading) {
  if (name == "ground" || reading.bodies.contains(name) || reading.opaque.contains(mechanism_of(name))) return name;
  std::string hint;
  if (means_ground(name)) hint = "the ground is \"ground\"";
  if (hint.empty() && reading.joints.contains(name)) hint = "that is the name of a joint";
  if (hint.empty() && name.find('*') != std::string::npos) hint = "it has two ends: name one body";
  if (hint.empty() && name.find('/') == std::string::npos)
    for (const auto& [mechanism, where] : reading.mechanisms)
      if (reading.bodies.contains(mechanism + "/" + name)) hint = "use the full name: " + in_quotes(mechanism + "/" + name);
  if (hint.empty()) hint = reading.suggest(name, reading.bodies);
  reading.out.error(place, std::string(key) + ": there is no body " + in_quotes(name), std::move(hint));
  return std::nullopt;
}

class SpringReader : public FieldReader {
 public:
  SpringReader(Fields& fields, const char* what, Reading& reading) : FieldReader(fields), what_(what), reading_(reading) {}
  using FieldReader::operator();
  void operator()(const char*, std::string& name, const Field&) { name = read_name(fields_, what_, reading_); }
  void operator()(const char* key, SpringEnd& end, const Field&) {
    if (const std::optional<SpringEnd> given = read_end(key)) end = *given;
  }
  /// False if an end is missing, wrong, or of a mechanism with errors.
  bool complete() const { return ends_ == 2; }

 private:
  std::optional<SpringEnd> read_end(const char* key) {
    const Value* value = fields_.require(key);
    if (!value) return std::nullopt;
    SpringEnd end;
    std::optional<std::string> name;
    Place place = value->place;
    const std::size_t errors = reading_.out.errors();
    if (value->table()) {
      Fields inner(*value, point_table, reading_.out, key);
      if (const Value* body = inner.require("body")) name = read_string(*body, "body", reading_.out), place = body->place;
      end.point = inner.vec3("point").value_or(Vec3{});
      inner.finish();
    } else {
      name = read_string(*value, key, reading_.out);
    }
    const auto body = name ? body_of_end(*name, place, key, reading_) : std::nullopt;
    const Model& model = reading_.scenario.model;
    if (!body || errors != reading_.out.errors() || (*body != "ground" && !model.has_body(*body))) return std::nullopt;
    end.body = *body == "ground" ? ground : model.body(*body);
    ++ends_;
    return end;
  }

  const char* what_;
  Reading& reading_;
  int ends_ = 0;
};

}  // namespace

constinit const KeyTable spring_table{.name = "[[spring]]",
                                      .definition = "spring",
                                      .about = "A spring or a rope between two points of bodies",
                                      .rules = {{KeyRule::How::some, "stiffness damping"}},
                                      .described = &keys_of<Spring>,
                                      .details =
                                          "The points are of different bodies, or of a body and the ground. The force is along "
                                          "the line between them: stiffness·(length − rest) + "
                                          "damping·(rate of the length) pulls them together. It stays with the bodies, whatever "
                                          "they are joined to. ``sim.world.springs[name]`` has its length and tension; "
                                          "``break_joint`` breaks it, and ``reaction(name).force`` is the size of its force."};

constinit const KeyTable cable_table{.name = "[[cable]]",
                                     .definition = "cable",
                                     .about = "An inextensible cable between two points of bodies",
                                     .described = &keys_of<Cable>,
                                     .details =
                                         "The points are of different bodies, or of a body and the ground, and never farther "
                                         "apart than its length. It becomes taut by an impact (event "
                                         "``taut NAME``), then exerts the tension that this takes, and is slack from the instant "
                                         "at which it would have to push (event ``slack NAME``). ``sim.world.springs[name]`` has "
                                         "its length and tension; ``break_joint`` cuts it."};

namespace {

Spring declared(Spring spring) { return spring; }
Spring declared(Cable cable) { return spring_of(std::move(cable)); }

// Adds it to the model, if its ends are bodies of it and nothing is wrong.
template <class T>
void read(const Value& table, const KeyTable& keys, Reading& reading) {
  Diagnostics& out = reading.out;
  const std::size_t errors = out.errors();
  Fields fields(table, keys, out);
  SpringReader reader(fields, keys.definition, reading);
  T element;
  describe(reader, element);
  fields.finish();
  if (!reader.complete() || errors != out.errors()) return;
  Model& model = reading.scenario.model;
  Spring spring = declared(std::move(element));
  for (SpringProblem& problem : check_spring(spring))
    out.error(fields.place_of(problem.field), problem.field + ": " + problem.what, std::move(problem.hint));
  if (errors != out.errors()) return;
  const double length = norm(start_place(model.bodies(), spring.to) - start_place(model.bodies(), spring.from));
  const std::string what = std::string(keys.definition) + " " + in_quotes(spring.name);
  if (!(length > 0) && spring.inextensible && !spring.rest)
    return out.error(fields.place(), what + ": its ends coincide at the start", "give it a length");
  if (!(length > 0) && spring.rest.value_or(0) > 0 && !spring.tension_only && !spring.inextensible)
    out.warning(fields.place(), what + ": its ends coincide at the start: it has no direction there, and exerts no force",
                "move one of the points");
  model.add_spring(std::move(spring));
}

}  // namespace

void read_spring(const Value& table, Reading& reading) { read<Spring>(table, spring_table, reading); }
void read_cable(const Value& table, Reading& reading) { read<Cable>(table, cable_table, reading); }

}  // namespace momentree::io
