#pragma once
// For tests of the files in scenarios/: the program runs them as a user would, and its output files are read.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <momentree/math/vec.hpp>

namespace momentree::test {

using Json = nlohmann::json;

/// A scenario's results, read from files only. The folder is deleted at the end of the test.
class Run {
 public:
  explicit Run(const std::string& scenario, const std::string& options = "") {
    std::random_device random;  // tests may run in parallel
    folder_ = std::filesystem::temp_directory_path() / ("momentree-" + scenario + "-" + std::to_string(random()));
    const std::string file = MOMENTREE_SOURCE_DIR "/scenarios/" + scenario + ".toml";
    REQUIRE(command("run '" + file + "' --quiet " + options + " --out '" + folder_.string() + "' >/dev/null") == 0);
    summary = Json::parse(text("summary.json"));
    final_state = Json::parse(text("final.json"));
    model = Json::parse(text("model.json"));
    std::istringstream lines(text("events.jsonl"));
    for (std::string line; std::getline(lines, line);) events.push_back(Json::parse(line));
    CHECK(summary.at("status") == "done");
  }
  ~Run() { std::filesystem::remove_all(folder_); }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  int command(const std::string& arguments) const { return std::system(("'" MOMENTREE_PROGRAM "' " + arguments).c_str()); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string text(const std::string& name) const {
    std::ifstream in(folder_ / name, std::ios::binary);
    REQUIRE_MESSAGE(in.good(), name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// The columns of a table by name; empty fields are NaN.
  std::map<std::string, std::vector<double>> table(const std::string& name) const {
    std::istringstream lines(text(name));
    std::string line, field;
    std::getline(lines, line);
    std::vector<std::string> names;
    for (std::istringstream head(line); std::getline(head, field, ',');) names.push_back(field);
    std::map<std::string, std::vector<double>> columns;
    while (std::getline(lines, line)) {
      std::istringstream row(line);
      for (const std::string& column : names) {
        const bool there = static_cast<bool>(std::getline(row, field, ',')) && !field.empty();
        columns[column].push_back(there ? std::stod(field) : NAN);
      }
    }
    return columns;
  }
  double energy(const char* key) const { return summary.at("energy").at(key).get<double>(); }

  Json summary, final_state, model;
  std::vector<Json> events;

 private:
  std::filesystem::path folder_;
};

inline Vec3 vec(const Json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()}; }

}  // namespace momentree::test
