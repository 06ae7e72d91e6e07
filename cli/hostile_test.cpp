// Control characters in files, names and arguments must not reach a terminal, and inputs that are too large are refused.
#include <doctest/doctest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include <momentree/base/characters.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/files/text_file.hpp>

namespace momentree {
namespace {

namespace fs = std::filesystem;

const std::string scenario =
    "format = 1\n[[mechanism]]\nname = \"m\"\n[[mechanism.body]]\nname = \"a\"\nmass = 1\ninertia = 1\n"
    "[mechanism.body.joint]\nkind = \"revolute\"\n[integrate]\nuntil = 0.01\n";
// ESC, BEL, C1's CSI, a byte that is not UTF-8, a direction override and a line end.
const std::string hostile = "x\x1b[31m\x07\xC2\x9B\xFF\xE2\x80\xAE\nz";

struct Outcome {
  int code = -1;
  std::string output, errors;
};

class Program {
 public:
  void write(const std::string& name, const std::string& text) const { io::write_text_file(folder_ / name.c_str(), text); }
  /// `limits`: a shell command that runs before it.
  Outcome call(const std::string& arguments, const std::string& limits = "") const {
    const std::string out = folder_ / "stdout", err = folder_ / "stderr";
    const int status = std::system(
        ("cd '" + (folder_ / "") + "' && " + limits + "'" MOMENTREE_PROGRAM "' " + arguments + " >'" + out + "' 2>'" + err + "'")
            .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, io::read_text_file(out), io::read_text_file(err)};
  }

 private:
  io::test::TemporaryFolder folder_;
};

std::string quoted(const std::string& words) { return "'" + words + "'"; }

// Checks that the text contains no control characters other than line ends.
void check_seen(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  CHECK_MESSAGE(first_invisible(text) == std::string::npos, printable(text));
}

TEST_CASE("whatever is in file names, only plain text is printed") {
  const Program program;
  const std::string file = hostile + ".toml";
  program.write(file, scenario);
  program.write(hostile + ".urdf", "<robot name='\xE2\x80\xAE'><link name='l'/></robot>");
  for (const std::string& arguments :
       {"check " + quoted(file), "explain " + quoted(file), "evaluate " + quoted(file), "run --out r " + quoted(file),
        "run --out " + quoted(hostile) + " " + quoted(file), "convert -o - " + quoted(file),
        "view --svg " + quoted(hostile + ".svg") + " " + quoted(file), "check " + quoted(hostile + ".urdf")}) {
    CAPTURE(arguments);
    const Outcome outcome = program.call(arguments);
    CHECK(outcome.code == 0);
    CHECK(!(outcome.output + outcome.errors).empty());
    check_seen(outcome.output);
    check_seen(outcome.errors);
  }
  CHECK(program.call("check " + quoted(file)).output ==
        "x\\x1b[31m\\x07\\u009b\xEF\xBF\xBD\\u202e\\nz.toml: ok: 1 mechanism, 1 body, 1 degree of freedom, 0 events\n");
}

TEST_CASE("whatever is in arguments and in the lines of files, messages are text") {
  const Program program;
  program.write("s.toml", scenario);
  program.write("bad.toml", scenario + "# \x1b[31m\xC2\x9B\xE2\x80\xAE\x07\n" + "x\x1b[31m = \"\xC2\x9B\"\n");
  program.write("name.toml", scenario + "[[event]]\nname = \"a\\u001b[31m\"\nat = 0\nlock = \"m/\\u202e\"\n");
  program.write("title.toml", "title = \"a\\u001b]0;x\\u0007\"\n" + scenario);
  program.write("bytes.toml", scenario + "\xFF\x1b[31m\n");
  program.write("r.urdf",
                "<robot name='r'>\n<link name='\xC2\x9B"
                "31m'/><link name='\xE2\x80\xA8'/></robot>");
  program.write("state.json", "{ \"joints\": { \"m/\\u001b[31m\": { \"q\": [0] } } }");
  const std::string esc = quoted(hostile);
  for (const std::string& arguments : {std::string("check bad.toml"),
                                       std::string("check name.toml"),
                                       std::string("check title.toml"),
                                       std::string("check bytes.toml"),
                                       std::string("check r.urdf"),
                                       std::string("evaluate s.toml --state state.json"),
                                       "evaluate s.toml --state " + esc,
                                       "check " + esc,
                                       esc,
                                       "check --" + esc,
                                       "run s.toml " + esc,
                                       "run s.toml --until " + esc,
                                       "run s.toml --set " + esc,
                                       "check s.toml --set=" + esc,
                                       "evaluate s.toml --set mechanism.m.name=" + esc,
                                       "evaluate s.toml --set title=" + esc,
                                       "convert s.toml -o " + esc,
                                       "view s.toml --look " + esc + " --svg x.svg",
                                       "view s.toml --layout " + esc + " --svg x.svg",
                                       "compile s.toml -o x.cpp --name " + esc,
                                       "bench " + esc,
                                       "play " + esc,
                                       "view " + esc}) {
    CAPTURE(arguments);
    const Outcome outcome = program.call(arguments);
    CHECK(outcome.code == 2);
    CHECK(!(outcome.output + outcome.errors).empty());
    check_seen(outcome.output);
    check_seen(outcome.errors);
  }
  for (const char* file : {"bad.toml", "name.toml", "title.toml", "bytes.toml", "r.urdf"}) {
    const Outcome outcome = program.call(std::string("check --json s.toml ") + file + " " + esc);
    CHECK(outcome.code == 2);
    check_seen(outcome.output);
    CHECK(nlohmann::json::parse(outcome.output)["files"].size() == 3);
  }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("if there is not enough memory, the error reports that and names the file") {
  const Program program;
  program.write("s.toml", "format = 1\n[[mechanism]]\nname = \"m\"\n[mechanism.chain]\nlinks = 1000000\nlength = 1\nmass = 1\n");
  const std::string half = "ulimit -v 500000 && ";
  const Outcome check = program.call("check s.toml", half);
  CHECK(check.code == 2);
  CHECK(check.output.starts_with("s.toml: error: not enough free memory"));
  const Outcome explain = program.call("explain s.toml", half);
  CHECK(explain.code == 2);
  CHECK(explain.errors.starts_with("s.toml: error: not enough free memory"));
}
#endif

}  // namespace
}  // namespace momentree
