// The options of checkpoints; tests/checkpoints kills and resumes runs.
#include <doctest/doctest.h>

#include <momentree/text/files/text_file.hpp>
#include <tests/program.hpp>

namespace momentree {
namespace {

using namespace test;

TEST_CASE("times between checkpoints") {
  const Workplace here;
  for (const char* time : {"60s", "60", "'5 min'", "0.5h", "20ms"})
    CHECK_MESSAGE(here.call("run s.toml --quiet --out r --checkpoint " + std::string(time)).code == 0, time);
  CHECK(here.call("run s.toml --checkpoint 0")
            .says("--checkpoint 0: error: a time between checkpoints must be more than 0; for example --checkpoint 60s"));
  CHECK(here.call("run s.toml --checkpoint -1s").code == 2);
  CHECK(here.call("run s.toml --checkpoint 3kg").says("'3 kg' is a mass (kg), not a time (s)"));
  CHECK(here.call("run s.toml --checkpoint often").says("expected a time, not 'often'"));
  CHECK(here.call("run s.toml --generate --checkpoint 1s").says("--generate cannot be combined with --checkpoint and --resume"));
  CHECK(here.call("run s.toml --generate --resume").code == 2);
}

TEST_CASE("checkpoints change no result, and leave nothing behind") {
  const Workplace here(replaced(chain, "0.3 s", "2 s"));
  CHECK(here.call("run s.toml --quiet --out plain").code == 0);
  CHECK(here.call("run s.toml --quiet --out saved --checkpoint 1us").code == 0);  // after every step
  for (const char* file : {"bodies.csv", "joints.csv", "energy.csv", "final.json", "model.json"})
    CHECK(here.text((std::string("plain/") + file).c_str()) == here.text((std::string("saved/") + file).c_str()));
  CHECK_FALSE(here.has("saved/checkpoint"));
  CHECK_FALSE(here.has("saved.partial"));
}

TEST_CASE("where there is nothing to resume, the run begins; where it is complete, it stays") {
  const Workplace here;
  CHECK(here.call("run s.toml --quiet --out r --resume").code == 0);
  const std::string summary = here.text("r/summary.json");
  const Outcome again = here.call("run s.toml --out r --resume");
  CHECK(again.code == 0);
  CHECK(again.output == "The run is complete already. Results: r\n");
  CHECK(here.text("r/summary.json") == summary);
  io::write_text_file(here.path("r/checkpoint"), "left by a run that was killed after it had published its result");
  CHECK(here.call("run s.toml --out r --resume").code == 0);
  CHECK_FALSE(here.has("r/checkpoint"));
  CHECK(here.call("run s.toml --out r --resume --json").output == summary);
  const Outcome bare = here.call("run s.toml --out r --resume --reactions");
  CHECK((bare.code == 2 && bare.says("complete, but have no reactions")));
  const Outcome plain = here.call("run s.toml --out r --resume --report");
  CHECK((plain.code == 2 && plain.says("complete, but have no report")));
  CHECK(here.text("r/summary.json") == summary);
  CHECK(here.call("run s.toml --quiet --out full --reactions --report").code == 0);
  CHECK(here.call("run s.toml --out full --resume --reactions --report").output ==
        "The run is complete already. Results: full\n");
  CHECK(here.call("run s.toml --quiet --out r --resume --until 0.2").code == 0);  // another run
  CHECK(here.text("r/summary.json") != summary);
}

TEST_CASE("a checkpoint that another program wrote is not touched") {
  const Workplace here;
  std::filesystem::create_directory(here.path("r.partial"));
  io::write_text_file(here.path("r.partial/checkpoint"), "mine");
  CHECK(here.call("run s.toml --quiet --out r --resume").code == 2);
  CHECK(here.text("r.partial/checkpoint") == "mine");
}

}  // namespace
}  // namespace momentree
