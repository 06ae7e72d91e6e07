#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include <momentree/scenario/test_support.hpp>
#include <momentree/sweep/plan/read_sweep.hpp>
#include <momentree/sweep/scenario_worlds.hpp>
#include <momentree/text/files/text_file.hpp>

using namespace momentree::sweep;

namespace {

// A ball thrown upwards, which is pushed at 0.25 s.
const std::string ball = R"(format = 1
[world]
gravity = [0, -10, 0]
[[mechanism]]
name = "m"
root = "free"
state = { velocity = { linear = [2, 4, 0] } }
[[mechanism.body]]
name = "ball"
mass = 2
inertia = 1
[[event]]
name = "kick"
at = 0.25
impulse = { body = "m/ball", force = [1, 0, 0] }
[integrate]
step = 0.01
until = 1
[output]
every = 0.1
)";

struct Folder : momentree::io::test::TemporaryFolder {
  Folder() { momentree::io::write_text_file(*this / "ball.toml", ball); }
  std::string sweep() const { return *this / "s.toml"; }
};

std::string sweep_text(const std::string& vary, const std::string& measure, const std::string& more = "worlds = 8\nseed = 3\n") {
  return "format = 1\nscenario = \"ball.toml\"\n" + more + "[vary]\n" + vary + "\n[measure]\n" + measure + "\n";
}

std::string said(const ReadSweep& read) {
  std::string text;
  for (const auto& each : read.diagnostics) {
    std::string line = each.message();
    text += (text.empty() ? "" : "\n") + line.substr(line.find("s.toml"));
  }
  return text;
}

}  // namespace

TEST_CASE("measures of events at contacts") {
  const Folder folder;
  std::string bouncing = ball;
  bouncing.insert(bouncing.find("gravity"), "floor = { friction = 0.3, restitution = 0.5 }\n");
  bouncing.replace(bouncing.find("root = "), 0, "pose = { xyz = [0, 0.15, 0] }\n");
  bouncing.replace(bouncing.find("inertia = 1"), 11, "inertia = 0.008\ncollision = { sphere = 0.1 }");
  bouncing.replace(bouncing.find("until = 1"), 9, "until = 3");
  momentree::io::write_text_file(folder / "ball.toml", bouncing);
  const std::string vary = "\"mechanism.m.state.velocity.linear.0\" = [0, 2]";
  const ReadSweep read =
      read_sweep_text(sweep_text(vary,
                                 "n = { count = \"impact\" }\nrest = { time_of = \"rest\" }\nslips = { happened = \"slip\" }\n"
                                 "load = { max = { contact_force = [\"m/ball\", \"floor\"] } }",
                                 ""),
                      folder.sweep());
  CAPTURE(said(read));
  REQUIRE(read.sweep);
  CHECK(read.sweep->measures[3].about == "largest contact_force of m/ball ground");
  const ScenarioWorlds worlds(*read.sweep, std::nullopt);
  const double v = std::sqrt(17), rests = (4 + v) / 10 + 2 * 0.5 * v / 10 / (1 - 0.5);  // of the first impact; of all of them
  for (std::uint64_t w = 0; w < 2; ++w) {
    const WorldResult result = worlds.run(w);
    CAPTURE(result.failure);
    REQUIRE(result.done());
    CHECK(result.measures[0] > 5);
    CHECK(result.measures[1] == doctest::Approx(rests).epsilon(1e-5));
    CHECK(result.measures[3] == doctest::Approx(20).epsilon(1e-9));
  }
  const ReadSweep misspelt = read_sweep_text(sweep_text(vary, "n = { count = \"impakt\" }", ""), folder.sweep());
  CHECK(said(misspelt).find("did you mean 'impact'?") != std::string::npos);
}

TEST_CASE("measures of a thrown ball have their closed forms") {
  const Folder folder;
  const ReadSweep read =
      read_sweep_text(sweep_text("\"mechanism.m.state.velocity.linear\" = { uniform = [[1, 3, -1], [2, 6, 1]] }",
                                 "x = { final = \"m/ball.x\" }\n"
                                 "top = { max = \"m/ball.y\" }\n"
                                 "top_at = { max = \"m/ball.y\", value = \"time\" }\n"
                                 "low = { min = { height = \"m/ball\" } }\n"
                                 "mean_vx = { mean = \"m/ball.v0\" }\n"
                                 "y_half = { column = \"m/ball.y\", at = \"0.5 s\" }\n"
                                 "kicked = { happened = \"kick\" }\n"
                                 "when = { time_of = \"kick\" }\n"
                                 "kicks = { count = \"kick\" }\n"
                                 "second = { time_of = \"kick\", number = 2 }\n"
                                 "work = { event = \"kick\", value = \"work\" }\n"),
                      folder.sweep());
  CAPTURE(said(read));
  REQUIRE(read.sweep);
  const Sweep& sweep = *read.sweep;
  REQUIRE(sweep.worlds() == 8);
  REQUIRE(sweep.plan->size() == 3);
  const ScenarioWorlds worlds(sweep, std::nullopt);
  std::vector<double> v(3);
  for (std::uint64_t w = 0; w < 8; ++w) {
    sweep.plan->values(w, v);
    CHECK((v[0] >= 1 && v[0] <= 2 && v[1] >= 3 && v[1] <= 6 && std::fabs(v[2]) <= 1));
    const WorldResult result = worlds.run(w);
    CAPTURE(result.failure);
    REQUIRE(result.done());
    const std::vector<double>& m = result.measures;
    const double after = v[0] + 0.5;  // 1 N s on 2 kg
    CHECK(m[0] == doctest::Approx(v[0] * 0.25 + after * 0.75).epsilon(1e-12));
    CHECK(m[1] == doctest::Approx(v[1] * v[1] / 20).epsilon(1e-3));  // at the ends of steps
    CHECK(std::fabs(m[2] - v[1] / 10) <= 0.01);
    CHECK(m[3] == doctest::Approx(std::min(0.0, v[1] - 5)).epsilon(1e-9));
    CHECK(m[4] == doctest::Approx(v[0] * 0.25 + after * 0.75).epsilon(1e-9));
    CHECK(m[5] == doctest::Approx(v[1] * 0.5 - 1.25).epsilon(1e-12));
    CHECK((m[6] == 1 && m[7] == 0.25 && m[8] == 1 && std::isnan(m[9])));
    CHECK(m[10] == doctest::Approx(after * after - v[0] * v[0]).epsilon(1e-12));
    std::string encoded = worlds.run(Chunk{w, 1}), expected;
    encode(result, expected);
    CHECK(encoded == expected);
  }
}

TEST_CASE("the path of a sweep's scenario is as short as it can be") {
  const Folder folder;
  const std::string text =
      "format = 1\nscenario = \"../ball.toml\"\n[vary]\n\"mechanism.m.body.ball.mass\" = [1, 2]\n[measure]\nt = { final = "
      "\"time\" }\n";
  const auto path_of = [&](const std::string& sweep) {
    const ReadSweep read = read_sweep_text(text, sweep);
    REQUIRE(read.sweep);
    return read.sweep->scenario->path;
  };
  std::filesystem::create_directories(folder / "sweeps");
  CHECK(path_of(folder / "sweeps/s.toml") == folder / "ball.toml");
  std::filesystem::create_directories(folder / "elsewhere/deep");
  std::filesystem::copy(folder / "ball.toml", folder / "elsewhere/ball.toml");
  std::filesystem::create_directory_symlink("elsewhere/deep", folder / "link");
  CHECK(path_of(folder / "link/s.toml") == folder / "link/../ball.toml");
}

TEST_CASE("that a spring breaks by its strength can be measured") {
  const Folder folder;
  const std::string rope =
      "[[spring]]\nname = \"rope\"\nfrom = \"m/ball\"\nto = \"ground\"\nstiffness = 10\nrest = 0.1\nstrength = 1\n";
  momentree::io::write_text_file(folder / "ball.toml", ball + rope);
  const ReadSweep read = read_sweep_text(sweep_text("\"spring.rope.strength\" = [1, 1e6]",
                                                    "parts = { happened = \"strength of rope\" }\n"
                                                    "released = { event = \"strength of rope\", value = \"released\" }\n",
                                                    ""),
                                         folder.sweep());
  CAPTURE(said(read));
  REQUIRE(read.sweep);
  const ScenarioWorlds worlds(*read.sweep, std::nullopt);
  const std::vector<double> weak = worlds.run(0).measures, strong = worlds.run(1).measures;
  CHECK(weak[0] == 1);
  CHECK(weak[1] == doctest::Approx(0.5 * 1 * 1 / 10.0).epsilon(1e-6));
  CHECK((strong[0] == 0 && std::isnan(strong[1])));
}

TEST_CASE("a world ends after the event of [stop], and one with too many steps fails") {
  const Folder folder;
  const std::string text = sweep_text("\"mechanism.m.body.ball.mass\" = [1, 2]", "t = { final = \"time\" }", "");
  const ReadSweep ends = read_sweep_text(text + "[stop]\nafter = \"kick\"\n", folder.sweep());
  CAPTURE(said(ends));
  REQUIRE(ends.sweep);
  CHECK(ends.sweep->worlds() == 2);
  CHECK(ScenarioWorlds(*ends.sweep, std::nullopt).run(1).measures == std::vector<double>{0.25});
  const ReadSweep fails = read_sweep_text(text + "[stop]\nsteps = 50\n", folder.sweep());
  REQUIRE(fails.sweep);
  CHECK(ScenarioWorlds(*fails.sweep, std::nullopt).run(0).failure == "more than 50 steps, the limit of [stop]");
}

TEST_CASE("values are written into the scenario with their units") {
  const Folder folder;
  const ReadSweep read = read_sweep_text(
      sweep_text(
          "\"mechanism.m.state.velocity.linear.1\" = { normal = [\"400 cm/s\", \"10 cm/s\"], within = [\"3 m/s\", \"5 m/s\"] }",
          "y = { final = \"m/ball.y\" }"),
      folder.sweep());
  CHECK(!read.sweep);
  CHECK(said(read) ==
        "s.toml:6:87: error: within: two units, 'cm/s' and 'm/s'; give all numbers of a parameter the same unit\n"
        "s.toml:6:96: error: within: two units, 'cm/s' and 'm/s'; give all numbers of a parameter the same unit");
  const ReadSweep good = read_sweep_text(
      sweep_text(
          "\"mechanism.m.body.ball.mass\" = { latin = [\"500 g\", \"1500 g\"] }\n\"integrate.method\" = [\"rk4\", \"midpoint\"]",
          "y = { final = \"m/ball.y\" }"),
      folder.sweep());
  CAPTURE(said(good));
  REQUIRE(good.sweep);
  const std::vector<std::string> overrides = good.sweep->overrides(0);
  REQUIRE(overrides.size() == 2);
  CHECK(overrides[0].starts_with("mechanism.m.body.ball.mass=\""));
  CHECK(overrides[0].ends_with(" g\""));
  CHECK((overrides[1] == "integrate.method=\"rk4\"" || overrides[1] == "integrate.method=\"midpoint\""));
}

TEST_CASE("the contents of files that entries of lists name belong to the sweep") {
  const Folder folder;
  const auto model = [](double mass) {
    return "<robot name=\"r\"><link name=\"base\"/><link name=\"arm\"><inertial><mass value=\"" + std::to_string(mass) +
           "\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><joint name=\"j\" "
           "type=\"continuous\"><parent link=\"base\"/><child link=\"arm\"/><axis xyz=\"0 1 0\"/></joint></robot>";
  };
  const auto write = [&](const char* name, double mass) { momentree::io::write_text_file(folder / name, model(mass)); };
  write("a.urdf", 1);
  write("b.urdf", 2);
  momentree::io::write_text_file(
      folder / "ball.toml", "format = 1\n[[mechanism]]\nname = \"m\"\nmodel = \"a.urdf\"\n[integrate]\nstep = 0.01\nuntil = 1\n");
  const auto hash = [&](const std::string& list) {
    const ReadSweep read =
        read_sweep_text(sweep_text("\"mechanism.m.model\" = " + list, "x = { final = \"m/j.q0\" }", ""), folder.sweep());
    CAPTURE(said(read));
    REQUIRE(read.sweep);
    return read.sweep->hash;
  };
  std::string many = "[";
  for (int i = 0; i < 150; ++i) many += i == 120 ? "\"b.urdf\", " : "\"a.urdf\", ";
  many += "\"a.urdf\"]";
  for (const std::string& list : {std::string("[\"a.urdf\", \"b.urdf\"]"), many}) {
    write("b.urdf", 2);
    const std::string before = hash(list);
    CHECK(hash(list) == before);
    write("b.urdf", 3);
    CHECK(hash(list) != before);
  }
}

TEST_CASE("quantities in one unit are numbers, other strings are text") {
  const Folder folder;
  const auto column = [&](const std::string& key, const std::string& list) {
    const ReadSweep read =
        read_sweep_text(sweep_text('"' + key + "\" = " + list, "x = { final = \"m/ball.x\" }", ""), folder.sweep());
    CAPTURE(said(read));
    REQUIRE(read.sweep);
    const Sweep& sweep = *read.sweep;
    std::string all = sweep.parameters[0].unit + ':';
    for (std::uint64_t w = 0; w < sweep.worlds(); ++w) {
      std::vector<double> values(1);
      sweep.plan->values(w, values);
      const ParameterColumn each = parameter_columns(sweep)[0];
      CHECK(std::isnan(parameter_number(each, values)) == each.is_text);
      all += ' ' + parameter_text(each, values) + '=' + sweep.overrides(w)[0].substr(key.size() + 1);
    }
    return all;
  };
  CHECK(column("integrate.step", "[\"0.5 ms\", \"20 ms\"]") == "ms: 0.5=\"0.5 ms\" 20=\"20 ms\"");
  CHECK(column("event.kick.at", "[0, \"1e2 ms\"]") == "ms: 0=0 100=\"1e2 ms\"");
  CHECK(column("integrate.step", "[\"1 ms\", \"0.01 s\"]") == ": 1 ms=\"1 ms\" 0.01 s=\"0.01 s\"");
  CHECK(column("integrate.step", "[\"1 ms\", 0.01]") == ": 1 ms=\"1 ms\" 0.01=0.01");
  CHECK(column("integrate.method", "[\"rk4\", \"midpoint\"]") == ": rk4=\"rk4\" midpoint=\"midpoint\"");
}

TEST_CASE("a world that fails names the value that is impossible") {
  const Folder folder;
  const ReadSweep read = read_sweep_text(
      sweep_text("\"mechanism.m.body.ball.mass\" = { normal = [1, 1000] }", "x = { final = \"m/ball.x\" }"), folder.sweep());
  REQUIRE(read.sweep);
  std::size_t failed = 0;
  for (std::uint64_t w = 0; w < 8; ++w) {
    const WorldResult result = ScenarioWorlds(*read.sweep, std::nullopt).run(w);
    if (result.done()) continue;
    ++failed;
    CHECK(result.failure == read.sweep->overrides(w)[0] + ": mass: must not be negative");
  }
  CHECK(failed > 0);
}

TEST_CASE("mistakes in a sweep name their line and how to mend them") {
  const Folder folder;
  const std::string vary = "\"event.kick.at\" = { uniform = [0.1, 0.4] }", measure = "x = { final = \"m/ball.x\" }";
  const auto check = [&](const std::string& text, const std::string& expected) {
    CAPTURE(text);
    const ReadSweep read = read_sweep_text(text, folder.sweep());
    CHECK(!read.sweep);
    CHECK(said(read) == expected);
  };
  check(sweep_text("\"event.kik.at\" = [0.1]", measure),
        "s.toml:6:1: error: event.kik.at = 0.1: no entry of the list is named 'kik'; did you mean 'kick'?");
  check(sweep_text("\"event.kick.at\" = 0.1", measure),
        "s.toml:6:19: error: event.kick.at: this is one value, which does not vary; give a list or a distribution: { uniform = "
        "[0.2, 0.4] }");
  check(sweep_text("\"event.kick.at\" = []", measure),
        "s.toml:6:19: error: event.kick.at: the list is empty; give at least one value");
  check(sweep_text("\"event.kick.at\" = { range = [0, 1, 0] }", measure),
        "s.toml:6:36: error: range: the count of values: expected a whole number of at least 1, found 0");
  check(sweep_text("\"event.kick.at\" = { uniform = [0.1, 0.2, 0.3] }", measure),
        "s.toml:6:31: error: uniform: expected a list of 2 entries; for example uniform = [0.2, 0.4]");
  check(sweep_text("\"mechanism.m.body.ball.mass\" = { uniform = [-0.5, 1.5] }", measure),
        "s.toml:6:1: error: mechanism.m.body.ball.mass = -0.499999998: mass: must not be negative");
  // An error that no single value has is not blamed on one of them.
  check(
      sweep_text("\"event.kick.at\" = { uniform = [0.1, 0.4] }\n\"event.kick.when.below\" = [1]", measure),
      "s.toml:7:1: error: event.kick.when.below = 1: when: names no quantity; one of: contact_force contact_impulse distance gap "
      "height kinetic_energy position reaction reaction_force reaction_impulse reaction_torque slip speed touch");
  std::string triangle = ball;
  momentree::io::write_text_file(folder / "ball.toml", triangle.replace(triangle.find("inertia = 1"), 11, "inertia = [1, 1, 1]"));
  check(
      sweep_text("\"mechanism.m.body.ball.inertia.0\" = [1.9]\n\"mechanism.m.body.ball.inertia.1\" = [0.5]", measure, ""),
      "s.toml:3:1: error: [vary]: with the typical values of all parameters: inertia: the largest principal moment is more than "
      "the sum of the others, which no body has (" +
          folder / "ball.toml" +
          ", line 11); it is meant about the centre of mass, and products of inertia as elements of the matrix (xy = −Σ m x y)");
  momentree::io::write_text_file(folder / "ball.toml", ball);
  check(
      sweep_text(vary, "x = { final = \"m/ball.w\" }"),
      "s.toml:8:15: error: there is no column 'm/ball.w'; 'm/ball' has x y z qw qx qy qz, and its joint q0 q1 q2 q3 q4 q5 q6 v0 "
      "v1 v2 v3 v4 v5 p0 p1 p2 p3 p4 p5 fx fy fz mx my mz");
  check(sweep_text(vary, "x = { time_of = \"kik\" }"),
        "s.toml:8:17: error: time_of: there is no event 'kik'; did you mean 'kick'?");
  check(sweep_text(vary, "x = { max = { reaction_force = \"m/bal\" } }"),
        "s.toml:8:32: error: reaction_force: there is no joint 'm/bal'; did you mean 'm/ball'?");
  check(sweep_text(vary, "status = { count = \"kick\" }"),
        "s.toml:8:1: error: [measure]: 'status' is the name of another column; choose another name");
  check(sweep_text(vary, measure, ""),
        "s.toml:3:1: error: [vary]: every value is drawn at random, but the number of worlds is not given; worlds = 1000");
}
