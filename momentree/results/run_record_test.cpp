#include <momentree/results/run_record.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <doctest/doctest.h>

#include <momentree/momentree.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/session.hpp>

using namespace momentree;

namespace {

namespace fs = std::filesystem;

const std::string capture = std::string(MOMENTREE_SOURCE_DIR) + "/scenarios/capture.toml";

struct Recorded {
  io::Session session = io::load(capture, {.overrides = {"integrate.until=12", "output.every=0.1"}});
  std::vector<double> kinetic;
  std::vector<Vec3> gripper;
  io::RunRecord record{session.simulation(), {}, io::model_json(session.simulation().world(), ""), true};

  explicit Recorded(const std::string& folder = {}) {
    Simulation& sim = session.simulation();
    std::optional<io::Recorder> files;
    if (!folder.empty())
      files.emplace(sim, io::RunOrigin{}, io::model_json(sim.world(), ""),
                    io::RecordOptions{.directory = folder, .joints = session.joints(), .every = 0.1});
    sim.observe(0.1, [&](const World& world) {
      record.observe(sim);
      if (record.rows() > kinetic.size()) kinetic.emplace_back(), gripper.emplace_back();
      kinetic.back() = world.totals().kinetic;
      gripper.back() = world.motions()[1].pose.position;
      return !files || files->observe(world);
    });
    REQUIRE(session.run());
    sim.observe(0, {});
    if (files) files->finish("done", session.armed());
    record.finish(sim, "done", session.armed());
  }
};

std::string content(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("columns of a record are what was live, across changes of the topology") {
  const Recorded run;
  const io::RunRecord& record = run.record;
  REQUIRE(record.rows() == run.kinetic.size());
  REQUIRE(record.events().size() >= 1);
  const std::vector<double> energies = record.energies(), body = record.body({1});
  for (std::size_t row = 0; row < record.rows(); ++row) {
    CHECK(energies[14 * row] == run.kinetic[row]);
    CHECK(body[13 * row] == run.gripper[row].x);
    CHECK(body[13 * row + 2] == run.gripper[row].z);
  }
  CHECK(record.status() == "done");
  CHECK(record.times().back() == 12);
}

TEST_CASE("a joint that appears or changes its kind has rows for that time alone") {
  const Recorded run;
  const std::vector<std::string> names = run.record.joints();
  bool partial = false;
  for (const std::string& name : names) {
    const io::JointRows rows = run.record.joint(name);
    CHECK(rows.q.size() == run.record.rows() * rows.nq);
    CHECK(rows.wrench.size() == run.record.rows() * 6);
    for (std::size_t row = 0; row < run.record.rows() && rows.nq > 0; ++row)
      partial = partial || std::isnan(rows.q[row * rows.nq]);
  }
  CHECK(partial);
  CHECK_THROWS_WITH_AS((void)run.record.joint(names[0] + "x"), doctest::Contains("did you mean"), Error);
}

TEST_CASE("a simulation goes on from any row as it did") {
  Recorded run;
  Simulation& sim = run.session.simulation();
  SimulationSnapshot end = sim.snapshot();
  const std::vector<double> last(sim.world().state().q().begin(), sim.world().state().q().end());
  end.world = run.record.state(run.record.rows() - 1);
  sim.restore(end);
  const Numbers q = sim.world().state().q();
  CHECK(std::vector<double>(q.begin(), q.end()) == last);
}

TEST_CASE("the files of a record are those that a recorder writes during the run") {
  const fs::path folder = fs::temp_directory_path() / "momentree_run_record_test";
  fs::remove_all(folder);
  const Recorded run((folder / "live").string());
  CHECK(run.record.write((folder / "kept").string(), {}) == (folder / "kept").string());
  for (const char* name : {"bodies.csv", "energy.csv", "events.jsonl", "final.json", "model.json"}) {
    CAPTURE(name);
    CHECK(content(folder / "kept" / name) == content(folder / "live" / name));
    CHECK(content(folder / "kept" / name).size() > 10);
  }
  fs::remove_all(folder);
}
