// mimic = { … } of a mechanism, for model files in which joints follow others indirectly, in cycles, or not at all.
#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/bad_input.hpp>

namespace momentree::io {
namespace {

using namespace bad_input;

/// A joint of a URDF file with the link that it carries; `more`: further elements in it.
std::string joint(const std::string& name, const std::string& kind, const std::string& more) {
  return "<link name='of_" + name +
         "'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>\n"
         "<joint name='" +
         name + "' type='" + kind + "'><parent link='base'/><child link='of_" + name + "'/><axis xyz='0 0 1'/>" + more +
         "</joint>\n";
}
std::string follows(const std::string& leader, const std::string& more = "") {
  return "<mimic joint='" + leader + "'" + more + "/>";
}

ReadResult read(const std::string& joints, const std::string& more = "", const std::string& mimic = "{ stiffness = 100 }") {
  const test::TemporaryFolder folder;
  write_text_file(folder / "r.urdf", "<robot name='r'><link name='base'/>\n" + joints + "</robot>");
  write_text_file(folder / "s.toml",
                  "format = 1\n[[mechanism]]\nname = \"r\"\nmodel = \"r.urdf\"\nmimic = " + mimic + "\n" + more);
  return read_scenario(folder / "s.toml");
}

}  // namespace

TEST_CASE("followers of followers start where they should, in whatever order the file has them") {
  const auto start = [](const ReadResult& result, const std::string& name) {
    const Model& model = result.scenario->model;
    return model[model.joint("r/" + name)].q[0];
  };
  const std::string a = joint("a", "continuous", ""), b = joint("b", "continuous", follows("a", " multiplier='2' offset='0.5'")),
                    c = joint("c", "continuous", follows("b", " multiplier='-1'")), d = joint("d", "continuous", follows("c"));
  std::vector<std::string> order = {a, b, c, d};
  std::sort(order.begin(), order.end());
  do {
    const ReadResult result = read(order[0] + order[1] + order[2] + order[3], "state = { joints = { a = 0.25 } }\n");
    CAPTURE(said(result));
    REQUIRE(result.scenario);
    CHECK(said(result).empty());
    REQUIRE(result.scenario->model.elements().size() == 3);
    CHECK(start(result, "b") == 1);
    CHECK(start(result, "c") == -1);
    CHECK(start(result, "d") == -1);
  } while (std::next_permutation(order.begin(), order.end()));
  // Values of the scenario take precedence, and followers are computed from them.
  const ReadResult result = read(a + b + c + d, "state = { joints = { c = 3 } }\n");
  REQUIRE(result.scenario);
  CHECK(start(result, "b") == 0.5);
  CHECK(start(result, "c") == 3);
  CHECK(start(result, "d") == 3);
  CHECK(said(result).find("joint 'r/c' starts 3.5 rad from where it should follow 'r/b'") != std::string::npos);
}

TEST_CASE("joints that follow exactly have no start values of their own") {
  const std::string limits = "<limit lower='0.5' upper='1' effort='1' velocity='1'/>";
  const std::string joints =
      joint("a", "continuous", "") + joint("b", "revolute", limits + follows("a", " multiplier='2' offset='0.3'"));
  const auto says = [&](const std::string& more) { return said(read(joints, "limits = true\n" + more, "\"exact\"")); };
  // Another coupling puts the leader elsewhere than at its zero.
  const std::string held = "[[coupling]]\njoint = \"r/a\"\noffset = ";
  const ReadResult result = read(joints, "limits = true\n" + held + "0.2\n", "\"exact\"");
  CHECK(said(result).empty());
  REQUIRE(result.scenario);
  const World world(result.scenario->model);
  CHECK(world.joint(world.model().joint("r/b")).q[0] == doctest::Approx(0.7).epsilon(1e-14));
  CHECK(says(held + "0.4\n").find("error: joint 'r/b': it starts beyond its limits, at 1.1") != std::string::npos);
  CHECK(says("").find("error: joint 'r/b': it starts beyond its limits, at 0.3") != std::string::npos);
  CHECK(says("state = { joints = { a = 0.3 } }\n").empty());
}

TEST_CASE("ten thousand joints may follow one another") {
  std::string joints = joint("j0", "continuous", "");
  for (int i = 10'000; i > 0; --i)
    joints += joint("j" + std::to_string(i), "continuous", follows("j" + std::to_string(i - 1), " offset='1'"));
  const ReadResult result = read(joints);
  REQUIRE(result.scenario);
  const Model& model = result.scenario->model;
  CHECK(model[model.joint("r/j10000")].q[0] == 10'000);
  Simulation run(model, result.scenario->integration);
  double most = 0;  // if all joints start where they should, no spring acts
  for (int j = 0; j < model.size(); ++j)
    for (const double rate : run.world().joint({j}).pdot) most = std::max(most, std::abs(rate));
  CHECK(most == 0);
}

TEST_CASE("joints that cannot follow are reported where mimic is requested") {
  const auto refused = [](const std::string& joints, const std::string& message) {
    const ReadResult result = read(joints);
    CHECK(!result.scenario);
    CHECK_MESSAGE(said(result).find("s.toml:5:9: error: mimic: joint " + message) != std::string::npos, said(result));
  };
  const std::string a = joint("a", "continuous", "");
  refused(a + joint("b", "fixed", follows("a")), "'b' does not have one degree of freedom");
  refused(a + joint("b", "floating", follows("a")), "'b' does not have one degree of freedom");
  refused(joint("b", "fixed", "") + joint("a", "continuous", follows("b")),
          "'b' does not have one degree of freedom, but joint 'a' follows it (");
}

TEST_CASE("URDF: joints that follow each other in a cycle are refused, with the cycle") {
  const std::string head_line = "<robot name='r'>\n<link name='base'/>\n";
  const auto refused = [&](const std::string& joints, const std::string& message) {
    const ReadResult result = read_scenario_text(head_line + joints + "</robot>", "r.urdf");
    CHECK(!result.scenario);
    CHECK_MESSAGE(said(result).find(message + "; one of them must lead and follow no other") != std::string::npos, said(result));
  };
  const auto turning = [](const std::string& name, const std::string& leader) {
    return joint(name, "continuous", follows(leader));
  };
  refused(turning("a", "b") + turning("b", "a"), "r.urdf:4:95: error: mimic: joint 'a' follows 'b', which follows 'a'");
  refused(turning("a", "a"), "r.urdf:4:95: error: mimic: joint 'a' follows itself");
  std::string circle = turning("x", "j0");  // joints that lead into a cycle are not part of it
  for (int i = 0; i < 3; ++i) circle += turning("j" + std::to_string(i), "j" + std::to_string((i + 1) % 3));
  refused(circle, "r.urdf:6:97: error: mimic: joint 'j0' follows 'j1', which follows 'j2', which follows 'j0'");
  std::string long_circle;
  for (int i = 0; i < 100; ++i) long_circle += turning("j" + std::to_string(i), "j" + std::to_string((i + 1) % 100));
  refused(long_circle,
          "mimic: joint 'j0' follows 'j1', which follows 'j2', which follows 'j3', …, which follows 'j99', which follows 'j0'");
}

TEST_CASE("SDF: joints that follow each other in a cycle are refused, with the cycle") {
  const auto turning = [](const std::string& name, const std::string& leader) {
    return "<link name='of_" + name + "'/><joint name='" + name + "' type='revolute'><parent>base</parent><child>of_" + name +
           "</child><axis><xyz>0 0 1</xyz>\n<mimic joint='" + leader + "'><multiplier>1</multiplier></mimic></axis></joint>\n";
  };
  const auto refused = [](const std::string& joints, const std::string& message) {
    const ReadResult result = read_scenario_text(
        "<sdf version='1.11'><model name='r'><static>0</static><link name='base'/>\n" + joints + "</model></sdf>", "r.sdf");
    CHECK(!result.scenario);
    CHECK_MESSAGE(said(result).find(message) != std::string::npos, said(result));
  };
  refused(turning("a", "b") + turning("b", "a"), "r.sdf:3:1: error: mimic: joint 'a' follows 'b', which follows 'a'");
  refused(turning("a", "a"), "r.sdf:3:1: error: mimic: joint 'a' follows itself");
}

}  // namespace momentree::io
