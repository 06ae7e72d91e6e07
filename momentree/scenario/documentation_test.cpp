// docs/scenario.schema.json is the schema of this version, and the tables of the documentation list what there is.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/keys/schema.hpp>
#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {
namespace {

using Json = nlohmann::json;
using Keys = std::set<std::string>;

std::string text_of(const std::string& path) {
  std::ifstream file(MOMENTREE_SOURCE_DIR "/" + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The words in backticks in the first cells of a table, which follows a heading: of `break = "arm/elbow"`, `unlock` they are
/// break and unlock. `first`: the table's first cell.
Keys first_column(const std::string& document, const std::string& heading, const std::string& first) {
  std::istringstream lines(document.substr(document.find(heading)));
  std::string line;
  while (std::getline(lines, line) && !line.starts_with("| " + first + " |")) REQUIRE(!lines.eof());
  std::getline(lines, line);
  Keys words;
  while (std::getline(lines, line) && line.starts_with("| ")) {
    const std::string cell = line.substr(2, line.find(" | ") - 2);
    for (std::size_t at = cell.find('`'); at != std::string::npos; at = cell.find('`', cell.find('`', at + 1) + 1))
      if (cell[at + 1] != '{') words.insert(cell.substr(at + 1, cell.find_first_of("` ", at + 1) - at - 1));
  }
  return words;
}

/// The section of a document under a heading.
std::string section(const std::string& document, const std::string& heading) {
  const std::size_t begin = document.find("\n" + heading + "\n");
  REQUIRE(begin != std::string::npos);
  const std::size_t body = begin + heading.size() + 1;
  return document.substr(body, std::min(document.find("\n## ", body), document.find("\n### ", body)) - body);
}

Keys set_of(const std::vector<std::string>& words) { return {words.begin(), words.end()}; }
Keys kinds() {
  Keys names;
  for (const KindInfo& kind : all_kinds()) names.insert(kind.name);
  return names;
}

}  // namespace

TEST_CASE("docs/scenario.schema.json is the schema of this version") {
  const bool same = text_of("docs/scenario.schema.json") == scenario_schema();
  INFO("./dev schema writes it");
  CHECK(same);
}

TEST_CASE("the tables of the documentation list all kinds, methods, quantities and actions") {
  const std::string scenario = text_of("docs/scenario.md");
  CHECK(first_column(scenario, "### Kinds", "kind") == kinds());
  const Keys of_models = first_column(text_of("docs/models.md"), "## Into another file", "momentree");
  for (const std::string& kind : kinds()) {
    CAPTURE(kind);
    CHECK(of_models.contains(kind));
  }
  CHECK(first_column(scenario, "A condition uses one of these quantities", "quantity") == set_of(quantity_keys()));
  CHECK(first_column(scenario, "### Actions", "action") == set_of(scenario_actions()));
  std::string row = scenario.substr(scenario.find("| `method` |"));
  row = row.substr(row.find("fixed steps"), row.find('\n') - row.find("fixed steps"));
  Keys methods;
  for (std::size_t at = row.find("`\""); at != std::string::npos; at = row.find("`\"", at + 1))
    methods.insert(row.substr(at + 2, row.find('"', at + 2) - at - 2));
  CHECK(methods == set_of(method_names()));
}

TEST_CASE("the tables of the documentation have the keys of the schema") {
  const Json whole = Json::parse(scenario_schema());
  const std::string document = text_of("docs/scenario.md");
  for (const auto& [heading, at] :
       std::map<std::string, std::string>{{"### `[[mechanism.body]]`", "/definitions/body"},
                                          {"### `[mechanism.body.joint]`", "/definitions/joint"},
                                          {"### `[[coupling]]`", "/definitions/coupling"},
                                          {"### `[[force]]`", "/definitions/force"},
                                          {"### `[[spring]]`", "/definitions/spring"},
                                          {"### `[[event]]`", "/definitions/event"},
                                          {"### `[integrate]` and `[output]`", "/properties/integrate"}}) {
    CAPTURE(heading);
    const std::string text = section(document, heading);
    Keys keys;
    for (const auto& [key, value] : whole.at(Json::json_pointer(at + "/properties")).items()) keys.insert(key);
    for (const std::string& key : first_column(text, "\n", "key")) {
      CAPTURE(key);
      CHECK((keys.contains(key) || key == "[output]"));
    }
    for (const std::string& key : scenario_actions()) keys.erase(key);  // which have their own table
    for (const std::string& key : keys) {
      CAPTURE(key);
      CHECK((text.find("`" + key + "`") != std::string::npos || text.find("`" + key + " = ") != std::string::npos));
    }
  }
}

}  // namespace momentree::io
