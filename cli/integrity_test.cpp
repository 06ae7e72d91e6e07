// Runs the program under failures of its output: full disks, closed outputs, two runs at once, kills.
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <initializer_list>

#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/json.hpp>

namespace momentree {
namespace {

namespace fs = std::filesystem;

const char* const scenario = R"(format = 1
[[mechanism]]
name = "chain"
[mechanism.chain]
links = 4
length = 0.1
mass = 0.1
inertia = 1e-4
axis = [0, 1, 0]
[[event]]
at = 0.05
break = "chain/3"
[integrate]
until = 0.2
)";

struct Outcome {
  int code = -1;
  std::string output, errors;
  bool says(const char* words) const { return (output + errors).find(words) != std::string::npos; }
};

class Folder {
 public:
  Folder() { io::write_text_file(folder_ / "s.toml", scenario); }

  /// Calls the program in the folder. `before`: a shell command that runs first.
  Outcome call(const std::string& arguments, const std::string& before = "true") const {
    const std::string line =
        "cd '" + (folder_ / "") + "' && { " + before + "; '" MOMENTREE_PROGRAM "' " + arguments + "; } >stdout 2>stderr";
    const int status = std::system(line.c_str());
    const Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, text("stdout"), text("stderr")};
    fs::remove(folder_ / "stdout");
    fs::remove(folder_ / "stderr");
    return outcome;
  }
  /// Starts a run that does not end by itself, and waits until its rows are on the disk.
  pid_t start(const char* out) const {
    const std::string file = folder_ / "s.toml", place = folder_ / out;
    const pid_t child = fork();
    if (child == 0) {
      if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
      execl(MOMENTREE_PROGRAM, "momentree", "run", file.c_str(), "--out", place.c_str(), "--quiet", "--until", "1e6", nullptr);
      _exit(127);
    }
    const std::string rows = place + ".partial/bodies.csv";
    std::error_code ignored;
    for (int i = 0; i < 3000 && !(fs::exists(rows, ignored) && fs::file_size(rows, ignored) > 100000); ++i) usleep(10000);
    return child;
  }
  std::string text(const std::string& name) const { return io::read_text_file(path(name)); }
  std::string status(const std::string& name) const {
    return *io::parse_json(text(name + "/summary.json"), name).find("status")->value.string();
  }
  bool has(const std::string& name) const { return fs::exists(path(name)); }
  std::string path(const std::string& name) const { return folder_ / name.c_str(); }
  std::size_t files() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_ / ""), {})); }

 private:
  io::test::TemporaryFolder folder_;
};

int end(pid_t child, int signal) {
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST_CASE("of two runs into one folder the second is refused; a lock ends with its run, however that ends") {
  const Folder here;
  REQUIRE(here.call("run s.toml --out r --quiet").code == 0);
  const std::string earlier = here.text("r/bodies.csv");
  const pid_t first = here.start("r");
  const Outcome second = here.call("run s.toml --out r");
  CHECK(second.code == 2);
  CHECK(second.errors.find("r.partial: error: another run of momentree is writing into this folder") != std::string::npos);
  CHECK_FALSE(second.says("is kept"));
  CHECK(here.text("r/bodies.csv") == earlier);
  CHECK(here.call("run s.toml --out other --quiet").code == 0);
  CHECK(WTERMSIG(end(first, SIGKILL)) == SIGKILL);
  CHECK(here.status("r.partial") == "running, or killed");
  CHECK(here.call("run s.toml --out r --quiet").code == 0);
  CHECK(here.text("r/bodies.csv") == earlier);
  CHECK_FALSE(here.has("r.partial"));
}

TEST_CASE("a run that is killed leaves what can be drawn: rows with the events before them") {
  const Folder here;
  end(here.start("r"), SIGKILL);
  CHECK_FALSE(here.has("r"));
  const std::string events = here.text("r.partial/events.jsonl");
  CHECK(std::ranges::count(events, '\n') == 1);
  const Outcome view = here.call("view r.partial --svg - --every 1000");
  CHECK(view.code == 0);
  CHECK(view.says("chain/3, from 0.05 s"));
}

TEST_CASE("on a full disk a run fails, reports it everywhere, and keeps whole rows") {
  const Folder here;
  const std::string limit = "ulimit -f 40";  // 20 or 40 kB for each file
  const Outcome run = here.call("run s.toml --out r --json --report", limit);
  CHECK(run.code == 1);
  CHECK(run.errors.find("r.partial/bodies.csv: error: cannot write this file: ") != std::string::npos);
  CHECK(run.errors.find("the results so far are kept in r.partial") != std::string::npos);
  CHECK(here.status("r.partial").starts_with("failed: r.partial/bodies.csv: error: "));
  CHECK(run.output == here.text("r.partial/summary.json"));
  CHECK_FALSE(here.has("r.partial/report.html"));
  CHECK_FALSE(here.has("r"));
  for (const char* table : {"bodies.csv", "joints.csv", "energy.csv", "events.jsonl"})
    CHECK_MESSAGE(here.text(std::string("r.partial/") + table).ends_with('\n'), table);
  const Outcome said = here.call("run s.toml --out s", limit);
  CHECK(said.says("Results: s.partial\n"));
  const Outcome small = here.call("run s.toml --out t", "ulimit -f 1");
  CHECK(small.code == 2);
  CHECK(small.errors.find("t: error: the results could not be begun: cannot write this file") != std::string::npos);
  CHECK_FALSE(here.has("t.partial"));
  for (const char* command :
       {"convert s.toml -o o.toml", "compile s.toml -o o.cpp", "view s.toml --svg o.svg", "view s.toml --export o.glb"}) {
    const Outcome file = here.call(command, "ulimit -f 0");
    CHECK(file.code == 2);  // its message is in a file, too
  }
  CHECK(here.files() == 3);  // the scenario, r.partial and s.partial
}

TEST_CASE("a failure to print is an error; a closed output is not mistaken for a file") {
  const Folder here;
  REQUIRE(here.call("run s.toml --out r --quiet").code == 0);
  for (const char* command :
       {"--version", "--help", "run --help", "check s.toml", "check --json s.toml", "evaluate s.toml --json", "explain s.toml",
        "convert s.toml -o -", "compile s.toml -o -", "view r --svg -", "view r --svg r.svg", "run s.toml --out r"}) {
    for (const char* output : {" >/dev/full", " >&-"}) {
      if (!fs::exists("/dev/full")) continue;
      const Outcome outcome = here.call(command + std::string(output));
      CHECK_MESSAGE(outcome.code == 1, (command + std::string(output)));
      CHECK(outcome.errors.find("cannot write to standard output") != std::string::npos);
    }
  }
  CHECK(here.text("r/.momentree").find("Energy") == std::string::npos);
  CHECK(here.status("r") == "done");
  CHECK(here.call("run s.toml --out q >&- 2>&- <&-").code == 1);
  CHECK(here.status("q") == "done");
}

TEST_CASE("outputs that would replace an input, or be mistaken for something else, are refused") {
  const Folder here;
  fs::create_symlink("s.toml", here.path("link.toml"));
  REQUIRE(here.call("convert s.toml -o m.urdf").code == 0);
  REQUIRE(here.call("evaluate s.toml --json >f.json").code == 0);
  io::write_text_file(here.path("t.toml"), "format = 1\n[[mechanism]]\nname = \"m\"\nmodel = \"m.urdf\"\n");
  io::write_text_file(here.path("u.toml"), "state = \"f.json\"\n" + std::string(scenario));
  for (const char* command : {"convert t.toml -o m.urdf", "compile t.toml -o m.urdf", "compile u.toml -o ./f.json"})
    CHECK_MESSAGE(here.call(command).says("it would be overwritten"), command);
  for (const char* command : {"convert s.toml -o ./s.toml", "compile s.toml -o s.toml", "compile s.toml -o link.toml"}) {
    const Outcome outcome = here.call(command);
    CHECK(outcome.code == 2);
    CHECK(outcome.says("it would be overwritten"));
  }
  CHECK(here.text("s.toml") == scenario);
  fs::create_symlink(here.path("s.toml"), here.path("link.glb"));
  const Outcome through_link = here.call("view s.toml --export link.glb");
  CHECK(through_link.code == 2);
  CHECK(through_link.says("it would be overwritten"));
  CHECK(here.text("s.toml") == scenario);
  for (const char* name : {"a.png", "a.PDF", "a.svgz"}) {
    const Outcome outcome = here.call(std::string("view s.toml --svg ") + name);
    CHECK(outcome.code == 2);
    CHECK(outcome.says("only SVG"));
    CHECK_FALSE(here.has(name));
  }
  CHECK(here.call("view s.toml --svg A.SVG").code == 0);
  CHECK(here.call("view s.toml --svg /dev/null").code == 0);
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("a result can't be named like one that is being written") {
  const Folder here;
  const Outcome named = here.call("run s.toml --out r.partial --quiet");
  CHECK(named.code == 2);
  CHECK(named.says("r.partial: error: names that end in .partial are reserved for results that are being written"));
  CHECK_FALSE(here.has("r.partial"));
}

TEST_CASE("a pipe or a link in the place of a result's file is refused, and does not hang") {
  const Folder here;
  REQUIRE(here.call("run s.toml --out r --quiet").code == 0);
  fs::rename(here.path("r/bodies.csv"), here.path("kept"));
  REQUIRE(mkfifo(here.path("r/bodies.csv").c_str(), 0600) == 0);
  const Outcome pipe = here.call("view r --svg r.svg");
  CHECK(pipe.code == 2);
  CHECK(pipe.says("r/bodies.csv: error: this is not a regular file"));
  fs::remove(here.path("r/bodies.csv"));
  fs::create_symlink(here.path("kept"), here.path("r/bodies.csv"));
  const Outcome link = here.call("view r --svg r.svg");
  CHECK(link.code == 2);
  CHECK(link.says("r/bodies.csv: error: this is a symbolic link"));
  CHECK_FALSE(here.has("r.svg"));
}

}  // namespace
}  // namespace momentree
