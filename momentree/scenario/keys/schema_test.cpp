// The schema of scenarios has exactly the keys and words that the reader accepts, in every table.
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/keys/schema.hpp>
#include <momentree/scenario/mistakes/mistakes.hpp>
#include <momentree/scenario/scenario_parts.hpp>
#include <tests/bad_input.hpp>

namespace momentree::io {
namespace {

using namespace bad_input;
using Json = nlohmann::json;
using Keys = std::set<std::string>;

const char* const slip = "qqqqqqqq";

/// The keys that the reader lists for an unknown key; `where`: its name for the table.
Keys known_where(const std::string& text, std::string& where) {
  const ReadResult result = read_scenario_text(text, "s.toml");
  for (const Diagnostic& each : result.diagnostics) {
    if (each.what.find(std::string("unknown key '") + slip) != 0) continue;
    where = each.what.substr(each.what.find(" in ") + 4);
    const std::string begin = "known here: ";
    REQUIRE(each.hint.substr(0, begin.size()) == begin);
    std::istringstream words(each.hint.substr(begin.size()));
    Keys keys;
    for (std::string word; words >> word;) keys.insert(word);
    return keys;
  }
  FAIL(text << "\n" << said(result));
  return {};
}

/// `at`: a JSON pointer to a table of the schema; each text has a misspelled key in such a table.
struct Table {
  std::string at;
  std::vector<std::string> texts;
};

std::string event(const std::string& what) { return pinned + "[[event]]\n" + what + "\n"; }
std::string joint(const std::string& what) { return pinned + what + "\n"; }

std::string loop(const std::string& what) { return one_body + "[[loop]]\nname = \"l\"\nbody = \"m/a\"\n" + what + "\n"; }

const std::vector<Table>& tables() {
  static const std::string q = slip, value = q + " = 1";
  const auto other_kind = [](const char* kind, const std::string& rest) {
    return one_body + "[mechanism.body.joint]\nkind = \"" + kind + "\"\n" + rest + "\n";
  };
  static const std::string d = "/definitions/";
  static const std::string start = d + "mechanism/properties/state/anyOf/1";
  const auto state = [](const std::string& what) { return head + "state = " + what + "\n" + one_body.substr(head.size()); };
  const auto action = [&](const char* key) { return d + key + "_action"; };
  static const std::vector<Table> all{
      {"", {value + "\n" + one_body}},
      {"/properties/world", {one_body + "[world]\n" + value}},
      {"/properties/integrate", {one_body + "[integrate]\n" + value}},
      {"/properties/output", {one_body + "[output]\n" + value}},
      {"/properties/world/properties/floor/anyOf/1", {one_body + "[world]\nfloor = { " + value + " }"}},
      {"/properties/world/properties/floor/anyOf/1/properties/friction/anyOf/1",
       {one_body + "[world]\nfloor = { friction = { kinetic = 1, " + value + " } }"}},
      {d + "belt", {one_body + "collision = { sphere = 1 }\nbelt = { axis = [0, 1, 0], speed = 1, " + value + " }"}},
      {d + "contact", {one_body + "[[contact]]\n" + value}},
      {d + "contact/properties/friction/anyOf/1", {one_body + "[[contact]]\nfriction = { kinetic = 1, " + value + " }"}},
      {d + "mechanism", {head + value + "\n" + one_body.substr(head.size())}},
      {d + "chain", {chain + value}},
      {d + "body", {one_body + value}},
      {d + "joint",
       {joint(value), other_kind("universal", "axis2 = [1, 0, 0]\n" + value), other_kind("helical", "pitch = 1\n" + value)}},
      {d + "joint_override", {chain + "[mechanism.joint.2]\n" + value}},
      {d + "placement", {joint("at = { " + value + " }")}},
      {d + "drive", {joint("drive = { effort = 1, " + value + " }")}},
      {d + "pd", {joint("drive = { pd = { kp = 1, " + value + " } }")}},
      {d + "friction", {joint("friction = { " + value + " }")}},
      {d + "limits", {joint("limits = { " + value + " }")}},
      {d + "strength", {joint("strength = { " + value + " }")}},
      {d + "signal", {joint("drive = { effort = { " + value + " } }")}},
      {d + "signal/properties/sine", {joint("drive = { effort = { sine = { " + value + " } } }")}},
      {d + "shape", {one_body + "shape = { " + value + " }"}},
      {d + "ground_shape",
       {"[world]\ncollision = { " + value + " }",
        "[world]\ncollision = { heightmap = [[0, 1], [0, 1]], size = [1, 1, 1], " + value + " }"}},
      {d + "cylinder", {one_body + "shape = { cylinder = { " + value + " } }"}},
      {d + "capsule", {one_body + "shape = { capsule = { " + value + " } }"}},
      {start, {state("{ " + value + " }")}},
      {start + "/properties/velocity", {state("{ velocity = { " + value + " } }")}},
      {d + "joint_start", {state("{ joints = { a = { " + value + " } } }")}},
      {d + "force", {one_body + "[[force]]\nbody = \"m/a\"\n" + value}},
      {d + "spring", {one_body + "[[spring]]\nname = \"s\"\n" + value}},
      {d + "cable", {one_body + "[[cable]]\nname = \"s\"\n" + value}},
      {d + "force/properties/drag", {one_body + "[[force]]\nbody = \"m/a\"\ndrag = { " + value + " }"}},
      {d + "loop",
       {loop("kind = \"revolute\"\n" + value), loop("kind = \"universal\"\naxis2 = [1, 0, 0]\n" + value),
        loop("kind = \"helical\"\npitch = 1\n" + value)}},
      {d + "coupling", {one_body + "[[coupling]]\njoint = \"m/a\"\nfollows = \"m/a\"\nstiffness = 1\n" + value}},
      {d + "mechanism/properties/mimic/anyOf/2",
       {head + "mimic = { stiffness = 1, " + value + " }\n" + one_body.substr(head.size())}},
      {d + "event", {event(value)}},
      {d + "condition", {event("when = { " + value + " }")}},
      {d + "condition/properties/reaction", {event("when = { reaction = { " + value + " } }")}},
      {d + "point",
       {event("when = { height = { " + value + " } }"), event("when = { distance = [{ " + value + " }, \"m/a\"] }")}},
      {d + "event/properties/after/anyOf/1", {event("after = { " + value + " }")}},
      {action("break"), {event("at = 1\nbreak = { " + value + " }")}},
      {action("free"), {event("at = 1\nfree = { " + value + " }")}},
      {action("lock"), {event("at = 1\nlock = { " + value + " }")}},
      {action("unlock"), {event("at = 1\nunlock = { " + value + " }")}},
      {action("weld"), {event("at = 1\nweld = { " + value + " }")}},
      {action("impulse"), {event("at = 1\nimpulse = { " + value + " }")}},
      {action("set"), {event("at = 1\nset = { joint = \"m/a\", " + value + " }")}},
      {action("set_length"), {event("at = 1\nset_length = { cable = \"m/a\", " + value + " }")}},
      {action("change"),
       {event("at = 1\nchange = { kind = \"universal\", " + value + " }"),
        event("at = 1\nchange = { kind = \"helical\", " + value + " }")}},
      {action("attach"),
       {event("at = 1\nattach = { kind = \"universal\", " + value + " }"),
        event("at = 1\nattach = { kind = \"helical\", " + value + " }")}},
  };
  return all;
}

/// All tables of the schema: objects that list their keys, by JSON pointer.
void collect(const Json& node, const std::string& at, std::set<std::string>& found) {
  if (node.is_object() && node.contains("properties") && node.contains("additionalProperties")) found.insert(at);
  if (node.is_object())
    for (const auto& [key, value] : node.items()) collect(value, at + "/" + key, found);
  if (node.is_array())
    for (std::size_t i = 0; i < node.size(); ++i) collect(node[i], at + "/" + std::to_string(i), found);
}

Json schema() { return Json::parse(scenario_schema()); }

void check_accepted(const std::string& text) {
  const ReadResult result = read_scenario_text(text, "s.toml");
  CAPTURE(text);
  INFO(said(result));
  CHECK(result.scenario.has_value());
}

/// A kind of joint, with its geometry.
std::string geometry(const std::string& kind) {
  const KindInfo* info = find_kind(kind);
  REQUIRE(info != nullptr);
  return "kind = \"" + kind + "\"" + (info->axis ? ", axis = [0, 1, 0]" : "") + (info->axis2 ? ", axis2 = [1, 0, 0]" : "") +
         (info->pitch ? ", pitch = 1" : "");
}

/// Mechanism m with the link a on a revolute joint and the link b, and the free mechanism f.
const std::string two = pinned +
                        "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = "
                        "\"revolute\"\nparent = \"a\"\nat = { xyz = [1, 0, 0] }\n[[mechanism]]\nname = \"f\"\nroot = "
                        "\"free\"\n[[mechanism.body]]\nname = \"c\"\nmass = 1\ninertia = 1\n";
std::string event_of_two(const std::string& what) { return two + "[[event]]\n" + what + "\n"; }

/// Every enumeration of the schema, with a scenario that uses a word of it.
const std::map<std::string, std::function<std::string(const std::string&)>>& enumerations() {
  static const std::string d = "/definitions/";
  static const auto quoted = [](const std::string& word) { return "\"" + word + "\""; };
  static const std::map<std::string, std::function<std::string(const std::string&)>> all{
      {d + "joint/properties/kind", [](const std::string& kind) { return one_body + "joint = { " + geometry(kind) + " }\n"; }},
      {d + "change_action/properties/kind",
       [](const std::string& kind) { return event_of_two("at = 1\nchange = { joint = \"m/b\", " + geometry(kind) + " }"); }},
      {d + "attach_action/properties/kind",
       [](const std::string& kind) {
         return event_of_two("at = 1\nattach = { body = \"f/c\", to = \"m/b\", " + geometry(kind) + " }");
       }},
      {d + "loop/properties/kind",
       [](const std::string& kind) {
         return "loop = [{ name = \"l\", body = \"m/b\", at = { xyz = [1, 0, 0] }, " + geometry(kind) + " }]\n" + two;
       }},
      {d + "condition/properties/undetermined",
       [](const std::string& word) {
         return event_of_two("when = { reaction_force = \"m/b\", exceeds = 1, undetermined = " + quoted(word) +
                             " }\nbreak = \"m/b\"");
       }},
      {d + "body/properties/collision/anyOf/0",
       [](const std::string& word) { return one_body + "shape = { sphere = 1 }\ncollision = " + quoted(word) + "\n"; }},
      {"/properties/integrate/properties/simultaneous",
       [](const std::string& how) { return pinned + "[integrate]\nsimultaneous = " + quoted(how) + "\n"; }},
      {"/properties/integrate/properties/variables",
       [](const std::string& name) { return pinned + "[integrate]\nvariables = " + quoted(name) + "\n"; }},
      {"/properties/integrate/properties/method",
       [](const std::string& method) { return pinned + "[integrate]\nmethod = " + quoted(method) + "\n"; }},
      {d + "mechanism/properties/root",
       [](const std::string& root) { return head + "root = " + quoted(root) + "\n" + one_body.substr(head.size()); }},
      {d + "mechanism/properties/collision",
       [](const std::string& word) { return head + "collision = " + quoted(word) + "\n" + one_body.substr(head.size()); }},
      {d + "signal/properties/ends",
       [](const std::string& ends) {
         return pinned + "drive = { motion = { table = [[0, 0], [1, 1]], ends = " + quoted(ends) + " } }\n";
       }},
      {d + "force/properties/axes",
       [](const std::string& axes) {
         return pinned + "[[force]]\nbody = \"m/a\"\nforce = [1, 0, 0]\naxes = " + quoted(axes) + "\n";
       }},
      {d + "condition/properties/reaction/properties/component",
       [](const std::string& component) {
         return event_of_two("when = { reaction = { joint = \"m/b\", component = " + quoted(component) +
                             " }, exceeds = 1 }\nbreak = \"m/b\"");
       }},
      {d + "event/properties/locate",
       [](const std::string& locate) {
         return event_of_two("when = { speed = \"m/b\", exceeds = 1 }\nlocate = " + quoted(locate) + "\nbreak = \"m/b\"");
       }},
  };
  return all;
}

/// The enumerations of the schema, by JSON pointer.
void collect_enumerations(const Json& node, const std::string& at, Keys& found) {
  if (node.is_object() && node.contains("enum")) found.insert(at);
  if (node.is_structured())
    for (const auto& [key, value] : node.items()) collect_enumerations(value, at + "/" + key, found);
}

Keys set_of(const std::vector<std::string>& words) { return {words.begin(), words.end()}; }
Keys kinds() {
  Keys names;
  for (const KindInfo& kind : all_kinds()) names.insert(kind.name);
  return names;
}

}  // namespace

TEST_CASE("the schema of scenarios has the reader's keys, in every table") {
  const Json whole = schema();
  for (const Table& table : tables()) {
    CAPTURE(table.at);
    const Json& here = whole.at(Json::json_pointer(table.at));
    Keys of_reader, of_schema;
    std::string where;
    for (const std::string& text : table.texts) of_reader.merge(known_where(text, where));
    for (const auto& [key, value] : here.at("properties").items()) {
      of_schema.insert(key);
      CAPTURE(key);
      CHECK((value.contains("description") || value.contains("$ref")));
    }
    CHECK(of_schema == of_reader);
    CHECK(here.at("additionalProperties") == false);
  }
}

TEST_CASE("no valid key is mistaken for a misspelt one") {
  const Json whole = schema();
  const std::map<std::string, std::string> contexts{
      {"'at'", "placement"}, {"effort", "signal"}, {"'a'", "start"}, {"[mechanism.joint.2]", "override"}};
  for (const Table& table : tables()) {
    Keys keys;
    std::string where;
    for (const std::string& text : table.texts) keys.merge(known_where(text, where));
    if (const auto context = contexts.find(where); context != contexts.end()) where = context->second;
    Keys own;  // which the reader never takes for mistakes
    if (where == "[[event]]") own = set_of(scenario_actions());
    if (where == "when") own = set_of(quantity_keys());
    for (const std::string& key : keys)
      for (const Mistake* mistake : mistakes_of(where, key)) {
        if (own.contains(key)) continue;
        CAPTURE(where);
        CAPTURE(key);
        CHECK_FALSE(keys.contains(mistake->key));
      }
  }
}

TEST_CASE("every table of the schema is compared with the reader") {
  std::set<std::string> found, held;
  collect(schema(), "", found);
  for (const Table& table : tables()) held.insert(table.at);
  CHECK(found == held);
}

TEST_CASE("the reader accepts every word of every enumeration of the schema, and these are all words") {
  const Json whole = schema();
  Keys found, tried;
  collect_enumerations(whole, "", found);
  for (const auto& [at, text] : enumerations()) {
    CAPTURE(at);
    tried.insert(at);
    const Keys words = whole.at(Json::json_pointer(at + "/enum")).get<Keys>();
    CHECK_FALSE(words.empty());
    for (const std::string& word : words) check_accepted(text(word));
    if (at.ends_with("/kind")) continue;  // whose other keys depend on it
    CHECK_FALSE(read_scenario_text(text("qqqqqqqq"), "s.toml").scenario.has_value());
  }
  CHECK(found == tried);
  for (const char* joint : {"joint", "change_action", "attach_action"})
    CHECK(whole.at("definitions").at(joint).at("properties").at("kind").at("enum").get<Keys>() == kinds());
  Keys of_loops = kinds();
  of_loops.erase("free");
  CHECK(whole.at("/definitions/loop/properties/kind/enum"_json_pointer).get<Keys>() == of_loops);
  CHECK(whole.at("/properties/integrate/properties/method/enum"_json_pointer).get<Keys>() == set_of(method_names()));
}

TEST_CASE("the reader accepts every quantity and every action of the schema, and these are all of them") {
  const Json whole = schema();
  const std::map<std::string, std::string> quantities{
      {"contact_force", "[\"m/b\", \"f/c\"]"},
      {"contact_impulse", "[\"m/b\", \"f/c\"]"},
      {"distance", "[\"m/b\", { body = \"ground\" }]"},
      {"gap", "[\"m/b\", \"f/c\"]"},
      {"height", "{ body = \"m/b\", point = [1, 0, 0] }"},
      {"kinetic_energy", "\"m\""},
      {"position", "\"m/b\""},
      {"reaction", "{ joint = \"m/b\", component = \"fx\" }"},
      {"reaction_force", "\"m/b\""},
      {"reaction_impulse", "\"m/b\""},
      {"reaction_torque", "\"m/b\""},
      {"slip", "[\"m/b\", \"f/c\"]"},
      {"speed", "\"m/b\""},
      {"touch", "[\"m/b\", \"f/c\"]"},
  };
  Keys of_schema;
  for (const auto& [key, value] : whole.at("/definitions/condition/properties"_json_pointer).items()) of_schema.insert(key);
  for (const char* other : {"exceeds", "below", "undetermined"}) CHECK(of_schema.erase(other) == 1);
  CHECK(of_schema == set_of(quantity_keys()));
  // With something to touch, apart from each other.
  const auto with_collision = [](std::string text) {
    for (const auto& [name, at] : {std::pair{"b", "1"}, {"c", "-1"}}) {
      const std::string head_of = std::string("name = \"") + name + "\"\nmass = 1\n";
      text.replace(text.find(head_of), head_of.size(),
                   head_of + "collision = { sphere = 0.1, at = { xyz = [" + at + ", 5, 0] } }\n");
    }
    return text;
  };
  for (const std::string& key : of_schema) {
    const std::string threshold = make_quantity(key)->has_threshold() ? ", exceeds = 1" : "";
    check_accepted(
        with_collision(event_of_two("when = { " + key + " = " + quantities.at(key) + threshold + " }\nbreak = \"m/b\"")));
  }

  const std::map<std::string, std::string> actions{
      {"attach", "{ body = \"f/c\", to = \"m/b\", kind = \"ball\" }"},
      {"break", "\"m/b\""},
      {"change", "{ joint = \"m/b\", kind = \"ball\" }"},
      {"free", "\"m/b\""},
      {"impulse", "{ body = \"m/b\", force = [1, 0, 0] }"},
      {"lock", "{ joint = \"m/b\", freedoms = [0] }"},
      {"set", "{ joint = \"m/b\", damping = 1 }"},
      {"set_length",
       "{ cable = \"rope\", length = 9 }\n[[spring]]\nname = \"rope\"\nfrom = \"m/b\"\nto = \"f/c\"\nstiffness = 1"},
      {"unlock", "\"m/b\"\n[[event]]\nat = 0.5\nlock = \"m/b\""},
      {"weld", "{ body = \"f/c\", to = \"m/b\", name = \"m/clasp\" }"},
  };
  Keys defined;
  for (const auto& [name, definition] : whole.at("definitions").items())
    if (name.ends_with("_action")) defined.insert(name.substr(0, name.rfind('_')));
  CHECK(defined == set_of(scenario_actions()));
  for (const std::string& key : defined) {
    CHECK(whole.at("/definitions/event/properties"_json_pointer).contains(key));
    check_accepted(event_of_two("at = 1\n" + key + " = " + actions.at(key)));
  }
}

}  // namespace momentree::io
