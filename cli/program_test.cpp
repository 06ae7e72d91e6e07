// Calls the built program as a user would: exit codes, files, messages.
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

TEST_CASE("run writes its files and reports") {
  const Workplace here;
  const Outcome run = here.call("run s.toml");
  CHECK(run.code == 0);
  CHECK(run.errors == "");
  for (const char* words : {"Short chain", "simulation before the change", "topology change", "0.1 s  snap", "break chain/4",
                            "chain  →  chain, chain/4", "Energy balance", "results/s"})
    CHECK_MESSAGE(run.says(words), words);
  for (const char* file : {"bodies.csv", "joints.csv", "events.jsonl", "final.json", "summary.json", "model.json"})
    CHECK_MESSAGE(here.has((std::string("results/s/") + file).c_str()), file);
  CHECK_FALSE(here.has("results/s.partial"));
  CHECK(lines(here.text("results/s/bodies.csv")) == 17);
  CHECK(lines(here.text("results/s/joints.csv")) == 17);
  CHECK(lines(here.text("results/s/events.jsonl")) == 1);
  const nlohmann::json summary = nlohmann::json::parse(here.text("results/s/summary.json"));
  CHECK(summary.at("status") == "done");
  CHECK(summary.at("steps") == 300);
  CHECK(here.text("results/s/joints.csv").find("chain/4.q6") != std::string::npos);
}

TEST_CASE("run --report writes one page with its data, also for a failed run") {
  const Workplace here;
  const Outcome run = here.call("run s.toml --report");
  CHECK(run.code == 0);
  CHECK(run.says("results/s/report.html"));
  const std::string page = here.text("results/s/report.html");
  CHECK(page.starts_with("<!doctype html>"));
  CHECK(page.find("default-src 'none'; script-src 'sha256-") != std::string::npos);
  CHECK(page.find("id=\"recording\">{\"format\": 1") != std::string::npos);
  for (const char* outer : {"src=\"", "href=\"", "url(http"}) CHECK_MESSAGE(page.find(outer) == std::string::npos, outer);
  CHECK(lines(here.text("results/s/energy.csv")) == 17);
  const Outcome wild = here.call("run s.toml --report --quiet --set integrate.step=0.05 --set integrate.until=20 --out wild");
  CHECK(wild.code == 1);
  CHECK(here.text("wild.partial/report.html").find("diverged at") != std::string::npos);
}

TEST_CASE("run --quiet and --json, --out, --set and --until") {
  const Workplace here;
  const Outcome quiet = here.call("run s.toml --out a/b --quiet");
  CHECK(quiet.code == 0);
  CHECK(quiet.output + quiet.errors == "");
  CHECK(here.has("a/b/final.json"));
  const Outcome json = here.call("run s.toml --json --until 0.2 --set integrate.step=2e-3 --set mechanism.chain.chain.links=9");
  CHECK(json.code == 0);
  CHECK(json.errors == "");
  CHECK(json.output == here.text("results/s/summary.json"));
  const nlohmann::json summary = nlohmann::json::parse(json.output);
  CHECK(summary.at("steps") == 100);
  CHECK(summary.at("scenario").at("overrides").size() == 3);
  CHECK(here.text("results/s/bodies.csv").find("chain/9.x") != std::string::npos);
}

TEST_CASE("run --reactions adds the reactions of joints, and changes nothing else") {
  const Workplace here;
  REQUIRE(here.call("run s.toml --out plain").code == 0);
  const Outcome run = here.call("run s.toml --out r --reactions");
  CHECK(run.code == 0);
  CHECK(run.errors == "");
  for (const char* file : {"bodies.csv", "final.json"})
    CHECK_MESSAGE(here.text((std::string("plain/") + file).c_str()) == here.text((std::string("r/") + file).c_str()), file);
  const std::string plain = here.text("plain/joints.csv"), table = here.text("r/joints.csv");
  CHECK(plain.find(".fx") == std::string::npos);
  CHECK(table.find(",chain/4.p5,chain/4.fx,chain/4.fy,chain/4.fz,chain/4.mx,chain/4.my,chain/4.mz,chain/5.q0,") !=
        std::string::npos);
  const auto columns = [](const std::string& text) { return std::ranges::count(text.substr(0, text.find('\n')), ','); };
  CHECK(columns(table) == columns(plain) + 8 * 6);
  CHECK(lines(table) == 17);
}

TEST_CASE("final.json comes back through evaluate --state, bit for bit") {
  const Workplace here;
  REQUIRE(here.call("run s.toml --out r").code == 0);
  const Outcome again = here.call("evaluate s.toml --state r/final.json --json");
  CHECK(again.code == 0);
  CHECK(again.output == here.text("r/final.json"));
}

TEST_CASE("evaluate --state with another scenario shows the contacts of that one") {
  for (const char* method : {"rk4", "stepping"}) {
    CAPTURE(method);
    const Workplace here;
    io::write_text_file(here.path("box.toml"),
                        "format = 1\n[world]\ngravity = [0, 0, -10]\nfloor = { height = 0, friction = 0.5 }\n"
                        "[[mechanism]]\nname = \"box\"\nroot = \"free\"\npose = { xyz = [0, 0, 0.1] }\n"
                        "[[mechanism.body]]\nname = \"box\"\nmass = 2\ninertia = 0.02\n"
                        "collision = { box = [0.4, 0.4, 0.2] }\n[integrate]\nuntil = 0.1\nmethod = \"" +
                            std::string(method) + "\"\n");
    REQUIRE(here.call("run box.toml --out r").code == 0);
    const auto evaluate = [&](const std::string& change) {
      return here.call("evaluate box.toml --state r/final.json --json" + change);
    };
    const auto forces = [&](const std::string& change) {
      double sum = 0;
      const nlohmann::json state = nlohmann::json::parse(evaluate(change).output);
      for (const auto& contact : state.at("contacts"))
        if (contact.contains("force") && !contact.contains("stepped")) sum += contact.at("force").at(2).get<double>();
      return sum;
    };
    CHECK(here.text("r/final.json") == evaluate("").output);
    const std::string changed = " --set world.gravity='[0, 0, -3]'", lower = " --set world.floor.height=-0.1";
    CHECK(forces(changed) == doctest::Approx(6).epsilon(1e-3));
    CHECK(forces(lower) == 0);
    const Outcome refused = evaluate(" --set world.floor.height=0.05");
    CHECK(refused.code == 2);
    CHECK(refused.says("'box/box' and 'ground' overlap by 0.05 m"));
    CHECK(here.call("run box.toml --set state='\"r/final.json\"' --set world.floor.height=-0.1 --until 0.2 --out s").code == 0);
  }
}

TEST_CASE("all problems of a state document are printed, each in its line") {
  const Workplace here;
  io::write_text_file(here.path("bad.json"), "{\"time\": null,\n \"joints\": {\"chain/9\": {}},\n \"boddies\": {}}\n");
  const Outcome refused = here.call("evaluate s.toml --state bad.json");
  CHECK(refused.code == 2);
  const std::string all =
      "bad.json:1:10: error: time: expected a number, found null\n"
      "bad.json:2:13: error: unknown joint 'chain/9'; did you mean 'chain/1'?\n"
      "bad.json:3:2: error: unknown key 'boddies' in the state document; did you mean 'bodies'?\n";
  CHECK(refused.errors == all);
  io::write_text_file(here.path("from.toml"), "state = \"bad.json\"\n" + std::string(chain));
  CHECK(here.call("check from.toml").output == all);
  CHECK(Json::parse(here.call("check from.toml --json").output).at("errors") == 3);
  CHECK(here.call("run from.toml").errors == all);
}

TEST_CASE("a run that starts from a state ends where the whole run ends") {
  const Workplace here;
  REQUIRE(here.call("run s.toml --out half --until 0.16").code == 0);
  REQUIRE(here.call("run s.toml --out whole").code == 0);
  io::write_text_file(here.path("t.toml"), replaced(chain, "format = 1", "format = 1\nstate = \"half/final.json\""));
  const Outcome rest = here.call("run t.toml --out rest");
  CHECK(rest.code == 0);
  CHECK(here.text("rest/final.json") == here.text("whole/final.json"));
  CHECK(here.text("rest/events.jsonl") == "");
}

TEST_CASE("a run with an event that turns out to be impossible is kept, and reports which and why") {
  // After a quarter turn about the second axis, the joint's first axis, which stays, is parallel to the axis2 given by the
  // change.
  const Workplace here(
      "format = 1\n[world]\ngravity = [0, 0, 0]\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\n"
      "inertia = 1\n[mechanism.body.joint]\nkind = \"universal\"\naxis = [1, 0, 0]\naxis2 = [0, 1, 0]\n"
      "v = [0, 1.5707963267948966]\n[[event]]\nat = 0.5\nlock = { joint = \"m/a\", freedoms = [0] }\n[[event]]\nat = "
      "1\n"
      "change = { joint = \"m/a\", kind = \"universal\", axis2 = [0, 0, 1] }\n[integrate]\nuntil = 2\n");
  CHECK(here.call("check s.toml").code == 0);
  const Outcome run = here.call("run s.toml");
  CHECK(run.code == 1);
  CHECK(run.errors.find("s.toml: error: event '#2' at t = 1 s: change m/a to universal: axis2: is parallel to 'axis'") !=
        std::string::npos);
  CHECK(here.text("results/s.partial/summary.json").find("\"status\": \"event '#2' at t = 1 s: ") != std::string::npos);
  CHECK(lines(here.text("results/s.partial/events.jsonl")) == 1);
  CHECK(here.text("results/s.partial/final.json").find("\"time\": 1,") != std::string::npos);
  CHECK(here.text("results/s.partial/final.json").find("\"locked\": [true, false]") != std::string::npos);
}

TEST_CASE("a run that starts from a changed world ends where the whole run ends, and its events are tried there") {
  const std::string docks =
      "[[event]]\nname = \"dock\"\nat = 0.15\nattach = { body = \"chain/4\", to = \"chain/2\", kind = \"ball\", damping = 1e-4 "
      "}\n"
      "[[event]]\nat = 0.2\nlock = [\"dock\", \"chain/6\"]\n[[event]]\nat = 0.25\nunlock = \"chain/6\"\nbreak = \"dock\"\n";
  const std::string all = replaced(chain, "[integrate]", docks + "[integrate]");
  const Workplace here(all);
  REQUIRE(here.call("run s.toml --out half --until 0.22").code == 0);
  REQUIRE(here.call("run s.toml --out whole").code == 0);
  io::write_text_file(here.path("t.toml"), replaced(all, "format = 1", "format = 1\nstate = \"half/final.json\""));
  CHECK(here.call("run t.toml --out rest").code == 0);
  CHECK(here.text("rest/final.json") == here.text("whole/final.json"));
  CHECK(here.text("rest/joints.csv").find("dock.q3") != std::string::npos);

  const std::string again = replaced(all, "unlock = \"chain/6\"\nbreak = \"dock\"", "lock = \"dock\"");
  io::write_text_file(here.path("u.toml"), replaced(again, "format = 1", "format = 1\nstate = \"half/final.json\""));
  const Outcome check = here.call("check u.toml");
  CHECK(check.code == 0);
  CHECK(check.says("u.toml:29:8: warning: lock: does nothing: it is already locked"));
}

TEST_CASE("a run that diverges is kept, and reports which joint and when") {
  const Workplace here;
  const Outcome run = here.call("run s.toml --set integrate.step=0.02 --set mechanism.chain.chain.damping=1");
  CHECK(run.code == 1);
  CHECK(run.errors.find("s.toml: error: diverged at t = ") != std::string::npos);
  CHECK(run.errors.find("joint 'chain/") != std::string::npos);
  CHECK(run.errors.find("results/s.partial") != std::string::npos);
  CHECK_FALSE(here.has("results/s"));
  CHECK(here.text("results/s.partial/summary.json").find("\"status\": \"diverged at t = ") != std::string::npos);
  CHECK(lines(here.text("results/s.partial/bodies.csv")) >= 2);
  CHECK(nlohmann::json::accept(here.text("results/s.partial/final.json")));
}

TEST_CASE("an interrupted run is kept") {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Workplace here;
    const std::string scenario = here.path("s.toml"), out = here.path("r");
    const pid_t child = fork();
    if (child == 0) {
      if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
      execl(MOMENTREE_PROGRAM, "momentree", "run", scenario.c_str(), "--out", out.c_str(), "--quiet", "--until", "1e6", nullptr);
      _exit(127);
    }
    // The signal handler is installed before the first row; rows are written out once there are many.
    for (int i = 0; i < 1000 && !(here.has("r.partial/bodies.csv") && fs::file_size(here.path("r.partial/bodies.csv")) > 100000);
         ++i)
      usleep(10000);
    kill(child, signal);
    int status = 0;
    waitpid(child, &status, 0);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 3);
    CHECK_FALSE(here.has("r"));
    CHECK(here.text("r.partial/summary.json").find("\"status\": \"interrupted at t = ") != std::string::npos);
    const std::string rows = here.text("r.partial/bodies.csv");
    CHECK(rows.ends_with('\n'));
    const std::string last = rows.substr(rows.rfind('\n', rows.size() - 2) + 1);
    CHECK(std::ranges::count(last, ',') == 56);
  }
}

TEST_CASE("bad input: exit 2, the line, nothing written") {
  const std::array<std::pair<const char*, const char*>, 4> mistakes = {{{"until = \"0.3 s\"", "until = \"0.3 m\""},
                                                                        {"break = \"chain/4\"", "break = \"chain/44\""},
                                                                        {"links = 8", "lnks = 8"},
                                                                        {"step = \"1 ms\"", "step = 0"}}};
  for (const auto& [good, bad] : mistakes) {
    const Workplace here(replaced(chain, good, bad));
    const std::string before = std::string(chain).substr(0, std::string(chain).find(good));
    const std::string place = "s.toml:" + std::to_string(lines(before) + 1) + ":";
    for (const char* command : {"run", "check", "evaluate", "explain"}) {
      const Outcome outcome = here.call(command + std::string(" s.toml"));
      CHECK(outcome.code == 2);
      CHECK_MESSAGE(outcome.says(place.c_str()), (outcome.output + outcome.errors));
    }
    CHECK(here.files() == 1);
  }
}

TEST_CASE("results that cannot be written: exit 2 before the run") {
  const Workplace here;
  fs::create_directory(here.path("mine"));
  io::write_text_file(here.path("mine/notes.txt"), "x");
  CHECK(here.call("run s.toml --out mine").code == 2);
  CHECK(here.call("run s.toml --out s.toml").code == 2);
  CHECK(here.call("run s.toml --out s.toml/below").code == 2);
  CHECK(here.text("mine/notes.txt") == "x");
  CHECK(here.files() == 2);
}

TEST_CASE("convert: the output is a scenario, and converts to itself again") {
  const Workplace here;
  CHECK(here.call("convert s.toml -o a.toml --set integrate.step=0.002").code == 0);
  CHECK(here.call("check a.toml").says("a.toml: ok: 1 mechanism, 8 bodies, 8 degrees of freedom, 1 event"));
  const Outcome again = here.call("convert a.toml -o -");
  CHECK(again.code == 0);
  CHECK(again.says("step  = 0.002"));
  CHECK(again.says("[mechanism.chain]"));
  const Outcome urdf = here.call("convert s.toml -o a.urdf");
  CHECK(urdf.code == 0);
  CHECK(urdf.output.empty());
  CHECK(urdf.says("s.toml: warning: a URDF holds only a model; left out: its gravity, its events"));
  CHECK(urdf.says("s.toml:14:9: warning: URDF cannot express starts"));
  CHECK(here.call("check a.urdf").says("9 bodies, 8 degrees of freedom"));
}

TEST_CASE("check --json: every problem of every file in one document, as docs/command.md shows it") {
  const Workplace here(replaced(chain, "length = \"5 cm\"", "lenght = \"5 cm\""));
  io::write_text_file(here.path("good.toml"), chain);
  io::write_text_file(here.path("stateful.toml"), "state = \"none.json\"\n" + std::string(chain));
  const Outcome outcome = here.call("check s.toml good.toml none.toml stateful.toml --json");
  CHECK(outcome.code == 2);
  CHECK(outcome.errors.empty());
  const Json document = Json::parse(outcome.output);
  CHECK(document.at("errors") == 4);
  CHECK(document.at("warnings") == 0);
  const Json& files = document.at("files");
  REQUIRE(files.size() == 4);
  CHECK(files[0].at("file") == "s.toml");
  CHECK(files[0].at("ok") == false);
  CHECK_FALSE(files[0].contains("bodies"));
  const Json slip = {{"severity", "error"},
                     {"message", "unknown key 'lenght' in [mechanism.chain]"},
                     {"hint", "did you mean 'length'?"},
                     {"file", "s.toml"},
                     {"line", 9},
                     {"column", 1},
                     {"end_line", 9},
                     {"end_column", 7}};
  REQUIRE(files[0].at("diagnostics").size() == 2);
  CHECK(files[0].at("diagnostics")[1] == slip);
  const Json good = {
      {"file", "good.toml"},         {"ok", true}, {"mechanisms", 1}, {"bodies", 8}, {"freedoms", 8}, {"events", 1},
      {"diagnostics", Json::array()}};
  CHECK(files[1] == good);
  CHECK(files[2].at("diagnostics")[0].at("line").is_null());
  CHECK(files[3].at("diagnostics")[0].at("file") == "none.json");
  CHECK(here.call("check good.toml --json").code == 0);
  // The keys of the document's example are those in the output.
  const std::string docs = io::read_text_file(MOMENTREE_SOURCE_DIR "/docs/command.md");
  const std::size_t begin = docs.find("```json\n") + 8;
  const Json example = Json::parse(docs.substr(begin, docs.find("```", begin) - begin));
  const auto keys = [](const Json& object) {
    std::vector<std::string> all;
    for (const auto& [key, value] : object.items()) all.push_back(key);
    return all;
  };
  CHECK(keys(example) == keys(document));
  CHECK(keys(example.at("files")[0]) == keys(files[0]));
  CHECK(keys(example.at("files")[0].at("diagnostics")[0]) == keys(slip));
}

TEST_CASE("check, explain, evaluate, view") {
  const Workplace here;
  const Outcome check = here.call("check s.toml none.toml");
  CHECK(check.code == 2);
  CHECK(check.says("s.toml: ok: 1 mechanism, 8 bodies, 8 degrees of freedom, 1 event"));
  CHECK(check.says("none.toml"));
  CHECK(here.call("check s.toml").code == 0);
  const Outcome explain = here.call("explain s.toml");
  CHECK(explain.code == 0);
  CHECK(explain.says("└─ chain/2 … chain/8"));
  CHECK(explain.says("7 × revolute about z, 10 g each"));
  CHECK(explain.says("at 0.1 s: break chain/4"));
  CHECK(explain.says("588 operations (292 additions, 288 multiplications, 8 divisions) and 8 pairs of sine and cosine"));
  CHECK(explain.says("in a plane           8 bodies"));
  const Outcome robot = here.call("explain '" MOMENTREE_SOURCE_DIR "/scenarios/models/anymal_b/anymal.urdf'");
  CHECK(!robot.says("in a plane"));
  const Outcome code = here.call("explain '" MOMENTREE_SOURCE_DIR "/scenarios/models/anymal_b/anymal.urdf' --code");
  CHECK(code.code == 0);
  if (code.says("revolute: "))  // there is machine code
    for (const char* part : {"inward\n", "// (22), (23): the body and its children", "pdot[0] = "})
      CHECK_MESSAGE(code.says(part), code.output);
  else
    CHECK(code.says("Without steps of their own"));
  const Outcome evaluate = here.call("evaluate s.toml");
  CHECK(evaluate.code == 0);
  CHECK(evaluate.says("chain/8"));
  REQUIRE(here.call("run s.toml --out r").code == 0);
  CHECK(here.call("view r --svg r.svg --every 0.1 --look 0,0,-1").code == 0);
  CHECK(here.text("r.svg").find("<svg") != std::string::npos);
  CHECK(here.call("view r --svg r.svg --look 0,0").code == 2);
  CHECK(here.call("view s.toml --svg s.svg --every 0.1 --look 0,0,-1").code == 0);
  CHECK(here.text("s.svg") == here.text("r.svg"));
  CHECK_FALSE(here.has("results"));
}

TEST_CASE("evaluate prints accelerations and reactions") {
  // A rod released from the horizontal: a = −m g l / (I + m l²) = −g / 2, and the joint bears half its weight.
  const Workplace here(
      "format = 1\n[world]\ngravity = [0, -9.81, 0]\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"rod\"\nmass = 2\n"
      "inertia = 2\ncom = [1, 0, 0]\n[mechanism.body.joint]\nname = \"pin\"\nkind = \"revolute\"\naxis = [0, 0, 1]\n");
  const Outcome text = here.call("evaluate s.toml");
  CHECK(text.code == 0);
  const auto row = [&text](const char* heading) {  // the second line after it
    std::size_t at = text.output.find(heading);
    REQUIRE(at != std::string::npos);
    for (int line = 0; line < 2; ++line) at = text.output.find('\n', at) + 1;
    return text.output.substr(at, text.output.find('\n', at) - at);
  };
  CHECK(row("Joints (").ends_with(" -19.62   -4.905"));
  CHECK(row("Reactions (").starts_with("  m/pin   m/rod "));
  CHECK(row("Reactions (").ends_with("   0 9.81 0    0 0 0"));
  CHECK(row("Accelerations (").ends_with("   0 0 0   0 0 -4.905"));
}

}  // namespace
}  // namespace momentree
