// docs/scenario.schema.json has exactly the keys that the reader accepts, in every table.
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <momentree/io/mistakes/mistakes.hpp>
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

const std::vector<Table>& tables() {
  static const std::string q = slip, value = q + " = 1";
  const auto other_kind = [](const char* kind, const std::string& rest) {
    return one_body + "[mechanism.body.joint]\nkind = \"" + kind + "\"\n" + rest + "\n";
  };
  static const std::string d = "/definitions/";
  static const std::string start = d + "mechanism/properties/state/anyOf/1";
  const auto state = [](const std::string& what) { return head + "state = " + what + "\n" + one_body.substr(head.size()); };
  const auto action = [&](const char* key) { return d + "event/properties/" + key + "/anyOf/0"; };
  static const std::vector<Table> all{
      {"", {value + "\n" + one_body}},
      {"/properties/world", {one_body + "[world]\n" + value}},
      {"/properties/integrate", {one_body + "[integrate]\n" + value}},
      {"/properties/output", {one_body + "[output]\n" + value}},
      {d + "mechanism", {head + value + "\n" + one_body.substr(head.size())}},
      {d + "chain", {chain + value}},
      {d + "body", {one_body + value}},
      {d + "joint",
       {joint(value), other_kind("universal", "axis2 = [1, 0, 0]\n" + value), other_kind("helical", "pitch = 1\n" + value)}},
      {d + "joint_values", {chain + "[mechanism.joint.2]\n" + value}},
      {d + "pose", {joint("at = { " + value + " }")}},
      {d + "drive", {joint("drive = { effort = 1, " + value + " }")}},
      {d + "drive/properties/pd", {joint("drive = { pd = { kp = 1, " + value + " } }")}},
      {d + "friction", {joint("friction = { " + value + " }")}},
      {d + "limits", {joint("limits = { " + value + " }")}},
      {d + "strength", {joint("strength = { " + value + " }")}},
      {d + "signal/anyOf/1", {joint("drive = { effort = { " + value + " } }")}},
      {d + "signal/anyOf/1/properties/sine", {joint("drive = { effort = { sine = { " + value + " } } }")}},
      {d + "shape", {one_body + "shape = { " + value + " }"}},
      {d + "shape/properties/cylinder", {one_body + "shape = { cylinder = { " + value + " } }"}},
      {d + "shape/properties/capsule", {one_body + "shape = { capsule = { " + value + " } }"}},
      {start, {state("{ " + value + " }")}},
      {start + "/properties/velocity", {state("{ velocity = { " + value + " } }")}},
      {start + "/properties/joints/additionalProperties/anyOf/2", {state("{ joints = { a = { " + value + " } } }")}},
      {d + "force", {one_body + "[[force]]\nbody = \"m/a\"\n" + value}},
      {d + "force/properties/drag", {one_body + "[[force]]\nbody = \"m/a\"\ndrag = { " + value + " }"}},
      {d + "coupling", {one_body + "[[coupling]]\njoint = \"m/a\"\nfollows = \"m/a\"\nstiffness = 1\n" + value}},
      {d + "mechanism/properties/mimic", {head + "mimic = { stiffness = 1, " + value + " }\n" + one_body.substr(head.size())}},
      {d + "event", {event(value)}},
      {d + "when", {event("when = { " + value + " }")}},
      {d + "when/properties/reaction", {event("when = { reaction = { " + value + " } }")}},
      {d + "when/properties/height/anyOf/1", {event("when = { height = { " + value + " } }")}},
      {d + "when/properties/distance/items/anyOf/1", {event("when = { distance = [{ " + value + " }, \"m/a\"] }")}},
      {d + "event/properties/after/anyOf/1", {event("after = { " + value + " }")}},
      {action("break") + "/anyOf/1", {event("at = 1\nbreak = { " + value + " }")}},
      {action("free") + "/anyOf/1", {event("at = 1\nfree = { " + value + " }")}},
      {action("lock") + "/anyOf/1", {event("at = 1\nlock = { " + value + " }")}},
      {action("unlock") + "/anyOf/1", {event("at = 1\nunlock = { " + value + " }")}},
      {action("weld"), {event("at = 1\nweld = { " + value + " }")}},
      {action("impulse"), {event("at = 1\nimpulse = { " + value + " }")}},
      {action("set"), {event("at = 1\nset = { joint = \"m/a\", " + value + " }")}},
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

Json schema() {
  std::ifstream file(MOMENTREE_SOURCE_DIR "/docs/scenario.schema.json");
  return Json::parse(file);
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
    for (const std::string& key : keys)
      for (const Mistake* mistake : mistakes_of(where, key)) {
        CAPTURE(where);
        CAPTURE(key);
        CHECK_FALSE(keys.contains(mistake->key));
      }
  }
}

TEST_CASE("every table of the schema is held to the reader") {
  std::set<std::string> found, held;
  const Json whole = schema();
  collect(whole, "", found);
  for (const Table& table : tables()) held.insert(table.at);
  std::string missing;
  for (const std::string& at : found) {
    const std::size_t list = at.find("/anyOf/1/items");  // an action's entry is the same alone and in a list
    if (list != std::string::npos && held.contains(at.substr(0, list) + "/anyOf/0" + at.substr(list + 14)) &&
        whole.at(Json::json_pointer(at)) == whole.at(Json::json_pointer(at.substr(0, list) + "/anyOf/0" + at.substr(list + 14))))
      continue;
    if (!held.contains(at)) missing += at + "\n";
  }
  CHECK(missing == "");
}

TEST_CASE("the schema lists all kinds, methods and quantities") {
  const Json whole = schema();
  Keys kinds;
  for (const KindInfo& kind : all_kinds()) kinds.insert(kind.name);
  CHECK(whole.at("/definitions/joint/properties/kind/enum"_json_pointer).get<Keys>() == kinds);
}

}  // namespace momentree::io
