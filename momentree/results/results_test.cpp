#include <momentree/results/results.hpp>

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <sstream>

#include <momentree/joint/kinds.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/recording/recording.hpp>
#include <momentree/scenario/test_support.hpp>

namespace momentree::io {
namespace {

using Rows = std::vector<std::vector<std::string>>;

Rows table(const std::string& path) {
  std::istringstream text(read_text_file(path));
  Rows rows;
  for (std::string line; std::getline(text, line);) {
    rows.emplace_back();
    std::istringstream cells(line + ',');
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

std::size_t column(const Rows& rows, const std::string& name) {
  for (std::size_t c = 0; c < rows[0].size(); ++c)
    if (rows[0][c] == name) return c;
  return rows[0].size();
}

std::vector<JointKinds> all_joints(Simulation& simulation) { return joints_of(simulation, simulation.dry_run(), {}); }

// A complete run of two_mechanisms with a break at 0.105 s, and a row every `every` s.
Rows run(const std::string& out, double every, const char* file, double until = 0.5, bool reactions = false) {
  const Model model = test::two_mechanisms();
  Simulation simulation(model, {.step = 0.01});
  simulation.at(0.105).then(break_joint("arm/shoulder"));
  RunOrigin origin;
  origin.name = "arm";
  Recorder recorder(simulation, origin, "{}",
                    {.directory = out, .joints = all_joints(simulation), .every = every, .reactions = reactions});
  simulation.observe(every, [&](const World& world) { return recorder.observe(world); });
  REQUIRE(simulation.run_until(until) == Status::ok);
  recorder.finish("done", {{"#1", 1}});
  CHECK_FALSE(recorder.error());
  CHECK(recorder.is_published());
  CHECK(recorder.directory() == out);
  return table(out + '/' + file);
}

TEST_CASE("rows at the multiples of `every` and at the end, none at events between") {
  const test::TemporaryFolder folder;
  const Rows rows = run(folder / "r", 0.1, "bodies.csv", 0.45);
  CHECK(rows[0][0] == "time");
  CHECK(rows[0][1] == "arm/base.x");
  CHECK(rows[0][7] == "arm/base.qz");
  REQUIRE(rows.size() == 7);
  for (std::size_t k = 0; k < 5; ++k) CHECK(std::stod(rows[k + 1][0]) == doctest::Approx(0.1 * static_cast<double>(k)));
  CHECK(rows[6][0] == "0.45");
}

TEST_CASE("without `every` a row for each step, one at the event, too") {
  const test::TemporaryFolder folder;
  const Rows rows = run(folder / "r", 0, "bodies.csv", 0.2);
  int at_event = 0;
  for (const auto& row : rows) at_event += row[0] == "0.105" ? 1 : 0;
  CHECK(at_event == 1);
  CHECK(rows.size() == 1 + 1 + 11 + 10);  // the header, the start, to 0.105 s, to 0.2 s
}

TEST_CASE("columns for every possible joint, as wide as its widest kind") {
  const test::TemporaryFolder folder;
  const Rows rows = run(folder / "r", 0.1, "joints.csv");
  const std::size_t count = rows[0].size();
  for (const auto& row : rows) REQUIRE(row.size() == count);
  CHECK(count == 1 + (7 + 12) + (4 + 6) + (7 + 12) + 3 + 3);
  const std::size_t before = column(rows, "arm/shoulder.q3"), after = column(rows, "arm/link.p5");
  REQUIRE(before < count);
  REQUIRE(after < count);
  CHECK(rows[2][before] != "");  // 0.1 s
  CHECK(rows[2][after] == "");
  CHECK(rows[3][before] == "");  // 0.2 s
  CHECK(rows[3][after] != "");
  CHECK(rows[1][column(rows, "arm/wrist.q0")] == "0.7");
}

TEST_CASE("reactions on request: after the other columns of their joint, empty if it does not exist") {
  const test::TemporaryFolder folder;
  const Rows plain = run(folder / "r", 0.1, "joints.csv");
  const Rows rows = run(folder / "r", 0.1, "joints.csv", 0.5, true);
  REQUIRE(rows.size() == plain.size());
  REQUIRE(rows[0].size() == plain[0].size() + 5 * 6);
  CHECK(rows[0][column(rows, "arm/shoulder.p2") + 1] == "arm/shoulder.fx");
  CHECK(rows[0][column(rows, "arm/shoulder.fx") + 5] == "arm/shoulder.mz");
  const auto number = [&](std::size_t row, const char* name) { return std::stod(rows[row][column(rows, name)]); };
  for (std::size_t r = 1; r < rows.size(); ++r) {
    REQUIRE(rows[r].size() == rows[0].size());
    for (std::size_t c = 0; c < plain[0].size(); ++c) CHECK(rows[r][column(rows, plain[0][c])] == plain[r][c]);
    CHECK((rows[r][column(rows, "arm/shoulder.mz")] == "") == (number(r, "time") > 0.105));
    CHECK((rows[r][column(rows, "arm/link.fx")] == "") == (number(r, "time") < 0.105));
    // A point mass of 1 kg at 1 m: the force is along the rod.
    const double v = number(r, "pendulum.v0");
    CHECK(number(r, "pendulum.fz") == doctest::Approx(9.81 * std::cos(number(r, "pendulum.q0")) + v * v).epsilon(1e-12));
    for (const char* none : {"pendulum.fx", "pendulum.fy", "pendulum.mx", "pendulum.my", "pendulum.mz"})
      CHECK(std::fabs(number(r, none)) < 1e-12);
  }
  for (const char* free : {"arm/link.fx", "arm/link.fz", "arm/link.my"}) CHECK(std::fabs(number(3, free)) < 1e-10);
  CHECK(std::fabs(number(3, "arm/wrist.fx")) > 1e-3);
}

TEST_CASE("energy.csv: kinds of energy that add up, gravity by the poses of bodies.csv, momentum") {
  const test::TemporaryFolder folder;
  const Rows poses = run(folder / "r", 0.1, "bodies.csv"), rows = run(folder / "r", 0.1, "energy.csv");
  REQUIRE(rows.size() == poses.size());
  const auto number = [](const Rows& of, std::size_t row, const std::string& name) {
    return std::stod(of[row][column(of, name)]);
  };
  const Model model = test::two_mechanisms();
  double first = 0;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    REQUIRE(rows[r].size() == 15);
    CHECK(rows[r][0] == poses[r][0]);
    double gravity = 0;
    for (const BodySpec& body : model.bodies()) {
      const auto of = [&](const char* suffix) { return number(poses, r, body.name + suffix); };
      const Pose pose{{of(".x"), of(".y"), of(".z")}, Quat{of(".qw"), of(".qx"), of(".qy"), of(".qz")}};
      gravity += 9.81 * body.mass * (pose * body.com).z;
    }
    const auto of = [&](const char* name) { return number(rows, r, name); };
    CHECK(of("gravity") == doctest::Approx(gravity).epsilon(1e-12));
    const double all =
        of("kinetic") + of("gravity") + of("elastic") + of("dissipated") + of("lost") + of("released") - of("work");
    if (r == 1) first = all;
    CHECK(all - of("error") == doctest::Approx(first).epsilon(1e-12));
    CHECK(std::fabs(of("error")) < 1e-4);
    CHECK(of("elastic") > 0);  // the wrist's spring: ½ k q²
  }
  CHECK(number(rows, 1, "elastic") == doctest::Approx(0.5 * 2 * 0.7 * 0.7).epsilon(1e-12));
  CHECK(number(rows, rows.size() - 1, "dissipated") > 0);
  // The free arm falls: its momentum changes only by m g t; the rest is due to the pendulum's joint. No horizontal force acts
  // on the arm.
  CHECK(number(rows, rows.size() - 1, "linear.x") == doctest::Approx(number(rows, 1, "linear.x")).epsilon(1e-6));
}

TEST_CASE("quaternions are continuous in sign") {
  const test::TemporaryFolder folder;
  for (const auto& [file, name] : {std::pair{"bodies.csv", "arm/base.qw"}, std::pair{"joints.csv", "arm/base.q3"}}) {
    const Rows rows = run(folder / "r", 0, file, 3.0);
    const std::size_t w = column(rows, name);
    double lowest = 1;
    for (std::size_t r = 2; r < rows.size(); ++r) {
      double along = 0;
      for (std::size_t c = w; c < w + 4; ++c) along += std::stod(rows[r][c]) * std::stod(rows[r - 1][c]);
      CHECK(along > 0.9);
      lowest = std::min(lowest, std::stod(rows[r][w]));
    }
    CHECK(lowest < -0.25);  // it turns far enough for the test to be significant
  }
}

TEST_CASE("the JSON files") {
  const test::TemporaryFolder folder;
  run(folder / "r", 0.1, "bodies.csv");
  const nlohmann::json event = nlohmann::json::parse(read_text_file(folder / "r/events.jsonl"));
  for (const char* key : {"time", "event", "actions", "mechanisms", "before", "after", "released", "lost", "work", "impulse",
                          "ground_impulse", "hardest", "duration_ns"})
    CHECK(event.contains(key));
  CHECK(event.at("time") == 0.105);
  CHECK(event.at("mechanisms").at("after").size() == 3);
  const nlohmann::json summary = nlohmann::json::parse(read_text_file(folder / "r/summary.json"));
  for (const char* key : {"status", "version", "scenario", "method", "steps", "evaluations", "wall_clock", "real_time_factor",
                          "worst_step", "energy"})
    CHECK(summary.contains(key));
  CHECK(summary.at("status") == "done");
  CHECK(summary.at("steps") == 51);
  const nlohmann::json final_state = nlohmann::json::parse(read_text_file(folder / "r/final.json"));
  CHECK(final_state.at("time") == 0.5);
  CHECK(read_text_file(folder / "r/model.json") == "{}");
}

TEST_CASE("a run that is not done stays next to its destination") {
  const test::TemporaryFolder folder;
  const Model model = test::two_mechanisms();
  Simulation simulation(model, {.step = 0.01});
  Recorder recorder(simulation, {}, "{}", {.directory = folder / "r"});
  simulation.observe(0, [&](const World& world) { return recorder.observe(world) && world.time() < 0.095; });
  CHECK(simulation.run_until(1) == Status::interrupted);
  recorder.finish("interrupted at t = 0.1 s", {});
  CHECK_FALSE(std::filesystem::exists(folder / "r"));
  CHECK(recorder.directory() == folder / "r.partial");
  CHECK(table(folder / "r.partial/bodies.csv").size() == 12);
  CHECK(read_text_file(folder / "r.partial/events.jsonl") == "");
  CHECK(read_text_file(folder / "r.partial/summary.json").find("interrupted at t = 0.1 s") != std::string::npos);
}

TEST_CASE("a run whose simulation failed keeps its rows and reports why; so does an abandoned one") {
  const test::TemporaryFolder folder;
  const Model model = test::two_mechanisms();
  Simulation simulation(model, {.step = 0.01});
  {
    Recorder recorder(simulation, {}, "{}", {.directory = folder / "r"});
    simulation.observe(0, [&](const World& world) { return recorder.observe(world); });
    CHECK(simulation.run_until(0.05) == Status::ok);
    CHECK(read_text_file(folder / "r.partial/summary.json").find("running, or killed") != std::string::npos);
    recorder.abandon("failed: out of memory");
    CHECK(recorder.directory() == folder / "r.partial");
  }
  CHECK(table(folder / "r.partial/bodies.csv").size() == 1 + 6);
  CHECK(read_text_file(folder / "r.partial/summary.json").find("\"status\": \"failed: out of memory\"") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder / "r.partial/final.json"));
  { const Recorder dropped(simulation, {}, "{}", {.directory = folder / "r"}); }
  CHECK(read_text_file(folder / "r.partial/summary.json").find("\"status\": \"failed: the program ended") != std::string::npos);
}

TEST_CASE("a run fails if its report or its destination cannot be written") {
  const test::TemporaryFolder folder;
  const Model model = test::two_mechanisms();
  Simulation simulation(model, {.step = 0.01});
  const auto finish = [&](const ReportPage& report) {
    Recorder recorder(simulation, {}, "{}", {.directory = folder / "r", .report = true});
    CHECK(simulation.run_until(simulation.time() + 0.1) == Status::ok);
    recorder.finish("done", {}, report);
    CHECK_FALSE(recorder.is_published());
    REQUIRE(recorder.error());
    CHECK(recorder.summary() == read_text_file(folder / "r.partial/summary.json"));
    CHECK(recorder.has_report() == std::filesystem::exists(folder / "r.partial/report.html"));
    return recorder.status();
  };
  CHECK(finish([](const std::filesystem::path&, const std::string&) -> std::string {
          throw_error({"no page", "report.html", ""});
        }) == "failed: report.html: error: no page");
  const auto taken = [&](const std::filesystem::path&, const std::string& summary) {
    std::filesystem::create_directories(folder / "r");
    write_text_file(folder / "r/thesis.tex", "years of work");
    return summary;
  };
  CHECK(finish(taken).find("it will not be replaced") != std::string::npos);
  CHECK(read_text_file(folder / "r.partial/report.html") == read_text_file(folder / "r.partial/summary.json"));
}

TEST_CASE("rows are on the disk with their events, whole, during the run") {
  const test::TemporaryFolder folder;
  const Model model = test::two_mechanisms();
  Simulation simulation(model, {.step = 0.001});
  simulation.at(0.105).then(break_joint("arm/shoulder"));
  Recorder recorder(simulation, {}, "{}", {.directory = folder / "r"});
  simulation.observe(0, [&](const World& world) { return recorder.observe(world); });
  REQUIRE(simulation.run_until(2) == Status::ok);
  const Rows bodies = table(folder / "r.partial/bodies.csv"), energy = table(folder / "r.partial/energy.csv");
  CHECK(bodies.size() > 500);
  CHECK(energy.size() == bodies.size());
  CHECK(energy.back()[0] == bodies.back()[0]);
  CHECK(read_text_file(folder / "r.partial/bodies.csv").ends_with('\n'));
  CHECK(std::stod(bodies.back()[0]) > 0.105);
  CHECK(read_text_file(folder / "r.partial/events.jsonl").find("break arm/shoulder") != std::string::npos);
}

TEST_CASE("removed bodies have empty cells in the tables, added ones have no columns") {
  const test::TemporaryFolder folder;
  const Model model = test::two_mechanisms();
  Simulation simulation(model, {.step = 0.01});
  Recorder recorder(simulation, {}, "{}", {.directory = folder / "r", .joints = all_joints(simulation)});
  simulation.observe(0, [&](const World& world) { return recorder.observe(world); });
  REQUIRE(simulation.run_until(0.02) == Status::ok);
  simulation.remove(model.body("arm/link"));
  simulation.add({.name = "guest", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
  REQUIRE(simulation.run_until(0.04) == Status::ok);
  recorder.finish("done", {});
  const Rows rows = table(folder / "r/bodies.csv");
  const std::size_t gone = column(rows, "arm/link.x");
  CHECK(rows[1][gone] != "");
  CHECK(rows.back()[gone] == "");
  CHECK(column(rows, "guest.x") == rows[0].size());
  for (const auto& row : rows) CHECK(row.size() == rows[0].size());
  const std::string text = state_json(simulation.world(), {});
  CHECK(text.find("\"arm/link\"") == std::string::npos);
  CHECK(text.find("\"guest\"") != std::string::npos);
}

TEST_CASE("events number bodies by their places in bodies.csv, also where some are missing at the start") {
  const test::TemporaryFolder folder;
  Model model = test::two_mechanisms();
  const BodySpec load{.name = "pendulum/load",
                      .mass = 1,
                      .com = {0, 0, -1},
                      .inertia = diagonal(0.1),
                      .parent = model.body("pendulum"),
                      .at = {0, 0, -2},
                      .joint = Revolute{.axis = {1, 0, 0}}};
  model.add(load);
  Simulation simulation(model, {.step = 0.01});
  simulation.remove(model.body("arm/hand"));
  simulation.at(0.015).then(break_joint("pendulum/load"));
  Recorder recorder(simulation, {}, model_json(simulation.world(), ""),
                    {.directory = folder / "r", .joints = all_joints(simulation)});
  simulation.observe(0, [&](const World& world) { return recorder.observe(world); });
  REQUIRE(simulation.run_until(0.03) == Status::ok);
  recorder.finish("done", {});
  CHECK(read_text_file(folder / "r/events.jsonl").find("\"moved\": {\"pendulum/load\": [[3, 1]]}") != std::string::npos);
  const Recording run = read_recording(folder / "r");
  REQUIRE(run.bodies.size() == 4);
  const std::vector<int>& mechanism = run.phases.back().mechanism;
  CHECK(run.mechanisms[static_cast<std::size_t>(mechanism[2])] == "pendulum");
  CHECK(run.mechanisms[static_cast<std::size_t>(mechanism[3])] == "pendulum/load");
}

}  // namespace
}  // namespace momentree::io
