// Compares results as a user would: the first row, and the body, in which two runs differ.
#include <algorithm>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <momentree/text/files/text_file.hpp>
#include <tests/program.hpp>

namespace momentree {
namespace {

using namespace test;

// A folder with two results of one scenario.
struct Twice : Workplace {
  Twice() {
    REQUIRE(call("run s.toml --quiet --out a").code == 0);
    REQUIRE(call("run s.toml --quiet --out b").code == 0);
  }
  std::string change(const char* file, const std::string& what, const std::string& with) const {
    io::write_text_file(path(file), replaced(text(file), what, with));
    return call("compare a b").output;
  }
  // The cell of a row and column of b/FILE, both from 0, is replaced; returns what it was.
  std::string change_cell(const char* file, int row, int column, const std::string& with) const {
    std::string table = text(file);
    std::size_t at = 0;
    for (; row >= 0; --row) at = table.find('\n', at) + 1;
    for (; column > 0; --column) at = table.find(',', at) + 1;
    const std::size_t end = table.find_first_of(",\n", at);
    const std::string was = table.substr(at, end - at);
    io::write_text_file(path(file), table.replace(at, end - at, with));
    return was;
  }
};

TEST_CASE("the results of one scenario are equal") {
  const Twice here;
  const Outcome equal = here.call("compare a b");
  CHECK(equal.code == 0);
  CHECK(equal.output == "The runs are equal: 16 rows, 1 event\n");
  CHECK(nlohmann::json::parse(here.call("replay a b --json").output)["equal"] == true);
}

TEST_CASE("the first row, body and column in which two results differ") {
  const Twice here;
  const std::string later = here.change_cell("b/bodies.csv", 9, 2, "7"),
                    was = here.change_cell("b/bodies.csv", 4, 1 + 2 * 7 + 1, "0.5");
  CHECK(later != was);
  const Outcome differs = here.call("compare a b");
  CHECK(differs.code == 1);
  CHECK(differs.output.starts_with("bodies.csv, row 5, t = 0.08 s: body 'chain/3', y: " + was + " and 0.5, "));
  CHECK(differs.output.find("row 10") == std::string::npos);
  const auto json = nlohmann::json::parse(here.call("replay a b --json").output);
  CHECK(json["equal"] == false);
  CHECK(json["differences"].size() == 1);
  const auto& first = json["differences"][0];
  CHECK(first["file"] == "bodies.csv");
  CHECK(first["row"] == 5);
  CHECK(first["time"] == doctest::Approx(0.08).epsilon(1e-12));
  CHECK(first["name"] == "chain/3");
  CHECK(first["column"] == "y");
  CHECK(first["second"] == "0.5");
}

TEST_CASE("numbers within the tolerance are equal") {
  const Twice here;
  const std::string was = here.change_cell("b/joints.csv", 3, 1, "0.2000001");
  const double apart = std::abs(std::stod(was) - 0.2000001);
  REQUIRE(apart < 1);
  CHECK(here.call("compare a b").says("joints.csv, row 4, t = 0.06 s: joint 'chain/1', q0: "));
  CHECK(here.call("replay a b --tolerance " + std::to_string(1.1 * apart)).code == 0);
  CHECK(here.call("replay a b --tolerance " + std::to_string(0.9 * apart)).code == 1);
  CHECK(here.call("replay a b --tolerance x").says("--tolerance x: error: expected a number of at least 0"));
  CHECK(here.call("replay a b --tolerance -1").code == 2);
}

TEST_CASE("events, without their wall-clock times, and the last state") {
  const Twice here;
  CHECK(here.change("b/events.jsonl", "\"break chain/4\"", "\"break chain/5\"") ==
        "events.jsonl, event 1, t = 0.1 s: event 'snap', actions 0: 'break chain/4' and 'break chain/5'\n");
  CHECK(here.change("b/events.jsonl", "\"break chain/5\"", "\"break chain/4\"").starts_with("The runs are equal"));
  CHECK(here.change("b/events.jsonl", "\"duration_ns\": ", "\"duration_ns\": 1").starts_with("The runs are equal"));
  CHECK(here.change("b/final.json", "\"kind\": \"revolute\"", "\"kind\": \"ball\"") ==
        "final.json: joints chain/1 kind: 'revolute' and 'ball'\n");
  io::write_text_file(here.path("b/events.jsonl"), "");
  CHECK(
      here.call("compare a b").output.starts_with("events.jsonl, event 1, t = 0.1 s: only the first run has the event 'snap'\n"));
}

TEST_CASE("a run that is only longer, one that ended early, and another model") {
  const Twice here;
  REQUIRE(here.call("run s.toml --quiet --out shorter --until 0.21").code == 0);  // its last row is between two others
  const Outcome longer = here.call("replay shorter a");
  CHECK(longer.code == 1);
  CHECK(longer.output.starts_with(
      "bodies.csv, row 12, t = 0.22 s: the first run ends at t = 0.21 s; the second has 5 more rows, up to t = 0.3 s\n"));
  CHECK(longer.output.find("final.json") == std::string::npos);
  CHECK(here.call("replay a shorter").says("the second run ends at t = 0.21 s; the first has 5 more rows"));

  // Killed while it wrote a line.
  std::filesystem::copy(here.path("a"), here.path("cut.partial"));
  for (const char* file : {"cut.partial/bodies.csv", "cut.partial/joints.csv"})
    io::write_text_file(here.path(file), here.text(file).substr(0, here.text(file).size() / 2));
  std::filesystem::remove(here.path("cut.partial/final.json"));
  const Outcome cut = here.call("replay cut.partial a");
  CHECK(cut.code == 1);
  CHECK(cut.says("more rows, up to t = 0.3 s"));
  CHECK_FALSE(cut.says(" and "));
  CHECK(here.call("replay a cut").says("cut: error: there is no such folder; its run did not end: give cut.partial"));

  REQUIRE(here.call("run s.toml --quiet --out more --set mechanism.chain.chain.links=9").code == 0);
  const Outcome model = here.call("replay a more");
  CHECK(model.code == 1);
  CHECK(model.output.starts_with("model.json: "));
  CHECK(model.says("bodies.csv: only the second run has the column x of body 'chain/9'\n"));
  REQUIRE(here.call("run s.toml --quiet --out heavier --set 'mechanism.chain.chain.mass=\"11 g\"'").code == 0);
  CHECK(here.call("replay a heavier").output.starts_with("model.json: bodies chain/1 mass: 0.01 and 0.011\n"));
}

TEST_CASE("contacts: the first pair of bodies and column that differ, and contacts that only one run has") {
  const Workplace here;
  io::write_text_file(here.path("box.toml"), R"(format = 1
[world]
floor = { friction = 0.4 }
[[mechanism]]
name = "box"
root = "free"
pose = { xyz = [0, 0, 0.1] }
[[mechanism.body]]
name = "box"
mass = 2
inertia = 0.0133
collision = { box = [0.2, 0.2, 0.2] }
[integrate]
until = 0.1
[output]
every = 0.05
)");
  for (const char* out : {"a", "b"}) REQUIRE(here.call(std::string("run box.toml --quiet --reactions --out ") + out).code == 0);
  CHECK(here.call("compare a b").code == 0);
  const std::string table = here.text("b/contacts.csv");
  REQUIRE(std::count(table.begin(), table.end(), '\n') == 1 + 3 * 4);  // four corners, at three instants
  const auto second_line = table.find('\n', table.find('\n') + 1);
  const auto third = table.substr(second_line + 1, table.find('\n', second_line + 1) - second_line - 1);
  std::string changed = third;
  changed.replace(changed.rfind(',') + 1, std::string::npos, "7");
  io::write_text_file(here.path("b/contacts.csv"), replaced(table, third, changed));
  const Outcome different = here.call("compare a b");
  CHECK(different.code == 1);
  CHECK(different.output.find("contact 'box/box and ground', slip: ") != std::string::npos);
  io::write_text_file(here.path("b/contacts.csv"), table.substr(0, table.rfind('\n', table.size() - 2) + 1));
  CHECK(here.call("compare a b").output.find("only the first run has contacts from t = 0.1 s on") != std::string::npos);
}

TEST_CASE("folders that are no results are bad input") {
  const Twice here;
  for (const char* arguments : {"replay a none", "replay none a", "replay a s.toml", "replay a .", "replay a", "replay"})
    CHECK_MESSAGE(here.call(arguments).code == 2, arguments);
  io::write_text_file(here.path("b/bodies.csv"), "");
  CHECK(here.call("compare a b").code == 2);
  io::write_text_file(here.path("b/bodies.csv"), "time,x\nnow,1\n");
  CHECK(here.call("compare a b").says("b/bodies.csv:2: error: column 'time': 'now' is not a number"));
}

}  // namespace
}  // namespace momentree
