#include <momentree/results/report/report.hpp>

#include <doctest/doctest.h>

#include <sys/stat.h>
#include <nlohmann/json.hpp>

#include <fstream>

#include <momentree/results/model_json.hpp>
#include <momentree/results/recording/number_table.hpp>
#include <momentree/results/results.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::io {
namespace {

const std::string hostile = "</script><script>alert(1)</script><!--";

/// A run of two_mechanisms with a lock, a change, a break and a weld; rows at every step of 10 ms.
void write_result(const std::string& out) {
  const Model model = test::two_mechanisms();
  Simulation simulation(model, {.step = 0.01});
  simulation.at(0.05).then(lock("arm/wrist"));
  simulation.at(0.07).then(change_joint("arm/wrist", Ball{}));
  simulation.at(0.1).then(break_joint("arm/shoulder"));
  simulation.at(0.2).then(weld("arm/link", "pendulum"));
  RunOrigin origin;
  origin.name = "arm";
  Recorder recorder(simulation, origin, model_json(simulation.world(), hostile),
                    {.directory = out, .joints = joints_of(simulation, simulation.dry_run(), {})});
  simulation.observe(0, [&](const World& world) { return recorder.observe(world); });
  REQUIRE(simulation.run_until(0.3) == Status::ok);
  recorder.finish("done", {});
}

std::vector<std::string> texts(const nlohmann::json& list) {
  std::vector<std::string> all;
  for (const nlohmann::json& item : list) all.push_back(item);
  return all;
}

/// The number of bytes that a base64 text encodes.
std::size_t bytes_of(const std::string& base64) {
  return base64.size() / 4 * 3 - static_cast<std::size_t>(std::count(base64.begin(), base64.end(), '='));
}

TEST_CASE("a report's data: the documents unchanged, tables of the stated size, the units of joint coordinates") {
  const test::TemporaryFolder folder;
  write_result(folder / "r");
  const std::string text = report_data(folder / "r");
  CHECK(text.find('<') == std::string::npos);  // nothing in it can close the enclosing element
  const nlohmann::json data = nlohmann::json::parse(text);
  const auto at = [&](const char* key) -> const nlohmann::json& { return data.at(key); };
  CHECK(at("model").at("title") == hostile);
  CHECK(texts(at("bodies")) == std::vector<std::string>{"arm/base", "arm/link", "arm/hand", "pendulum"});
  const auto rows = at("frames").get<std::size_t>();
  CHECK(rows == 31);
  CHECK(bytes_of(at("time")) == 8 * rows);
  CHECK(bytes_of(at("poses")) == 4 * 7 * 4 * rows);
  CHECK(bytes_of(at("energy").at("rows")) == 8 * rows * at("energy").at("columns").size());
  CHECK(bytes_of(at("joints").at("rows")) == 4 * rows * at("joints").at("columns").size());
  CHECK(at("summary").at("status") == "done");
  CHECK(at("thinned") == false);
  REQUIRE(at("events").size() == 4);
  CHECK(at("events").at(2).at("actions").at(0) == "break arm/shoulder");

  CHECK(at("events").at(2).at("topology").at("gone").at(0) == "arm/shoulder");
  CHECK(texts(at("kinds").at("cylindrical").at("v")) == std::vector<std::string>{"rad/s", "m/s"});
}

TEST_CASE("large tables are thinned evenly, the last row stays; joints are left out where they would cost too many rows") {
  const test::TemporaryFolder folder;
  write_result(folder / "r");
  const auto rows_of = [&](std::size_t most, const char* key) {
    return nlohmann::json::parse(report_data(folder / "r", {.plenty = most, .most_numbers = most})).at(key);
  };
  CHECK(rows_of(1, "frames") == 31);  // there are always about sixty rows
  std::ofstream more(folder / "r/bodies.csv", std::ios::app), joints(folder / "r/joints.csv", std::ios::app),
      energy(folder / "r/energy.csv", std::ios::app);
  const auto last = [&](const char* file) {
    const std::string text = read_text_file(folder / file);
    const std::size_t from = text.rfind('\n', text.size() - 2) + 1;
    return text.substr(text.find(',', from));
  };
  const std::string pose = last("r/bodies.csv"), joint = last("r/joints.csv"), ledger = last("r/energy.csv");
  for (int k = 1; k < 1000; ++k) {
    const std::string time = std::to_string(0.3 + 0.001 * k);
    more << time << pose;
    joints << time << joint;
    energy << time << ledger;
  }
  more.close(), joints.close(), energy.close();
  CHECK(rows_of(3'000'000, "frames") == 1030);
  CHECK(rows_of(3'000'000, "thinned") == false);
  const NumberTable table(folder / "r/bodies.csv");
  const std::size_t width = table.columns().size();
  CHECK(rows_of(100 * width, "frames") == 94 + 1 + 10);  // every eleventh of 1030, the last, and those next to events
  CHECK(rows_of(100 * width, "thinned") == true);
  CHECK(rows_of(100 * width, "joints_left_out") == true);

  // Every second row, the last one, and those next to the events at 0.05, 0.07, 0.1 and 0.2 s: at most 600 rows are needed.
  const nlohmann::json few = nlohmann::json::parse(report_data(folder / "r", {.plenty = 1}));
  CHECK(few.at("frames") == 515 + 1 + 6);
  CHECK(few.at("thinned") == true);
  CHECK(few.at("joints_left_out") == false);
}

TEST_CASE("a long run has 60 rows for each second, up to 3000") {
  const test::TemporaryFolder folder;
  write_result(folder / "r");
  const auto frames_of_run_to = [&](int end) {
    for (const char* file : {"bodies.csv", "joints.csv", "energy.csv"}) {
      const std::string path = folder / "r/" + std::string(file), text = read_text_file(path);
      const std::size_t head = text.find('\n') + 1, row = text.find(',', head);
      std::string lines = text.substr(0, head);
      for (int k = 0; k <= 100 * end; ++k) lines += std::to_string(0.01 * k) + text.substr(row, text.find('\n', row) + 1 - row);
      std::ofstream(path) << lines;
    }
    return nlohmann::json::parse(report_data(folder / "r", {.plenty = 1})).at("frames").get<int>();
  };
  std::filesystem::remove(folder / "r/events.jsonl");
  CHECK(frames_of_run_to(30) == 3000 / 2 + 1);
  CHECK(frames_of_run_to(300) == 30'000 / 11 + 2);
}

TEST_CASE("a run that diverged is shown as far as it has numbers; a damaged file is an error that names it") {
  const test::TemporaryFolder folder;
  write_result(folder / "r");
  std::string text = read_text_file(folder / "r/bodies.csv");
  std::size_t row = 0;
  for (int k = 0; k < 21; ++k) row = text.find('\n', row) + 1;
  const std::size_t cell = text.find(',', row) + 1;
  text.replace(cell, text.find(',', cell) - cell, "nan");
  std::ofstream(folder / "r/bodies.csv") << text;
  const nlohmann::json data = nlohmann::json::parse(report_data(folder / "r"));
  CHECK(data.at("frames") == 20);

  text.replace(text.find("nan"), 3, "1,2");
  std::ofstream(folder / "r/bodies.csv") << text;
  CHECK(test::error_of([&] { report_data(folder / "r"); }).find("bodies.csv:22: error: the row has 30 of 29") !=
        std::string::npos);
  std::filesystem::remove(folder / "r/model.json");
  CHECK(test::error_of([&] { report_data(folder / "r"); }).find("model.json") != std::string::npos);
  CHECK(test::error_of([&] { report_data(folder / "none"); }).find("no such directory") != std::string::npos);
}

TEST_CASE("a report's summary may be given before it is written; only regular files of the folder are read") {
  const test::TemporaryFolder folder;
  write_result(folder / "r");
  CHECK(report_data(folder / "r", {.summary = "{\"status\": \"soon\"}"}).find("\"status\": \"soon\"") != std::string::npos);
  for (const char* name : {"bodies.csv", "joints.csv", "energy.csv", "model.json", "summary.json", "events.jsonl"}) {
    const std::filesystem::path file = std::filesystem::path(folder / "r") / name;
    const auto refused = [&] { return test::error_of([&] { report_data(folder / "r"); }); };
    std::filesystem::rename(file, folder / "kept");
    std::filesystem::create_symlink(folder / "kept", file);
    CHECK_MESSAGE(refused().find("symbolic link") != std::string::npos, name);
    std::filesystem::remove(file);
    REQUIRE(mkfifo(file.c_str(), 0600) == 0);
    CHECK_MESSAGE(refused().find("not a regular file") != std::string::npos, name);  // and it does not block until a writer comes
    std::filesystem::remove(file);
    std::filesystem::rename(folder / "kept", file);
    CHECK(refused() == "");
  }
}

}  // namespace
}  // namespace momentree::io
