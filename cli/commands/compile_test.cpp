// `momentree compile` and `run --generate`, called as a user would.
#include <doctest/doctest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <sstream>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree::cli {

namespace {

const char* const pendulums = R"(format = 1
title = "Two pendulums"
[world]
gravity = [0, 0, -9.81]
[[mechanism]]
name = "double pendulum"
[[mechanism.body]]
name = "upper"
mass = 2
com = [0, 0, -0.3]
inertia = 0.05
[mechanism.body.joint]
kind = "revolute"
axis = [0, 1, 0]
damping = 0.1
angle = 0.5
[[mechanism.body]]
name = "lower"
mass = 1
com = [0, 0, -0.2]
inertia = 0.02
[mechanism.body.joint]
kind = "universal"
axis = [1, 0, 0]
axis2 = [0, 1, 0]
parent = "upper"
at = { xyz = [0, 0, -0.6] }
stiffness = 2
[[event]]
name = "jam"
at = 0.05
lock = "double pendulum/lower"
[[event]]
name = "free"
at = 0.1
unlock = "double pendulum/lower"
[integrate]
step = 1e-3
until = 0.2
)";

struct Outcome {
  int code;
  std::string output, errors;
};

class Place {
 public:
  explicit Place(const std::string& scenario = pendulums) { io::write_text_file(folder_ / "two pendulums.toml", scenario); }
  Outcome call(const std::string& arguments, const std::string& before = "") const {
    return run(before + " '" MOMENTREE_PROGRAM "' " + arguments);
  }
  Outcome run(const std::string& command) const {
    const std::string line = "cd '" + (folder_ / "") + "' && " + command + " >out 2>err";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text("out"), text("err")};
  }
  std::string text(const char* name) const { return io::read_text_file(folder_ / name); }
  bool has(const char* name) const { return std::filesystem::exists(folder_ / name); }

 private:
  io::test::TemporaryFolder folder_;
};

bool contains(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

std::string with(const std::string& what, const std::string& instead) {
  std::string text = pendulums;
  return text.replace(text.find(what), what.size(), instead);
}

}  // namespace

TEST_CASE("compile writes a file with its memory layout, and reports the savings") {
  const Place here;
  const Outcome made = here.call("compile 'two pendulums.toml' -o kernel.cpp");
  CHECK(made.code == 0);
  CHECK(made.errors == "");
  CHECK(contains(made.output, "two_pendulums_rates: "));
  CHECK(contains(made.output, "per body, where the kernels take"));
  const std::string text = here.text("kernel.cpp");
  for (const char* part : {"// Two pendulums: 2 bodies, 3 degrees of freedom, gravity 0 0 -9.81 m/s^2.",
                           "Dampers, springs and constant efforts", "double pendulum/upper, revolute", "q[1] to q[2]",
                           "p[1] to p[2]", "N m s", "void two_pendulums_rates(", "const int two_pendulums_nq = 3;"})
    CHECK_MESSAGE(contains(text, part), part);
  CHECK_FALSE(contains(text, "/two"));  // no path of this machine

  const Outcome printed = here.call("compile 'two pendulums.toml' -o - --name k");
  CHECK(printed.code == 0);
  CHECK(contains(printed.output, "void k_rates("));
  CHECK(contains(printed.errors, "k_rates: "));
  const Outcome alone = here.call("compile 'two pendulums.toml' -o - --without-joint-forces --set world.gravity=[0,0,0]");
  CHECK(alone.code == 0);
  CHECK(contains(alone.output, "Without joint forces"));
  CHECK(contains(alone.output, "gravity 0 0 0 m/s^2"));

  const Outcome velocities = here.call("compile 'two pendulums.toml' -o - --variables velocities");
  CHECK(velocities.code == 0);
  CHECK(contains(velocities.errors, "two_pendulums_accelerations: "));
  for (const char* part : {"void two_pendulums_accelerations(", "efforts of its joints are in udot", "u[1] to u[2]", "rad/s"})
    CHECK_MESSAGE(contains(velocities.output, part), part);
  CHECK(contains(here.call("compile 'two pendulums.toml' -o - --variables velocities --without-joint-forces").output,
                 "to tau yourself"));
}

TEST_CASE("compile: the output compiles by itself, without a warning") {
  const Place here;
  for (const char* variables : {"momenta", "velocities"}) {
    const std::string name = std::string(variables) + ".cpp";
    REQUIRE(here.call("compile 'two pendulums.toml' --name two --variables " + (variables + (" -o " + name))).code == 0);
    CHECK(here.run("'" MOMENTREE_COMPILER "' -std=c++20 -O1 -Wall -Wextra -Wpedantic -Wconversion -Werror -c " + name).code == 0);
    CHECK(here.text("err") == "");
    CHECK(here.has((std::string(variables) + ".o").c_str()));
  }
}

TEST_CASE("compile: a mechanism without gravity, whatever was in memory before") {
  const Place here;
  for (const char* variables : {"momenta", "velocities"}) {
    const std::string humanoid = "compile '" MOMENTREE_SOURCE_DIR
                                 "/scenarios/humanoid_wave.toml' --without-joint-forces --variables " +
                                 std::string(variables) + " -o ";
    REQUIRE(here.call(humanoid + "one.cpp", "MALLOC_PERTURB_=85").code == 0);
    REQUIRE(here.call(humanoid + "other.cpp", "MALLOC_PERTURB_=170").code == 0);
    CHECK(here.text("one.cpp") == here.text("other.cpp"));
  }
}

TEST_CASE("compile: titles and names become comments of plain ASCII, whatever they contain") {
  std::string odd = with("Two pendulums", R"(Zwei Überschläge */ int evil = 1; /* ??\\)");
  for (std::size_t at = 0; (at = odd.find("upper", at)) != std::string::npos; at += 10) odd.replace(at, 5, R"(Ü upper\\)");
  const Place here(odd), plain;
  REQUIRE(here.call("compile 'two pendulums.toml' -o k.cpp").code == 0);
  REQUIRE(plain.call("compile 'two pendulums.toml' -o k.cpp").code == 0);
  const std::string text = here.text("k.cpp"), expected = plain.text("k.cpp");
  CHECK(contains(text, "// Zwei <U+00DC>berschl<U+00E4>ge *<U+002F> int evil = 1; /<U+002A> ?<U+003F><U+005C>: 2 bodies"));
  CHECK(contains(text, "\n// double pendulum/<U+00DC> upper<U+005C>, revolute "));
  CHECK(text.find_first_not_of(
            "\n !\"#$%&'()*+,-./0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[]^_`abcdefghijklmnopqrstuvwxyz{|}~") ==
        std::string::npos);
  const auto code = [](const std::string& source) { return source.substr(source.find("#include")); };
  CHECK(code(text) == code(expected));
  std::istringstream head(text.substr(0, text.find("#include")));
  for (std::string line; std::getline(head, line);) CHECK_MESSAGE(line.starts_with("//"), line);
}

TEST_CASE("compile: closed loops in velocities, for the equations that are independent at the start") {
  const Place here(R"(format = 1
[[mechanism]]
name = "linkage"
roots = 2
[[mechanism.body]]
name = "crank"
mass = 2
inertia = 0.02
joint = { kind = "revolute", axis = [0, 1, 0], angle = "-60 deg", damping = 0.1 }
[[mechanism.body]]
name = "coupler"
mass = 1
com = [0.2, 0, 0]
inertia = [1e-4, 0.015, 0.015]
joint = { kind = "revolute", parent = "crank", axis = [0, 1, 0], at = { xyz = [0.12, 0, 0] } }
[[mechanism.body]]
name = "rocker"
mass = 1
com = [0.125, 0, 0]
inertia = [1e-4, 0.006, 0.006]
joint = { kind = "revolute", axis = [0, 1, 0], at = { xyz = [0.4, 0, 0] } }
[[loop]]
name = "pin"
kind = "revolute"
axis = [0, 1, 0]
body = "linkage/coupler"
to = "linkage/rocker"
at = { xyz = [0.25, 0, 0] }
child_at = { xyz = [0.38, 0, 0] }
[integrate]
step = 1e-3
until = 0.1
)");
  const Outcome momenta = here.call("compile 'two pendulums.toml' -o k.cpp --variables momenta");
  CHECK(momenta.code == 2);
  CHECK(contains(momenta.errors, "only in velocities"));
  const std::string compile = "compile 'two pendulums.toml' -o k.cpp --variables velocities";
  const Outcome done = here.call(compile);
  CHECK(done.errors == "");
  REQUIRE(done.code == 0);
  CHECK(contains(here.text("k.cpp"), "// Closed loops: 2 independent equations of 5,"));
  CHECK(here.run("'" MOMENTREE_COMPILER "' -std=c++20 -O1 -Wall -Wextra -Wpedantic -Wconversion -Werror -c k.cpp").code == 0);
  const Outcome damped = here.call(compile + " --set loop.pin.damping=0.1");
  CHECK(damped.code == 2);
  CHECK(contains(damped.errors, "loop joint 'pin' has a force along its DoFs"));
  CHECK(here.call(compile + " --set loop.pin.damping=0.1 --without-joint-forces").code == 0);

  const Outcome generated = here.call("run 'two pendulums.toml' --out generated --generate");
  CHECK(generated.code == 0);
  CHECK(generated.errors == "");
  CHECK(contains(generated.output, "Generated code: 1 topology compiled"));
}

TEST_CASE("compile refuses models that it cannot write, with names and an alternative") {
  const Place rough(with("damping = 0.1", "friction = { coulomb = 0.1, speed = 0.01 }"));
  const Outcome refused = rough.call("compile 'two pendulums.toml' -o kernel.cpp");
  CHECK(refused.code == 2);
  CHECK(refused.output == "");
  CHECK(contains(refused.errors, "two pendulums.toml: error: joint 'double pendulum/upper' has dry friction"));
  CHECK(contains(refused.errors, "--without-joint-forces"));
  CHECK_FALSE(rough.has("kernel.cpp"));
  CHECK(rough.call("compile 'two pendulums.toml' -o kernel.cpp --without-joint-forces").code == 0);
  const Place here;
  for (const char* wrong :
       {"compile 'two pendulums.toml'", "compile -o k.cpp", "compile none.toml -o k.cpp",
        "compile 'two pendulums.toml' -o no/such/folder/k.cpp", "compile 'two pendulums.toml' -o k.cpp --name 7k",
        "compile 'two pendulums.toml' -o k.cpp --set world.gravity=3",
        "compile 'two pendulums.toml' -o k.cpp --variables speeds"}) {
    const Outcome outcome = here.call(wrong);
    CHECK_MESSAGE(outcome.code == 2, wrong);
    CHECK_MESSAGE(contains(outcome.errors, "error"), wrong);
    CHECK_FALSE(here.has("k.cpp"));
  }
}

TEST_CASE("run --generate: the same motion, a line about it, and a fallback without machine code") {
  const Place here;
  const std::string run = "run 'two pendulums.toml' --out ";
  REQUIRE(here.call(run + "plain").code == 0);
  const Outcome generated = here.call(run + "generated --generate");
  CHECK(generated.code == 0);
  CHECK(generated.errors == "");
  CHECK(contains(generated.output, "Generated code: 2 topologies compiled, found again 1 time, in "));
  CHECK(here.text("generated/events.jsonl").size() > 0);
  const Outcome without = here.call(run + "none --generate", "MOMENTREE_MACHINE=0");
  CHECK(without.code == 0);
  CHECK(contains(without.errors, "two pendulums.toml: warning: --generate: there is no machine code here"));
  REQUIRE(here.call(run + "generic", "MOMENTREE_MACHINE=0").code == 0);
  CHECK(here.text("none/bodies.csv") == here.text("generic/bodies.csv"));
  const Outcome damped = here.call(run + "damped --generate --set integrate.method=damped");
  CHECK(damped.code == 0);
  CHECK(contains(damped.errors, "the method damped"));
  for (const std::string variables : {"momenta", "velocities"})
    for (const std::string method : {"rk4", "dop853"}) {
      const std::string name = variables + method;
      const Outcome outcome =
          here.call(run + name + " --generate --set integrate.method=" + method + " --set integrate.variables=" + variables);
      CHECK(outcome.errors == "");
      CHECK(contains(outcome.output, "Generated code: 2 topologies compiled, found again 1 time, in "));
    }
  const Outcome json = here.call(run + "json --generate --json");
  CHECK(json.code == 0);
  CHECK(json.output.starts_with("{"));
}

}  // namespace momentree::cli
