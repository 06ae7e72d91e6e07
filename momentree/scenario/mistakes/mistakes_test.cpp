// Mistakes of users of other engines, and the messages that they get.
#include <doctest/doctest.h>

#include <sstream>

#include <momentree/base/edit_distance.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/scenario/mistakes/mistakes.hpp>
#include <tests/bad_input.hpp>

namespace momentree::io {
namespace {

using namespace bad_input;

/// The hints of the diagnostics for a text, one per line.
std::string hints(const std::string& text) {
  std::string all;
  for (const Diagnostic& each : read_scenario_text(text, "s.toml").diagnostics) all += (all.empty() ? "" : "\n") + each.hint;
  return all;
}

std::string in_joint(const std::string& line) { return pinned + line + "\n"; }
std::string in_body(const std::string& line) { return head + "[[mechanism.body]]\nname = \"a\"\nmass = 1\n" + line + "\n"; }
std::string in_event(const std::string& lines) { return pinned + "[[event]]\n" + lines + "\n"; }

struct Told {
  std::string text, hint;
};

void check_told(const std::vector<Told>& all) {
  for (const Told& each : all) {
    CAPTURE(each.text);
    CHECK(hints(each.text) == each.hint);
  }
}

std::vector<std::string> parts(const char* text, char separator) {
  std::istringstream stream(text);
  std::vector<std::string> all;
  for (std::string part; std::getline(stream, part, separator);) all.push_back(part);
  if (all.empty()) all.emplace_back();
  return all;
}

}  // namespace

TEST_CASE("keys of other engines are reported once, with the right key") {
  check_told({
      {one_body + "[mechanism.body.joint]\ntype = \"revolute\"\n", "write 'kind', as in kind = \"revolute\""},
      {one_body + "[mechanism.body.joint]\ntype = \"hinge\"\n",
       "write 'kind', as in kind = \"revolute\"\nwrite kind = \"revolute\""},
      {pinned + "[integrate]\ndt = 0.001\n", "write 'step', as in step = \"1 ms\""},
      {pinned + "[integrate]\ntimeStep = 0.001\n", "write 'step', as in step = \"1 ms\""},
      {pinned + "[integrate]\nend = 5\n", "write 'until', as in until = \"3 s\""},
      {pinned + "[integrate]\nstop-time = 5\n", "write 'until', as in until = \"3 s\""},
      {pinned + "[simulation]\nstep = 0.001\n", "write 'integrate', as in [integrate]"},
      {in_event("time = 0.6\nbreak = \"m/a\""), "write 'at', as in at = \"1.8 s\""},
      {in_event("at = 1\nremove = \"m/a\""), "write 'break', as in break = \"arm/elbow\""},
      {in_event("delay = 1\nbreak = \"m/a\""),
       "for example at = \"1.8 s\", or when = { reaction_force = \"crane/hook\", exceeds = \"4 kN\" }\n"
       "write after = { event = \"grasp\", delay = \"0.5 s\" }"},
      {in_event("when = { reaction_force = \"m/a\", above = 3 }\nbreak = \"m/a\""), "write 'exceeds', as in exceeds = \"4 kN\""},
      {in_event("when = { force = \"m/a\", exceeds = 3 }\nbreak = \"m/a\""),
       "write 'reaction_force', as in reaction_force = \"arm/elbow\""},
      {in_event("when = { angle = \"m/a\", exceeds = 3 }\nbreak = \"m/a\""), "write 'position', as in position = \"arm/elbow\""},
      {in_joint("k = 3"), "write 'stiffness', as in stiffness = \"3 N m\""},
      {in_joint("frictionloss = 3"), "write 'friction', as in friction = { coulomb = \"2 N m\", speed = \"0.01 rad/s\" }"},
      {in_joint("torque = 3"), "a joint is driven by drive = { effort = \"5 N m\" }, or { pd = … }, or { motion = … }"},
      {in_joint("origin = [0, 0, 1]"), "write 'at', as in at = { xyz = [0.5, 0, 0] }"},
      {in_joint("at = { pos = [0, 0, 1] }"), "write 'xyz', as in xyz = [0, 0, 1]"},
      {in_joint("drive = { pd = { p = 1, d = 1 } }"), "write 'kp', as in kp = 100\nwrite 'kd', as in kd = 10"},
      {in_body("center_of_mass = [0, 0, 1]"), "write 'com', as in com = [0.25, 0, 0]"},
      {in_body("pos = [0, 0, 1]"), "a body is placed by its joint: at = { xyz = [0, 0, 1] } in [mechanism.body.joint]"},
      {head + "urdf = \"x.urdf\"\n", "write 'model', as in model = \"robot.urdf\"\nread it from its file"},
      {one_body + "[output]\nfps = 30\n", "give the time between rows: every = \"10 ms\" is 100 rows a second"},
  });
}

TEST_CASE("unsupported names are neither suggested nor unknown") {
  CHECK(said(read_scenario_text("foo = 3\n" + pinned, "s.toml")) ==
        "s.toml:1:1: error: unknown key 'foo' in a scenario; known here: format title world state mechanism force loop spring "
        "cable coupling contact event "
        "integrate output");
  for (const char* table : {"[vary]", "[measure]"}) {
    const std::string text = said(read_scenario_text(pinned + table + "\nname = \"x\"\n", "s.toml"));
    CHECK_MESSAGE(text.find("is not supported yet") != std::string::npos, text);
  }
}

TEST_CASE("kinds, methods and roots of other engines") {
  const auto kind = [](const char* name) { return hints(one_body + "[mechanism.body.joint]\nkind = \"" + name + "\"\n"); };
  CHECK(kind("hinge") == "write kind = \"revolute\"");
  CHECK(kind("Hinge Joint") == "write kind = \"revolute\"");
  CHECK(kind("fixed") == "write kind = \"weld\"");
  CHECK(kind("slide") == "write kind = \"prismatic\"");
  CHECK(kind("floating") == "write kind = \"free\"");
  CHECK(kind("spherical") == "write kind = \"ball\"");
  CHECK(kind("RevoluteJoint") == "write kind = \"revolute\"");
  const auto method = [](const char* name) { return hints(pinned + "[integrate]\nmethod = \"" + name + "\"\n"); };
  CHECK(method("rk45") == "write method = \"dopri5\", the Runge-Kutta method of Dormand and Prince that chooses its steps");
  CHECK(method("ode15s") == "write method = \"damped\", which takes dampers and servos implicitly, or \"dopri5\"");
  CHECK(method("semi-implicit") == "write method = \"midpoint\", which is symplectic");
  CHECK(method("RK4") == "write method = \"rk4\", the classic Runge-Kutta method of order 4");
  CHECK(hints(head + "root = \"floating\"\n" + one_body.substr(head.size())) == "write root = \"free\"");
  CHECK(hints(pinned + "parent = \"world\"\n") == "write parent = \"ground\"");
}

TEST_CASE("values of the wrong shape are reported with the right one") {
  check_told({
      {pinned + "[world]\ngravity = 9.81\n", "write gravity = [0, 0, -9.81]"},
      {pinned + "[world]\ngravity = \"9.81 m/s^2\"\n", "write gravity = [0, 0, \"-9.81 m/s^2\"]"},
      {pinned + "[world]\ngravity = [0, -9.81]\n", "write x, y and z, as in gravity = [0, -9.81, 0]"},
      {in_joint("limits = [-1, 1]"), "write limits = { lower = -1, upper = 1 }"},
      {in_joint("limits = [\"-90 deg\", \"90 deg\"]"), "write limits = { lower = \"-90 deg\", upper = \"90 deg\" }"},
      {in_joint("limits = 1"), "write limits = { lower = -1, upper = 1 }"},
      {in_joint("axis = \"-y\""), "write axis = [0, -1, 0]"},
      {in_joint("axis = \"0 0 1\""), "write axis = [0, 0, 1]"},
      {in_joint("axis = { x = 0, y = 0, z = 1 }"), "write axis = [0, 0, 1]"},
      {in_joint("at = [0, 0, 1]"), "write at = { xyz = [0, 0, 1] }"},
      {in_joint("at = [0, 0, 1, 0, 0, 1.5]"), "write at = { xyz = [0, 0, 1], rpy = [0, 0, 1.5] }"},
      {in_joint("friction = 0.1"), "write friction = { coulomb = 0.1, speed = 0.01 }"},
      {in_joint("drive = 5"), "write drive = { effort = 5 }"},
      {in_joint("position = [0, 0, 1]"), "a joint is placed by its `at`; write at = { xyz = [0, 0, 1] }"},
      {in_body("inertia = [[1, 0, 0], [0, 2, 0], [0, 0, 3]]"),
       "write inertia = [1, 2, 3]: xx, yy, zz; with products of inertia 6 numbers, xx, yy, zz, xy, xz, yz"},
      {in_body("inertia = [[0.123456789012345, 0.0123456789012345, 0], [0.0123456789012345, 0.123456789012345, "
               "0.00123456789012345], [0, 0.00123456789012345, 0.123456789012345]]"),
       "write its 6 numbers xx, yy, zz, xy, xz, yz in one list"},
      {in_body("inertia = [[1, 0.1, 0], [0.1, 2, 0], [0, 0, 3]]"),
       "write inertia = [1, 2, 3, 0.1, 0, 0]: xx, yy, zz, xy, xz, yz"},
      {in_body("inertia = [[1, 0.1, 0], [0.2, 2, 0], [0, 0, 3]]"), "an inertia is symmetric: 6 numbers, xx, yy, zz, xy, xz, yz"},
      {in_body("inertia = { ixx = 1, iyy = 2, izz = 3, ixy = 0.1, ixz = 0, iyz = 0 }"),
       "write inertia = [1, 2, 3, 0.1, 0, 0]: xx, yy, zz, xy, xz, yz"},
      {in_body("inertia = [1, 1]"), "1 number for all, 3 for xx, yy, zz, or 6 for xx, yy, zz, xy, xz, yz"},
      {head + "[[mechanism.body]]\nname = \"a\"\nmass = \"2\"\n", "write 2 without quotes, or \"2 kg\""},
      {in_event("after = \"2 s\"\nbreak = \"m/a\""),
       "write after = { event = \"grasp\", delay = \"0.5 s\" }, or an instant: at = \"0.5 s\""},
      {in_event("at = \"end\"\nbreak = \"m/a\""), "expected a time (s), for example 2, or \"2 s\""},
      {in_event("when = { reaction = \"m/a\", exceeds = 1 }\nbreak = \"m/a\""),
       "write reaction = { joint = …, component = \"fx\" }, or reaction_force for the norm"},
  });
}

TEST_CASE("an angle of more than a turn without a unit is a warning, wherever it is") {
  const std::string cure = "write \"90 deg\" for degrees, or \"90 rad\" if that is what you mean";
  for (const char* line : {"angle = 90", "q = 90", "limits = { upper = 90 }", "stiffness = 1\nrest = 90",
                           "at = { rpy = [0, 0, 90] }", "drive = { pd = { kp = 1, target = 90 } }"}) {
    const ReadResult result = read_scenario_text(in_joint(line), "s.toml");
    CAPTURE(line);
    CHECK(result.scenario);
    REQUIRE(result.diagnostics.size() == 1);
    CHECK(result.diagnostics[0].severity == Severity::warning);
    CHECK(result.diagnostics[0].what.find(": 90 is read as radians, 14.3 turns") != std::string::npos);
    CHECK(result.diagnostics[0].hint == cure);
  }
  CHECK(hints(in_event("when = { position = \"m/a\", exceeds = 90 }\nbreak = \"m/a\"")) == cure);
  for (const char* line :
       {"angle = 3", "angle = \"90 rad\"", "angle = 6.2832", "drive = { motion = { table = [[0, 0], [1, 90]] } }"})
    CHECK_MESSAGE(hints(in_joint(line)) == "", line);
}

TEST_CASE("the tables of mistakes are sound") {
  for (const Mistake* mistake : all_mistakes()) {
    CAPTURE(mistake->words);
    const std::string key = mistake->key, text = mistake->text;
    for (const std::string& word : parts(mistake->words, ' ')) {
      CAPTURE(word);
      CHECK(plain_word(word) == word);
      CHECK(plain_word(key) != word);
      for (const std::string& where : parts(mistake->where, '|')) {
        CAPTURE(where);
        std::size_t same = 0;
        for (const Mistake* other : mistakes_of(where, word)) same += (*other->where == '\0') == where.empty();
        CHECK(same == 1);
      }
    }
    if (key.empty())
      CHECK(!text.empty());
    else  // an example of that key
      CHECK((text.starts_with(key + " = ") || text.starts_with("{ " + key + " = ") || text.find(key) < text.find(']')));
  }
  for (const char* kind : {"hinge", "slide", "fixed", "floating", "spherical", "screw", "cardan", "cylinder", "plane"}) {
    const std::string cure = cure_of_kind(kind);
    CHECK_MESSAGE(find_kind(cure.substr(14, cure.find('"', 14) - 14)) != nullptr, cure);
  }
  for (const char* method : {"rk45", "ode113", "euler", "verlet", "bdf"}) {
    const std::string cure = cure_of_method(method);
    bool known = false;
    for (const std::string& name : integration_methods())
      known = known || cure.find("method = \"" + name + "\"") != std::string::npos;
    CHECK_MESSAGE(known, cure);
  }
}

}  // namespace momentree::io
