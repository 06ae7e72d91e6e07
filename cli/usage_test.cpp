// Calls the built program as a user would: arguments, help, standard input and output.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <tests/program.hpp>

namespace momentree {
namespace {

namespace fs = std::filesystem;
using io::test::TemporaryFolder;
using namespace test;
using Json = nlohmann::json;

TEST_CASE("usage") {
  const Workplace here;
  CHECK(here.call("--version").output.starts_with("momentree "));
  CHECK(here.call("--version").code == 0);
  CHECK(here.call("--help").code == 0);
  CHECK(here.call("run --help").says("--until"));
  const auto refused = [&](const char* arguments, const char* words) {
    const Outcome outcome = here.call(arguments);
    CHECK_MESSAGE(outcome.code == 2, arguments);
    CHECK_MESSAGE(outcome.errors.find(words) != std::string::npos, outcome.errors);
    CHECK(outcome.output == "");
  };
  refused("", "no command");
  refused("rn s.toml", "did you mean 'run'?");
  refused("run s.toml --untl 1", "did you mean '--until'?");
  refused("run --untl 1 s.toml", "did you mean '--until'?");
  refused("run", "required");
  refused("run none.toml", "none.toml");
  refused("run robot.urdf", "robot.urdf: error: there is no such file");
  refused("run s.toml --colour red", "unknown option '--colour'; see `momentree help run`");
  refused("run s.toml --format xml", "--format xml: error: there is no 'xml'; one of: csv, hdf5");
  refused("run s.toml --format hdf", "did you mean 'hdf5'?");
  refused("gradient s.toml --of x --by y", "unknown command 'gradient'; see `momentree help`");
  refused("swep s.toml", "unknown command 'swep'; did you mean 'sweep'?");
  refused("run s.toml s.toml", "one argument too many: 's.toml'; a call runs one scenario: call it once for each");
  refused("run s.toml --until abc", "--until abc: error: expected a time, not 'abc'; for example --until 2, or --until \"2 s\"");
  refused("run s.toml --until '3 kg'",
          "--until \"3 kg\": error: '3 kg' is a mass (kg), not a time (s); for example 2, or \"2 s\"");
  refused("run s.toml --until -1", "--until -1: error: a time must not be negative");
  refused("run s.toml --until inf", "--until inf: error: expected a time");
  refused("run s.toml --until", "`--until` needs a value");
  refused("view s.toml --svg s.svg --every abc", "--every abc: error: expected a time, not 'abc'; for example --every 2");
  refused("view s.toml --port http", "--port http: error: expected a whole number from 0 to 65535");
  refused("bench --bodies 3", "--bodies 3: error: expected a whole number from 1000 to 100000000");
  refused("help rnu", "unknown command 'rnu'; did you mean 'run'?");
  refused("help view play", "one argument too many: 'play'");
  refused("completion", "bash|zsh|fish is required");
  refused("completion csh", "there is no completion for 'csh'; did you mean 'zsh'?");
  refused("evaluate - --state -", "standard input can be read only once; give one of them as a file");
  refused("view s.toml --every 0.1", "--svg");
  refused("view s.toml --port 65536", "--port");
  refused("view none", "none");
  refused("bench --jsn", "did you mean '--json'?");
  refused("convert s.toml", "--out is required");
  refused("convert s.toml -o s.mjcf", "'.mjcf' files cannot be written; use .toml (a scenario) or .urdf");
  refused("convert s.toml -o s", "the format is unknown: the file name has no ending");
  refused("convert s.toml -o ./s.toml", "it would be overwritten");
  refused("convert s.toml -o s.urdf --mechanism chian", "did you mean 'chain'?");
  refused("convert s.toml -o t.toml --mechanism chain", "--mechanism is only for .urdf");
  CHECK(here.files() == 1);
}

TEST_CASE("help covers the program or a command") {
  const Workplace here;
  CHECK(here.call("-V").output.substr(0, 16) == here.call("--version").output.substr(0, 16));
  CHECK(here.call("help").output == here.call("--help").output);
  CHECK(here.call("help run").output == here.call("run --help").output);
  CHECK(here.call("run -h").output == here.call("run --help").output);
  CHECK(here.call("help").code == 0);
  CHECK(here.call("help").output.ends_with(" kept).\n"));
  CHECK(here.call("help run").says("Usage: momentree run [OPTIONS] scenario\n"));
  for (const char* text : {"help", "help run", "help view", "completion bash", "completion zsh", "completion fish", "man-page"}) {
    const Outcome shown = here.call(text);
    CHECK(shown.code == 0);
    CHECK(shown.errors == "");
    CHECK(shown.output != "");
  }
}

TEST_CASE("evaluate --equilibrium: the pose of rest with its modes, as a state from which runs start") {
  const Workplace here;
  const Outcome shown = here.call("evaluate s.toml --equilibrium");
  CHECK(shown.code == 0);
  CHECK(shown.says("Modes (without damping)"));
  CHECK(shown.says(" Hz"));
  CHECK(shown.says("potential energy           -0.15696 J"));  // of eight links that hang
  const Outcome rest = here.call("evaluate s.toml --equilibrium --json");
  REQUIRE(rest.code == 0);
  io::write_text_file(here.path("rest.json"), rest.output);
  CHECK(here.call("evaluate s.toml --state rest.json --json").output == rest.output);
}

TEST_CASE("- is standard input, wherever a scenario, a model or a state is read") {
  const Workplace here;
  CHECK(here.call("run - --out a --quiet <s.toml").code == 0);
  CHECK(here.call("run s.toml --out b --quiet").code == 0);
  for (const char* file : {"bodies.csv", "joints.csv", "final.json"})
    CHECK(here.text((std::string("a/") + file).c_str()) == here.text((std::string("b/") + file).c_str()));
  CHECK(here.call("run - --quiet <s.toml").code == 0);
  CHECK(here.has("results/stdin/final.json"));
  CHECK(here.call("check - <s.toml").output == "<stdin>: ok: 1 mechanism, 8 bodies, 8 degrees of freedom, 1 event\n");
  CHECK(here.call("check s.toml - <s.toml").says("<stdin>: ok"));
  CHECK(here.call("evaluate s.toml --state - --json <b/final.json").output ==
        here.call("evaluate s.toml --state b/final.json --json").output);
  CHECK(here.call("convert - -o - <s.toml").output == here.call("convert s.toml -o -").output);
  CHECK(here.call("explain - <s.toml").output == here.call("explain s.toml").output);
  CHECK(here.call("compile - -o c.cpp <s.toml").code == 0);
  CHECK(here.call("view - --svg v.svg <s.toml").code == 0);
  // A model identified by its content; files that a scenario names are located in the current folder.
  io::write_text_file(here.path("arm.urdf"),
                      "<robot name='An arm'><link name='base'><inertial><mass value='2'/></inertial></link>\n<x/></robot>");
  CHECK(here.call("check - <arm.urdf").says("<stdin>: ok: 1 mechanism, 1 body"));
  CHECK(here.call("explain - <arm.urdf").says("stdin/base"));
  io::write_text_file(here.path("m.toml"), "format = 1\n[[mechanism]]\nname = \"m\"\nmodel = \"arm.urdf\"\n");
  CHECK(here.call("check - <m.toml").says("<stdin>: ok: 1 mechanism, 1 body"));
  // Its errors have places.
  io::write_text_file(here.path("bad.toml"), replaced(chain, "links", "lynks"));
  CHECK(
      here.call("check - <bad.toml").says("<stdin>:8:1: error: unknown key 'lynks' in [mechanism.chain]; did you mean 'links'?"));
  CHECK(here.call("check - </dev/null").code == 2);
}

TEST_CASE("joints of a model are given drives on the command line, in every command") {
  const Workplace here;
  const std::string inertial = "<inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";
  io::write_text_file(here.path("arm.urdf"),
                      "<robot name='An arm'><link name='base'/><link name='rod'>" + inertial + "</link><link name='tip'>" +
                          inertial +
                          "</link><joint name='pin' type='continuous'><parent link='base'/><child link='rod'/>"
                          "<axis xyz='0 1 0'/></joint><joint name='glue' type='fixed'><parent link='rod'/><child link='tip'/>"
                          "</joint></robot>");
  const std::string set = " --set mechanism.arm.joint.*.damping=0.5 --set mechanism.arm.joint.pin.speed=2";
  CHECK(here.call("evaluate arm.urdf --json" + set).says("\"damping\": 0.5"));
  CHECK(here.call("explain arm.urdf" + set).code == 0);
  CHECK(here.call("run arm.urdf --until 0.1 --quiet --out r" + set).code == 0);
  const Outcome toml = here.call("convert arm.urdf -o -" + set);
  CHECK(toml.says("damping = 0.5"));
  CHECK(toml.says("speed   = 2"));
  const Outcome wrong = here.call("run arm.urdf --set mechanism.arm.joint.pn.damping=1");
  CHECK(wrong.code == 2);
  CHECK(wrong.errors ==
        "--set mechanism.arm.joint.pn.damping=1: error: joint: there is no joint 'pn' in this model; did you mean "
        "'pin'?\n");
}

TEST_CASE("every command takes a model without a scenario") {
  const Workplace here;
  const std::string inertial = "<inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";
  io::write_text_file(here.path("arm.urdf"),
                      "<robot name='An arm'><link name='base'>" + inertial + "</link><link name='rod'>" + inertial +
                          "</link><joint name='pin' type='continuous'><parent link='base'/><child link='rod'/>"
                          "<axis xyz='0 1 0'/></joint><gazebo/></robot>");
  const Outcome check = here.call("check arm.urdf");
  CHECK(check.code == 0);
  CHECK(check.says("arm.urdf: ok: 1 mechanism, 2 bodies, 1 degree of freedom, 0 events"));
  CHECK(check.says("arm.urdf: note: 1 note on this model is not shown; -v shows it\n"));
  CHECK_FALSE(check.says("<gazebo>"));
  for (const char* verbose : {"check arm.urdf -v", "check --verbose arm.urdf", "explain arm.urdf -v", "check arm.urdf --json"})
    CHECK_MESSAGE(here.call(verbose).says("<gazebo> is ignored"), verbose);
  const Outcome explain = here.call("explain arm.urdf");
  CHECK(explain.code == 0);
  CHECK(explain.says("An arm"));
  CHECK(explain.says("arm/rod"));
  CHECK(explain.says("'arm/pin', revolute about y, 2 kg"));
  CHECK(here.call("evaluate arm.urdf --json --set mechanism.arm.root=free").says("\"arm/base\""));
  const Outcome run = here.call("run arm.urdf --until 0.1 --quiet --set world.gravity=[0,0,0]");
  CHECK(run.code == 0);
  CHECK(run.errors == "");  // no notes
  CHECK(here.has("results/arm/final.json"));
  CHECK(here.call("view arm.urdf --svg arm.svg").code == 0);
  const Outcome broken = here.call("run s.urdf");
  CHECK(broken.code == 2);
  io::write_text_file(here.path("bad.urdf"),
                      "<robot name='r'>\n<link name='a'><inertial><mass value='-1'/></inertial></link></robot>");
  for (const char* command : {"run bad.urdf --out o", "check bad.urdf", "evaluate bad.urdf", "explain bad.urdf"}) {
    const Outcome refused = here.call(command);
    CHECK(refused.code == 2);
    CHECK(refused.says("bad.urdf:2:39: error: value: must not be negative"));
  }
  CHECK_FALSE(here.has("o"));
}

TEST_CASE("a full standard output is noticed") {
  if (!fs::exists("/dev/full")) return;
  const Workplace here;
  CHECK(std::system(("'" MOMENTREE_PROGRAM "' explain '" + here.path("s.toml") + "' >/dev/full 2>/dev/null").c_str()) != 0);
}

}  // namespace
}  // namespace momentree
