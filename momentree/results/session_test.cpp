#include <momentree/results/session.hpp>

#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include <momentree/momentree.hpp>
#include <tests/misuse.hpp>

using namespace momentree;

namespace {

const char* const falling =
    "format = 1\n"
    "[integrate]\nuntil = 0.5\nstep = 1e-3\n"
    "[[mechanism]]\nname = \"m\"\n"
    "[[mechanism.body]]\nname = \"rod\"\nmass = 2\ncom = [0.5, 0, 0]\ninertia = [0.01, 0.1, 0.1]\n"
    "[mechanism.body.joint]\nkind = \"revolute\"\naxis = [0, 1, 0]\n"
    "[[event]]\nname = \"drop\"\nat = 0.25\nbreak = \"m/rod\"\n";

}  // namespace

TEST_CASE("a file is loaded and run in two calls: its events happen, and the run ends where the file says") {
  const std::string path = std::string(MOMENTREE_SOURCE_DIR) + "/scenarios/capture.toml";
  io::Session session = io::load(path, {.overrides = {"integrate.until=2"}});
  const RunResult run = session.run();
  CHECK(run);
  CHECK(run.reason.empty());
  CHECK(session.simulation().time() == 2);
  CHECK(session.scenario().path == path);
}

TEST_CASE("a session can be moved before and after it has run") {
  io::Session first = io::load_text(falling, "falling.toml");
  io::Session session = std::move(first);
  REQUIRE(session.simulation().run_until(0.3));
  io::Session later = std::move(session);
  REQUIRE(later.run());
  REQUIRE(later.simulation().events().size() == 1);
  CHECK(later.simulation().events()[0].name == "drop");
  CHECK(later.simulation().events()[0].time == 0.25);
  // From then on it falls: 0.25 s from the height that it had reached.
  CHECK(later.simulation().world().mechanisms().size() == 1);
  CHECK(later.armed().size() == 1);
}

TEST_CASE("the events of a session are not scheduled twice") {
  test::check_stopped({"schedule after load", "scheduled once", [] {
                         io::Session session = io::load_text(falling, "falling.toml");
                         static_cast<void>(session.schedule());
                       }});
}

TEST_CASE("a session starts from a state document instead of the scenario's start") {
  const auto folder = std::filesystem::temp_directory_path() / "momentree_session_test";
  std::filesystem::create_directories(folder);
  const std::string file = (folder / "state.json").string();
  io::Session first = io::load_text(falling, "falling.toml", {.overrides = {"integrate.until=0.3"}});
  REQUIRE(first.run());
  std::ofstream(file) << io::state_json(first.simulation().world(), first.armed());
  io::Session second = io::load_text(falling, "falling.toml", {.state = file});
  CHECK(second.simulation().time() == 0.3);
  REQUIRE(second.run());
  CHECK(second.simulation().events().empty());  // the joint broke before
  std::filesystem::remove_all(folder);
}

TEST_CASE("a file with errors throws all of them, with line and column") {
  std::string text = falling;
  text += "[[event]]\nat = 1\nbrake = \"m/rod\"\n[[event]]\nat = 1\nbreak = \"m/rood\"\n";
  try {
    static_cast<void>(io::load_text(text, "bad.toml"));
    FAIL("no error was thrown");
  } catch (const std::exception& caught) {
    const auto* const error = dynamic_cast<const io::InputError*>(&caught);
    REQUIRE(error != nullptr);
    CHECK(error->diagnostics.size() == 2);
    CHECK(error->where == "bad.toml:21:1");
    CHECK(error->diagnostics[0].line == 21);
    CHECK(error->diagnostics[1].line == 24);
    const std::string all = error->what();
    CHECK(all.find("brake") != std::string::npos);
    CHECK(all.find("rood") != std::string::npos);
  }
  try {
    static_cast<void>(io::load("no/such/file.toml"));
    FAIL("no error was thrown");
  } catch (const Error& error) {
    CHECK(error.where == "no/such/file.toml");
    CHECK_FALSE(error.problem.empty());
  }
}
