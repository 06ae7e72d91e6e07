// Worlds with other models, files that change, worlds in lanes.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/results/result_directory.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/sweep/plan/read_sweep.hpp>
#include <momentree/sweep/scenario_worlds.hpp>
#include <momentree/text/files/text_file.hpp>

using namespace momentree;
using namespace momentree::sweep;
using Folder = io::test::TemporaryFolder;

namespace {

std::string robot(const std::string& first, const std::string& second, double mass) {
  const auto link = [](const std::string& name, double kg) {
    return "<link name=\"" + name + "\"><inertial><origin xyz=\"0 0 -0.5\"/><mass value=\"" + std::to_string(kg) +
           "\"/><inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>";
  };
  const auto joint = [](const std::string& name, const std::string& kind) {
    return "<joint name=\"j" + name + "\" type=\"" + kind + "\"><parent link=\"w\"/><child link=\"" + name +
           "\"/><axis xyz=\"0 1 0\"/></joint>";
  };
  const auto mass_of = [&](const std::string& name) { return name == "b" ? mass : 2; };
  return "<robot name=\"r\"><link name=\"w\"/>" + link(first, mass_of(first)) + link(second, mass_of(second)) +
         joint(first, "continuous") + joint(second, "continuous") + "</robot>";
}

const char* const scenario = R"(format = 1
[[mechanism]]
name = "p"
model = "one.urdf"
[mechanism.joint.jb]
q = [0.4]
[mechanism.joint.jc]
q = [0.9]
[integrate]
step = 0.01
until = 0.5
[output]
every = 0.1
)";

ReadSweep sweep_in(const Folder& folder, const std::string& vary, const std::string& measures) {
  return read_sweep_text("format = 1\nscenario = \"robot.toml\"\n" + vary + "\n[measure]\n" + measures, folder / "s.toml");
}

}  // namespace

TEST_CASE("bodies and joints of other models are found by their names, and files are read once") {
  const Folder folder;
  io::write_text_file(folder / "one.urdf", robot("b", "c", 1));
  io::write_text_file(folder / "two.urdf", robot("c", "b", 1));
  std::string slides = robot("c", "b", 1);
  slides.replace(slides.find("jb\" type=\"continuous"), 20, "jb\" type=\"prismatic_");
  slides.replace(slides.find("prismatic_\">"), 12, "prismatic\"><limit lower=\"-9\" upper=\"9\" effort=\"1\" velocity=\"1\"/>");
  io::write_text_file(folder / "three.urdf", slides);
  io::write_text_file(folder / "robot.toml", scenario);
  const ReadSweep read = sweep_in(folder, "[vary]\n\"mechanism.p.model\" = [\"one.urdf\", \"two.urdf\", \"three.urdf\"]",
                                  "b = { final = \"p/b.qy\" }\nc = { final = \"p/c.qy\" }\njb = { final = \"p/jb.q0\" }\n"
                                  "kinetic = { final = \"kinetic\" }\n");
  CAPTURE(io::rendered(read.diagnostics));
  REQUIRE(read.sweep);
  // From here on the files do not matter.
  io::write_text_file(folder / "one.urdf", robot("b", "c", 5));
  std::filesystem::remove(std::filesystem::path(folder / "two.urdf"));
  const ScenarioWorlds worlds(*read.sweep, std::nullopt);
  const WorldResult one = worlds.run(0), two = worlds.run(1), three = worlds.run(2);
  CAPTURE(one.failure + two.failure + three.failure);
  REQUIRE((one.done() && two.done() && three.done()));
  for (std::size_t i = 0; i < 4; ++i) CHECK(one.measures[i] == doctest::Approx(two.measures[i]).epsilon(1e-12));
  CHECK(std::fabs(one.measures[0] - one.measures[1]) > 0.01);
  CHECK(one.measures[2] == doctest::Approx(two.measures[2]).epsilon(1e-12));
  CHECK(std::isnan(three.measures[2]));  // a joint that slides has no angle
}

TEST_CASE("two keys of the same value are refused, however they name it") {
  const Folder folder;
  io::write_text_file(folder / "one.urdf", robot("b", "c", 1));
  io::write_text_file(folder / "robot.toml", scenario);
  const auto said = [&](const std::string& one, const std::string& other) {
    return io::rendered(sweep_in(folder,
                                 "worlds = 3\n[vary]\n\"" + one +
                                     "\" = " + (one.ends_with("q") ? "{ uniform = [[0.1], 0.2] }" : "{ uniform = [0.1, 0.2] }") +
                                     "\n\"" + other + "\" = { uniform = [0.1, 0.2] }",
                                 "b = { final = \"p/b.qy\" }\n")
                            .diagnostics);
  };
  CHECK(said("mechanism.p.joint.jb.q", "mechanism.0.joint.jb.q.0").find("vary the same value") != std::string::npos);
  CHECK(said("mechanism.#1.joint.jb.q.0", "mechanism.p.joint.jb.q.0").find("vary the same value") != std::string::npos);
  CHECK(said("mechanism.p.joint.jb.q.0", "mechanism.p.joint.jc.q.0").empty());
  CHECK(said("mechanism.p.joint.jb.q.0", "mechanism.p.joint.jb.damping").empty());
}

TEST_CASE("worlds in lanes have the bits of whole simulations") {
  const Folder folder;
  io::write_text_file(folder / "one.urdf", robot("b", "c", 1));
  io::write_text_file(folder / "two.urdf", robot("c", "b", 3));
  io::write_text_file(folder / "robot.toml", std::string(scenario) + "[[event]]\nname = \"off\"\nat = 0.2\nbreak = \"p/jb\"\n");
  const ReadSweep read =
      sweep_in(folder,
               "worlds = 40\n[vary]\n\"mechanism.p.joint.jb.q.0\" = { uniform = [0, 1] }\n"
               "\"event.off.at\" = { uniform = [0.05, 0.6] }\n"
               "\"mechanism.p.model\" = { list = [\"one.urdf\", \"two.urdf\"], weights = [3, 1] }\n",
               "x = { final = \"p/b.x\" }\nv = { column = \"p/jc.v0\", at = 0.33 }\nt = { time_of = \"off\" }\n"
               "e = { max = \"kinetic\" }\nlost = { event = \"off\", value = \"before.kinetic\" }\n");
  CAPTURE(io::rendered(read.diagnostics));
  REQUIRE(read.sweep);
  const Lanes lanes = lanes_for(*read.sweep, lanes_of("auto"));
  REQUIRE(lanes);
  const ScenarioWorlds alone(*read.sweep, std::nullopt), together(*read.sweep, lanes);
  CHECK(together.at_once() >= 2);
  std::vector<std::uint64_t> all;
  for (std::uint64_t world = 0; world < 40; ++world) all.push_back(39 - world);
  std::vector<WorldResult> results(40);
  REQUIRE(together.run(all, [&](std::size_t place, WorldResult result) { results[place] = std::move(result); }));
  for (std::size_t i = 0; i < 40; ++i) {
    const WorldResult expected = alone.run(all[i]), again = together.run(all[i]);
    REQUIRE((expected.done() && results[i].done()));
    for (std::size_t m = 0; m < expected.measures.size(); ++m) {
      CHECK(std::isnan(expected.measures[m]) == std::isnan(results[i].measures[m]));
      if (std::isnan(expected.measures[m])) continue;
      CHECK(results[i].measures[m] == expected.measures[m]);
      CHECK(results[i].measures[m] == again.measures[m]);
    }
  }
  // With a loop, lanes are used if worlds share them: not if each has a damper of its own.
  io::write_text_file(folder / "robot.toml",
                      std::string(scenario) +
                          "[[loop]]\nname = \"pin\"\nkind = \"ball\"\nbody = \"p/b\"\nto = \"ground\"\n"
                          "assemble = true\nat = { xyz = [0, 0, 0] }\n[[event]]\nname = \"off\"\nat = 0.2\nbreak = \"pin\"\n");
  const auto lanes_of_loops = [&](const std::string& varied) {
    const ReadSweep loops = sweep_in(folder, "worlds = 20\n[vary]\n" + varied, "x = { final = \"p/b.x\" }\n");
    CAPTURE(io::rendered(loops.diagnostics));
    REQUIRE(loops.sweep);
    return lanes_for(*loops.sweep, lanes_of("auto"));
  };
  CHECK(lanes_of_loops("\"event.off.at\" = { uniform = [0.05, 0.6] }\n"));
  CHECK_FALSE(lanes_of_loops("\"mechanism.p.joint.jb.damping\" = { uniform = [0, 1] }\n"));

  const ReadSweep ledger =
      sweep_in(folder, "worlds = 4\n[vary]\n\"event.off.at\" = { uniform = [0.05, 0.6] }\n", "w = { final = \"error\" }\n");
  REQUIRE(ledger.sweep);
  CHECK_FALSE(lanes_for(*ledger.sweep, lanes_of("auto")));
  CHECK_FALSE(lanes_of("none"));
  CHECK_THROWS_AS((void)lanes_of("sse"), Error);
}

TEST_CASE("an instant at which [stop] ends the world is measured") {
  const Folder folder;
  io::write_text_file(folder / "one.urdf", robot("b", "c", 1));
  io::write_text_file(folder / "robot.toml", std::string(scenario) + "[[event]]\nname = \"off\"\nat = 0.2\nbreak = \"p/jb\"\n");
  const ReadSweep read = sweep_in(folder, "worlds = 1\n[vary]\n\"mechanism.p.joint.jc.q.0\" = [0.5]\n",
                                  "at = { column = \"p/c.qy\", at = 0.2 }\nend = { final = \"p/c.qy\" }\n"
                                  "later = { column = \"p/c.qy\", at = 0.21 }\n[stop]\nafter = \"off\"\n");
  CAPTURE(io::rendered(read.diagnostics));
  REQUIRE(read.sweep);
  const WorldResult result = ScenarioWorlds(*read.sweep, std::nullopt).run(0);
  CAPTURE(result.failure);
  REQUIRE(result.done());
  CHECK(result.measures[0] == result.measures[1]);
  CHECK(std::isnan(result.measures[2]));
}

TEST_CASE("a run does not remove the journal of a sweep") {
  const Folder folder;
  const std::string out = folder / "out";
  {
    io::ResultDirectory sweep(out, {}, true, io::ResultDirectory::Earlier::kept);
    sweep.write(io::journal_file, "worlds");
    sweep.keep();
  }
  CHECK_THROWS_AS(io::ResultDirectory{out}, Error);
  CHECK(io::read_text_file(out + ".partial/" + io::journal_file) == "worlds");
}
