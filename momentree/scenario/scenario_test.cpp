#include <cmath>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

#include <momentree/scenario/scenario.hpp>
#include <tests/bad_input.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::bad_input;

namespace {

Scenario read(const std::string& text, const std::vector<std::string>& overrides = {}) {
  ReadResult result = read_scenario_text(text, "folder/s.toml", overrides);
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return std::move(*result.scenario);
}

const char* const breaking_chain = R"(# breaking_chain.toml: the example of Naudet & Lefeber (2005), section 4.2
format = 1
title  = "Breaking chain"

[world]
gravity = [0, -9.81, 0]              # default [0, 0, -9.81]

[[mechanism]]
name  = "chain"
[mechanism.chain]                     # a generator
links        = 100
length       = "5 cm"
mass         = "10 g"
inertia      = "20.83 g cm^2"
axis         = [0, 0, 1]
damping      = "1e-5 N m s"
angle        = "0.001 rad"
angle_growth = true

[[event]]
at    = "1.8 s"
break = "chain/41"

[integrate]
method = "rk4"
step   = "1 ms"
until  = "3 s"

[output]
every = "20 ms"
)";

}  // namespace

TEST_CASE("the breaking chain") {
  const Scenario s = read(breaking_chain);
  CHECK(s.name == "s");
  CHECK(s.title == "Breaking chain");
  CHECK(s.model.gravity() == Vec3{0, -9.81, 0});
  REQUIRE(s.model.size() == 100);
  for (int k = 1; k <= 100; ++k) {
    const BodySpec& link = s.model[BodyId{k - 1}];
    CHECK(link.name == "chain/" + std::to_string(k));
    CHECK(link.joint_name == link.name);
    CHECK(link.parent.index == k - 2);
    CHECK(link.at.position == Vec3{k == 1 ? 0.0 : 0.05, 0, 0});
    CHECK(link.com == Vec3{0.025, 0, 0});
    CHECK(link.mass == 0.01);
    CHECK(link.inertia.yy == 20.83e-7);
    CHECK(link.joint.parameters.damping == Values{1e-5});
    CHECK(link.q == Values{k * 0.001});
  }
  REQUIRE(s.events.size() == 1);
  CHECK(s.events[0].name == "#1");
  CHECK(s.events[0].time == 1.8);
  CHECK(s.events[0].actions.at(0)->key() == "break");
  CHECK(s.events[0].actions.at(0)->joints() == std::vector<std::string>{"chain/41"});
  CHECK(s.integration.method == "rk4");
  CHECK(s.integration.step == 0.001);
  CHECK(s.until == 3);
  CHECK(s.output_every == 0.02);
  CHECK(s.hash.size() == 16);
  CHECK(s.hash == read(breaking_chain).hash);
  CHECK(s.hash != read(breaking_chain, {"integrate.step=1e-3"}).hash);
}

TEST_CASE("a byte order mark and CRLF change nothing") {
  std::string text = "\xEF\xBB\xBF";
  for (const char* c = breaking_chain; *c; ++c) text += *c == '\n' ? std::string("\r\n") : std::string(1, *c);
  CHECK(read(text).model.size() == 100);
  text += "colour = 1\r\n";
  const ReadResult result = read_scenario_text(text, "s.toml");
  REQUIRE(result.diagnostics.size() == 1);
  CHECK(result.diagnostics[0].rendered() ==
        "s.toml:31:1: error: unknown key 'colour' in [output]; known here: every\n   31 | colour = 1\n      | ^\n");
}

TEST_CASE("a free chain has no first revolute joint, and is placed at its pose") {
  const Scenario s = read(head + "root = \"free\"\npose = { xyz = [1, 2, 3], rpy = [0, 0, \"90 deg\"] }\n" +
                          "state = { joints = { \"2\" = \"30 deg\", \"3\" = { speed = 2 } }, velocity = { linear = [1, 2, 3], "
                          "angular = [4, 5, 6] } }\n" +
                          "[mechanism.chain]\nlinks = 3\nlength = 2\nmass = 1\ninertia = 1\nangle = 0.5\n");
  const BodySpec &first = s.model[BodyId{0}], &second = s.model[BodyId{1}], &third = s.model[BodyId{2}];
  CHECK(first.joint.kind == Kind::free);
  CHECK(first.q[0] == 1);
  CHECK(first.q[3] == doctest::Approx(std::sqrt(0.5)));
  CHECK(first.q[6] == doctest::Approx(std::sqrt(0.5)));
  CHECK(first.v == Values{1, 2, 3, 4, 5, 6});
  CHECK(second.joint.kind == Kind::revolute);
  CHECK(second.q[0] == doctest::Approx(std::acos(-1) / 6));
  CHECK(third.q == Values{0.5});
  CHECK(third.v == Values{2});
}

TEST_CASE("bodies are in any order in the file; the model has parents first") {
  const std::string body = "[[mechanism.body]]\nmass = 1\ninertia = 1\n", joint = "[mechanism.body.joint]\nkind = \"revolute\"\n";
  const Scenario s = read(head + body + "name = \"c\"\n" + joint + "parent = \"b\"\n" + body + "name = \"a\"\n" + body +
                          "name = \"b\"\n" + joint + "parent = \"m/a\"\nname = \"hinge\"\n");
  REQUIRE(s.model.size() == 3);
  CHECK(s.model[BodyId{0}].name == "m/a");
  CHECK(s.model[BodyId{0}].joint.kind == Kind::weld);
  CHECK(s.model[BodyId{1}].name == "m/b");
  CHECK(s.model[BodyId{1}].joint_name == "m/hinge");
  CHECK(s.model[BodyId{2}].name == "m/c");
  CHECK(s.model[BodyId{2}].parent == BodyId{1});
}

TEST_CASE("a pose places the mechanism and its root joint") {
  const std::string posed = head + "pose = { xyz = [1, 0, 0], rpy = [0, 0, \"90 deg\"] }\n";
  const Scenario pinned_at = read(posed + pinned.substr(head.size()) + "at = { xyz = [1, 0, 0] }\n");
  CHECK(pinned_at.model[BodyId{0}].at.position.x == doctest::Approx(1));
  CHECK(pinned_at.model[BodyId{0}].at.position.y == doctest::Approx(1));
  const Scenario free = read(posed + "root = \"free\"\n" + one_body.substr(head.size()));
  CHECK(free.model[BodyId{0}].joint.kind == Kind::free);
  CHECK(free.model[BodyId{0}].q[0] == 1);
  CHECK(free.model[BodyId{0}].at.position == Vec3{});
  const Scenario fixed = read(posed + one_body.substr(head.size()));
  CHECK(fixed.model[BodyId{0}].joint.kind == Kind::weld);
  CHECK(fixed.model[BodyId{0}].at.position == Vec3{1, 0, 0});
}

TEST_CASE("the velocity of a free root is that of its body's frame, wherever the joint is in it") {
  const Scenario s =
      read(head + "state = { velocity = { linear = [1, 0, 0], angular = [0, 0, 2] } }\n" + one_body.substr(head.size()) +
           "[mechanism.body.joint]\nkind = \"free\"\nchild_at = { xyz = [1, 0, 0], rpy = [0, 0, \"90 deg\"] }\n");
  const Values& v = s.model[BodyId{0}].v;
  // At (1, 0, 0) the body's velocity is (1, 2, 0), which is (2, −1, 0) along axes rotated by 90°.
  const double expected[] = {2, -1, 0, 0, 0, 2};
  for (int i = 0; i < 6; ++i) CHECK(v[i] == doctest::Approx(expected[i]));
}

TEST_CASE("every kind of joint, with its parameters") {
  const std::string text = one_body + "[mechanism.body.joint]\n";
  const auto joint = [&](const std::string& keys) { return read(text + keys).model[BodyId{0}]; };
  CHECK(joint("kind = \"prismatic\"\nposition = \"5 mm\"\nspeed = \"1 m/s\"\ndamping = \"2 N s/m\"\n").q == Values{0.005});
  CHECK(joint("kind = \"helical\"\npitch = \"5 mm\"\nangle = \"90 deg\"\n").joint.pitch == 0.005);
  CHECK(joint("kind = \"cylindrical\"\nq = [\"90 deg\", \"1 m\"]\ndamping = [\"1 N m s\", \"2 N s/m\"]\n")
            .joint.parameters.damping == Values{1, 2});
  CHECK(joint("kind = \"cylindrical\"\ndamping = 3\n").joint.parameters.damping == Values{3});
  CHECK(joint("kind = \"universal\"\naxis = [2, 0, 0]\naxis2 = [0, 1, 0]\n").joint.axis == Vec3{1, 0, 0});
  CHECK(joint("kind = \"ball\"\nv = [1, 2, 3]\nstiffness = 2\nrest = [0, 1, 0, 0]\n").joint.parameters.rest ==
        Values{0, 1, 0, 0});
  CHECK(
      joint("kind = \"planar\"\nq = [1, 2, \"3 rad\"]\ndrive = { effort = [\"1 N\", 2, \"3 N m\"] }\n").joint.parameters.effort ==
      Values{1, 2, 3});
  CHECK(joint("kind = \"free\"\n").q.empty());
  CHECK(joint("kind = \"weld\"\ndamping = 0.0\n").q.empty());
  CHECK(joint("kind = \"revolute\"\narmature = \"1 g cm^2\"\ndrive = { effort = \"2 N m\" }\n").joint.parameters.armature ==
        Values{1e-7});
}

TEST_CASE("a unit that does not fit every degree of freedom is refused") {
  CHECK(
      said(read_scenario_text(one_body + "[mechanism.body.joint]\nkind = \"cylindrical\"\ndamping = \"1 N m s\"\n", "s.toml")) ==
      "s.toml:10:11: error: damping: '1 N m s' is an angular momentum (N m s), not a damping (N s/m); for example 20, or \"20 N "
      "s/m\"");
}

TEST_CASE("an event with a wildcard is one event for each match, in the order of the model") {
  const Scenario s =
      read(head + "[mechanism.chain]\nlinks = 12\nlength = 1\nmass = 1\ninertia = 1\n" +
           "[[event]]\nname = \"end\"\nat = 2\nbreak = [\"m/1*\", \"m/3\", \"m/2\"]\n[[event]]\nat = 1\nbreak = \"*/5\"\n");
  REQUIRE(s.events.size() == 6);
  CHECK(s.events[0].actions.size() == 2);  // those named one by one
  CHECK(s.events[0].actions[0]->joints().at(0) == "m/3");
  for (const std::size_t i : {1u, 2u, 3u, 4u}) {
    CHECK(s.events[i].name == "end");
    CHECK(s.events[i].actions.size() == 1);
  }
  CHECK(s.events[1].actions[0]->joints().at(0) == "m/1");
  CHECK(s.events[2].actions[0]->joints().at(0) == "m/10");
  CHECK(s.events[5].name == "#2");
  CHECK(s.events[5].actions[0]->joints().at(0) == "m/5");
}

TEST_CASE("shapes are kept by body number") {
  const Scenario s = read(
      one_body + "shape = { capsule = { radius = \"1 cm\", length = 1 }, at = { xyz = [1, 2, 3] }, colour = \"#12aB34\" }\n" +
      "[[mechanism]]\nname = \"n\"\n" + chain.substr(head.size()) + "inertia = 1\n");
  REQUIRE(s.shapes.size() == 4);
  REQUIRE(s.shapes[0].as<contact::Capsule>());
  CHECK(s.shapes[0].as<contact::Capsule>()->radius == 0.01);
  CHECK(s.shapes[0].at.position == Vec3{1, 2, 3});
  CHECK(s.shapes[0].colour == "#12aB34");
  CHECK(s.shapes[3].kind == Shape::Kind::none);
}

TEST_CASE("each link of a chain has its shape") {
  const Scenario s = read(one_body + "[[mechanism]]\nname = \"n\"\n" + chain.substr(head.size()) +
                          "inertia = 1\nshape = [{ sphere = 2 }, { box = [1, 2, 3] }]\n");
  REQUIRE(s.shapes.size() == 4);
  CHECK(s.shapes[0].kind == Shape::Kind::none);
  for (std::size_t link = 1; link < s.shapes.size(); ++link) {
    CHECK(s.shapes[link].primitive == contact::Primitive(contact::Sphere{2}));
    REQUIRE(s.shapes[link].more.size() == 1);
    CHECK(s.shapes[link].more[0].primitive == contact::Primitive(contact::Box{{1, 2, 3}}));
  }
}

TEST_CASE("a body has several shapes, a mesh is scaled") {
  const Scenario s =
      read(one_body + "shape = [{ sphere = 2 }, { mesh = \"a.stl\", scale = [1, 2, 3] }, { mesh = \"a.stl\", scale = 5 }]\n");
  REQUIRE(s.shapes[0].more.size() == 2);
  CHECK(s.shapes[0].primitive == contact::Primitive(contact::Sphere{2}));
  CHECK(s.shapes[0].more[0].scale == Vec3{1, 2, 3});
  CHECK(s.shapes[0].more[1].scale == Vec3{5, 5, 5});
}

TEST_CASE("several roots make several mechanisms, if the file allows it") {
  const std::string two = "format = 1\n[[mechanism]]\nname = \"m\"\nroots = 2\n" + one_body.substr(head.size());
  const Scenario s =
      read(two + "[mechanism.body.joint]\nkind = \"free\"\n[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = 1\n" +
           "[mechanism.body.joint]\nkind = \"revolute\"\n");
  REQUIRE(s.model.size() == 2);
  CHECK(s.model.mechanism_name(BodyId{0}) == "m");
  CHECK(s.model.mechanism_name(BodyId{1}) == "m/b");
  CHECK(s.model[BodyId{1}].parent == ground);
}

TEST_CASE("state documents are named relative to the scenario") {
  const Scenario s = read("state = \"a.json\"\n" + head + "state = \"b.json\"\n" + one_body.substr(head.size()));
  REQUIRE(s.state_files.size() == 2);
  CHECK(s.state_files[0].file == "folder/a.json");
  CHECK(s.state_files[0].mechanism == "");
  CHECK(s.state_files[1].file == "folder/b.json");
  CHECK(s.state_files[1].mechanism == "m");
  CHECK(s.state_files[1].place.line == 5);
}

TEST_CASE("one odd body in a sound group is a warning") {
  const std::string text = one_body +
                           "[[mechanism.body]]\nname = \"b\"\nmass = 1\ninertia = [0.1, 0.1, 0.3]\n[mechanism.body.joint]\nkind "
                           "= \"weld\"\nparent = \"a\"\n";
  const ReadResult result = read_scenario_text(text, "s.toml");
  CHECK(result.scenario);
  REQUIRE(result.diagnostics.size() == 1);
  CHECK(result.diagnostics[0].severity == Severity::warning);
  CHECK(result.diagnostics[0].line == 11);
}

TEST_CASE("a massless part below a weld is accepted, one that would separate is not") {
  const std::string carrier =
      "[[mechanism.body]]\nname = \"c\"\nmass = 0\n[mechanism.body.joint]\nkind = \"weld\"\nparent = \"a\"\n";
  CHECK(read(pinned + carrier).model.size() == 2);
  CHECK(said(read_scenario_text(pinned + carrier + "[[event]]\nat = 1\nbreak = \"m/c\"\n", "s.toml")) ==
        "s.toml:18:9: error: break: the part that separates at 'm/c' lacks the mass or inertia to move freely; give it a mass "
        "and an inertia "
        "about every axis");
}

TEST_CASE("all semantic errors of a file are reported together, in the order of the file") {
  const char* text = R"([integrate]
step = 0
[output]
evry = 1
[[event]]
at = -1
break = "m/z"
[[mechanism]]
name = "m"
[[mechanism.body]]
name = "a"
mass = 1
inertia = [1, 1, 9]
[mechanism.body.joint]
kind = "revolute"
dampng = 1
axis = [0, 0, 0]
[[mechanism.body]]
name = "b"
mass = "-1 kg"
[mechanism.body.joint]
kind = "revolut"
parent = "aa"
)";
  CHECK(said(read_scenario_text(text, "s.toml")) ==
        "s.toml:1:1: warning: the scenario does not state its format; begin it with format = 1\n"
        "s.toml:2:8: error: step: must be greater than 0\n"
        "s.toml:4:1: error: unknown key 'evry' in [output]; did you mean 'every'?\n"
        "s.toml:6:6: error: at: must not be negative\n"
        "s.toml:7:9: error: break: there is no joint 'm/z'; did you mean 'm/a'?\n"
        "s.toml:13:11: error: inertia: the largest principal moment is more than the sum of the others, which no body has; it is "
        "meant "
        "about the centre of mass, and products of inertia as elements of the matrix (xy = −Σ m x y)\n"
        "s.toml:16:1: error: unknown key 'dampng' in [mechanism.body.joint]; did you mean 'damping'?\n"
        "s.toml:17:8: error: axis: an axis of length zero has no direction; for example [0, 0, 1]\n"
        "s.toml:20:8: error: mass: must not be negative\n"
        "s.toml:22:8: error: unknown joint kind 'revolut'; did you mean 'revolute'?\n"
        "s.toml:23:10: error: unknown parent 'aa'; did you mean 'a'?");
}

TEST_CASE("the values of a state are checked like a joint's own initial values") {
  const auto start = [](const std::string& state, const std::string& bodies) {
    return said(read_scenario_text(head + "state = " + state + "\n" + bodies, "s.toml"));
  };
  const std::string ball = one_body.substr(head.size()) + "[mechanism.body.joint]\nkind = \"ball\"\n";
  CHECK(start("{ joints = { a = [1, 1, 0, 0] } }", ball) ==
        "s.toml:4:26: error: a: the length of the quaternion is not 1; scale it: w² + x² + y² + z² = 1");
  CHECK(start("{ joints = { a = { v = [1, 2] } } }", ball) ==
        "s.toml:4:32: error: v: expected 3 numbers, found a list of 2; one per degree of freedom or coordinate, in the order of "
        "the joint kind");
  const std::string links = chain.substr(head.size()) + "inertia = 1\n";
  CHECK(start("{ joints = { 1 = [0, 0, 0, 0, 0, 0, 0] } }\nroot = \"free\"", links) ==
        "s.toml:4:26: error: 1: a quaternion of zeros is not a rotation; the identity is [1, 0, 0, 0]");
  CHECK(said(read_scenario_text(chain + "inertia = 1\nangle = 1e308\nangle_growth = true\n", "s.toml")) ==
        "s.toml:9:9: error: q: must be finite");
}

TEST_CASE("mechanisms without names are refused, and nothing of them is kept") {
  const std::string nameless = "[[mechanism]]\n" + chain.substr(head.size()) + "inertia = 1\n";
  CHECK(said(read_scenario_text("format = 1\n" + nameless + nameless, "s.toml")) ==
        "s.toml:2:1: error: [[mechanism]] has no 'name'; for example name = \"arm\"\n"
        "s.toml:8:1: error: [[mechanism]] has no 'name'; for example name = \"arm\"");
}

TEST_CASE("a moving body without mass between two masses gives a warning, a carrier does not") {
  const auto three = [](const std::string& name) {
    const std::string pin = "[mechanism.body.joint]\nkind = \"revolute\"\n";
    return head + "[[mechanism.body]]\nname = \"" + name + "\"\nmass = 0\n" + pin +
           "[[mechanism.body]]\nname = \"b\"\nmass = 1\n" + "inertia = 1\n" + pin + "axis = [0, 1, 0]\nparent = \"" + name +
           "\"\n";
  };
  CHECK(said(read_scenario_text(three("a"), "s.toml")) ==
        "s.toml:6:8: warning: 'm/a' moves and carries other bodies, but has no mass; is its inertia missing?");
  CHECK(said(read_scenario_text(three("b.turn"), "s.toml")).empty());
}

TEST_CASE("a long chain with errors is not built") {
  const std::string events = "[[event]]\nat = 1\nbreak = \"m/1000001\"\n";
  const std::string links = head + "[mechanism.chain]\nlength = 1\nmass = -1\nlinks = ";
  CHECK(said(read_scenario_text(links + "1000000\n" + events, "s.toml")) == "s.toml:6:8: error: mass: must not be negative");
  CHECK(said(read_scenario_text(links + "3\n" + events, "s.toml")) ==
        "s.toml:6:8: error: mass: must not be negative\n"
        "s.toml:10:9: error: break: there is no joint 'm/1000001'");
}

TEST_CASE("invalid files are refused") {
  const auto first = [](const std::string& path) {
    const ReadResult result = read_scenario(path);
    CHECK(!result.scenario);
    return result.diagnostics.empty() ? std::string() : result.diagnostics[0].message();
  };
  CHECK(first("/nonexistent/s.toml") == "/nonexistent/s.toml: error: there is no such file");
  CHECK(first("/tmp").rfind("/tmp: error: is a folder, not a scenario", 0) == 0);
  CHECK(first("/dev/zero") == "/dev/zero: error: is not a regular file");
}

TEST_CASE("a long chain of bodies, the last one first, loads without recursion") {
  std::string text = "format = 1\n[[mechanism]]\nname = \"m\"\n";
  const int n = 20'000;
  for (int k = n; k >= 1; --k) {  // children first: the worst order
    text += "[[mechanism.body]]\nname = \"" + std::to_string(k) +
            "\"\nmass = 1\ninertia = 1\n[mechanism.body.joint]\nkind = \"revolute\"\n";
    if (k > 1) text += "parent = \"" + std::to_string(k - 1) + "\"\n";
  }
  const Scenario s = read(text);
  REQUIRE(s.model.size() == n);
  CHECK(s.model[BodyId{n - 1}].name == "m/20000");
  // The same as a cycle.
  const ReadResult circle = read_scenario_text(text + "parent = \"20000\"\n", "s.toml");
  REQUIRE(circle.diagnostics.size() == 1);
  CHECK(circle.diagnostics[0].what.find("the joints form a cycle: '20000' on '19999'") == 0);
}
