#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <momentree/scenario/test_support.hpp>
#include <momentree/sweep/plan/read_sweep.hpp>
#include <momentree/sweep/summary.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/json.hpp>

using namespace momentree::sweep;

namespace {

const std::string scenario = R"(format = 1
[[mechanism]]
name = "m"
root = "free"
[[mechanism.body]]
name = "ball"
mass = 2
inertia = 1
[integrate]
step = 0.01
until = 1
)";

struct Folder : momentree::io::test::TemporaryFolder {
  Folder() { momentree::io::write_text_file(*this / "ball.toml", scenario); }
};

// A sweep of the scenario above; `more` stands before [vary].
Sweep sweep_of(const Folder& folder, const std::string& more, const std::string& vary) {
  ReadSweep read = read_sweep_text(
      "format = 1\nscenario = \"ball.toml\"\n" + more + "[vary]\n" + vary + "\n[measure]\nx = { final = \"m/ball.x\" }\n",
      folder / "s.toml");
  for (const auto& each : read.diagnostics) CAPTURE(each.message());
  REQUIRE(read.sweep);
  return std::move(*read.sweep);
}

// All worlds; measure x of world w is w.
SweepSummary summary_of(const Sweep& sweep) {
  SweepSummary summary(sweep);
  Row row;
  row.values.resize(sweep.plan->size());
  for (row.world = 0; row.world < sweep.worlds(); ++row.world) {
    sweep.plan->values(row.world, row.values);
    row.result.measures = {static_cast<double>(row.world)};
    summary.add(row);
  }
  return summary;
}

// A column of the points of the report.
std::vector<double> shown(const SweepSummary& summary, const std::string& column) {
  const momentree::Value document = momentree::io::parse_json(summary.report({}), "report");
  const auto* const values = document.find("values")->value.find(column);
  REQUIRE(values != nullptr);
  std::vector<double> numbers;
  for (const momentree::Value& each : *values->value.array()) numbers.push_back(each.number().value());
  return numbers;
}

}  // namespace

TEST_CASE("sensitivities say what limits their meaning") {
  const Folder folder;
  const std::string vary =
      "\"mechanism.m.body.ball.mass\" = { normal = [9, 1] }\n\"mechanism.m.body.ball.inertia\" = { normal = [9, 1] }\n"
      "\"integrate.step\" = { uniform = [0.01, 0.02] }\n";
  const std::string correlated =
      "[[correlated]]\nparameters = [\"mechanism.m.body.ball.mass\", \"mechanism.m.body.ball.inertia\"]\ncoefficient = 0.5\n";
  const Sweep sweep = sweep_of(folder, "worlds = 100\n" + correlated, vary);
  for (const bool some : {false, true}) {
    SweepSummary summary(sweep);
    Row row;
    row.values.resize(sweep.plan->size());
    for (row.world = 0; row.world < 100; ++row.world) {
      sweep.plan->values(row.world, row.values);
      row.result.measures = {some && row.world % 4 == 0 ? NAN : row.values[0]};
      summary.add(row);
    }
    const momentree::Value document = momentree::io::parse_json(summary.json(), "sweep.json");
    const momentree::Value::Array& all = *document.find("sensitivities")->value.array();
    REQUIRE(all.size() == 3);
    for (std::size_t v = 0; v < 3; ++v) {
      CHECK(all[v].find("pairs")->value.number() == (some ? 75 : 100));
      CHECK(*all[v].find("conditional")->value.boolean() == some);
      CHECK(*all[v].find("correlated")->value.boolean() == (v < 2));
    }
  }
}

TEST_CASE("the points of a report are a uniform sample of many worlds") {
  const Folder folder;
  const std::string mass = "mechanism.m.body.ball.mass";
  const Sweep drawn = sweep_of(folder, "worlds = 40000\n", '"' + mass + "\" = { sobol = [1, 2] }");
  const Sweep combined =
      sweep_of(folder, "", "\"mechanism.m.body.ball.inertia\" = { range = [1, 2, 15000] }\n\"" + mass + "\" = [1, 2]");
  for (const Sweep* const sweep : {&drawn, &combined}) {
    const SweepSummary summary = summary_of(*sweep);
    const std::vector<double> masses = shown(summary, mass), worlds = shown(summary, "world");
    REQUIRE(masses.size() == 20'000);
    CHECK(std::set<double>(worlds.begin(), worlds.end()).size() == 20'000);
    CHECK(std::is_sorted(worlds.begin(), worlds.end()));
    // 4 standard deviations of a share of one half or one quarter among 20,000
    const auto share = [](const std::vector<double>& of, double below) {
      return static_cast<double>(std::count_if(of.begin(), of.end(), [&](double x) { return x < below; })) / 20'000;
    };
    CHECK(share(masses, 1.5) == doctest::Approx(0.5).epsilon(0.03));
    const auto count = static_cast<double>(sweep->worlds());
    CHECK(share(worlds, count / 4) == doctest::Approx(0.25).epsilon(0.05));
    CHECK(shown(summary, "x") == worlds);
  }
  const Sweep few = sweep_of(folder, "worlds = 500\n", '"' + mass + "\" = { sobol = [1, 2] }");
  CHECK(shown(summary_of(few), "world").size() == 500);
}
