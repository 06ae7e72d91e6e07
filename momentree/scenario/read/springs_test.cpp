// Springs between points of bodies in scenarios, state documents, checkpoints and results.
#include <cmath>

#include <doctest/doctest.h>

#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/results/columns/result_column.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/run_record.hpp>
#include <momentree/results/session.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/events/schedule.hpp>
#include <momentree/scenario/test_support.hpp>
#include <tests/bad_input.hpp>

using namespace momentree;
using namespace momentree::io;
using namespace momentree::io::bad_input;

namespace {

// A free body and a pendulum.
const std::string two_bodies =
    one_body +
    "[[mechanism]]\nname = \"n\"\n[[mechanism.body]]\nname = \"b\"\nmass = 2\ninertia = 1\ncom = [1, 0, 0]\n"
    "[mechanism.body.joint]\nname = \"pin\"\nkind = \"revolute\"\naxis = [0, 1, 0]\n";

std::string spring(const std::string& keys = "", const std::string& name = "s") {
  return "[[spring]]\nname = \"" + name +
         "\"\nfrom = { body = \"ground\", point = [1, 0, 3] }\nto = { body = \"n/b\", point = [1, 0, 0] }\n" +
         (keys.empty() ? "stiffness = 10\n" : keys);
}

Scenario read(const std::string& text) {
  ReadResult result = read_scenario_text(text, "s.toml");
  INFO(rendered(result.diagnostics));
  REQUIRE(result.scenario);
  return std::move(*result.scenario);
}
Spring only(const std::string& keys) {
  const Scenario scenario = read(two_bodies + spring(keys));
  REQUIRE(scenario.model.springs().size() == 1);
  return scenario.model.springs()[0];
}

// Two springs, of which one breaks by an event and another by its strength.
std::string swinging(const std::string& integrate = "method = \"dopri5\"\n") {
  return two_bodies + spring("stiffness = \"60 N/m\"\nrest = 2\ndamping = 0.5\ntension_only = true\n", "rope") +
         spring("stiffness = \"20 N/m\"\nrest = 3\nstrength = \"10 N\"\n", "rod") +
         "[[event]]\nat = \"0.7 s\"\nbreak = \"rope\"\n"
         "[[event]]\nname = \"tuned\"\nat = \"0.3 s\"\nset = { joint = \"rope\", stiffness = \"70 N/m\", damping = \"1 N s/m\" "
         "}\n"
         "[integrate]\nuntil = \"2 s\"\n" +
         integrate + "[output]\nevery = \"10 ms\"\n";
}

void run_to(Session& session, double until) {
  static_cast<void>(session.schedule());
  session.simulation().observe(0.01, [](const World&) { return true; });
  REQUIRE(session.simulation().run_until(until));
}

}  // namespace

TEST_CASE("the keys of [[cable]], with units and defaults; scenarios that are written have them") {
  const std::string ends = "from = { body = \"ground\", point = [1, 0, 3] }\nto = { body = \"n/b\", point = [1, 0, 0] }\n";
  const auto cable = [&](const std::string& keys) { return two_bodies + "[[cable]]\nname = \"c\"\n" + ends + keys; };
  const Scenario scenario = read(cable("length = \"350 cm\"\nrestitution = 0.2\nstrength = \"1.5 kN\"\n"));
  REQUIRE(scenario.model.springs().size() == 1);
  const Spring& all = scenario.model.springs()[0];
  CHECK(all.inextensible);
  CHECK(*all.rest == 3.5);
  CHECK(all.restitution == 0.2);
  CHECK(all.strength == 1500);
  CHECK(*read(cable("")).model.springs()[0].rest == 3);
  const Scenario again = read(to_toml(scenario.model));
  CHECK(again.model.springs()[0] == all);
  const Scenario converted = read(to_toml(scenario, "").text);
  CHECK(converted.model.springs()[0] == all);
  const auto says = [&](const std::string& keys, const std::string& part) {
    const ReadResult result = read_scenario_text(cable(keys), "test.toml");
    REQUIRE(!result.scenario);
    const std::string text = rendered(result.diagnostics);
    CAPTURE(text);
    CHECK(text.find(part) != std::string::npos);
  };
  says("length = 2\n", "length: the ends of cable 'c' are farther apart at the start, by 1 m");
  says("restitution = 2\n", "restitution: must be from 0 to 1");
  says("rest = 2\n", "write 'length', as in length = \"12 m\"");
  says("stiffness = 2\n", "a rope that does is a [[spring]] with tension_only = true");
  says("[integrate]\nmethod = \"midpoint\"\n", "does not support contact and cables");
}

TEST_CASE("the keys of [[spring]], with units and defaults") {
  const Spring all =
      only("stiffness = \"2 kN/m\"\nrest = \"50 cm\"\ndamping = \"3 N s/m\"\ntension_only = true\nstrength = \"1.5 kN\"\n");
  CHECK(all.name == "s");
  CHECK(all.from == SpringEnd{ground, {1, 0, 3}});
  CHECK(all.to == SpringEnd{{1}, {1, 0, 0}});
  CHECK(law_of(all) == SpringLaw{2000, 0.5, 3, true, 1500});
  const Spring plain = only("stiffness = 10\n");
  CHECK(law_of(plain) == SpringLaw{10, 3, 0, false, HUGE_VAL});  // relaxed at the start
  const Scenario short_form = read(two_bodies + "[[spring]]\nname = \"m/s\"\nfrom = \"m/a\"\nto = \"n/b\"\ndamping = 2\n");
  CHECK(short_form.model.springs()[0].from == SpringEnd{{0}, {}});
  CHECK(short_form.model.springs()[0].name == "m/s");
}

TEST_CASE("mistakes in [[spring]] are reported where they are, with a remedy") {
  const auto keys = [](const std::string& text) { return two_bodies + spring(text); };
  const auto table = [](const std::string& text) { return two_bodies + "[[spring]]\n" + text; };
  const std::string ends = "from = \"ground\"\nto = \"n/b\"\n", ends_of_s = "name = \"s\"\n" + ends;
  check({
      {keys("stiffness = -1\n"), "s.toml:23:13: error: stiffness: must not be negative"},
      {keys("stiffness = 1\nrest = -1\n"), "s.toml:24:8: error: rest: must not be negative"},
      {keys("stiffness = 1\nstrength = 0\n"), "s.toml:24:12: error: strength: must be greater than 0"},
      {keys("stiffness = \"1 N\"\n"),
       "s.toml:23:13: error: stiffness: '1 N' is a force (N), not a stiffness (N/m); for example 2000, or \"2 kN/m\""},
      {keys("stiffness = 0\n"),
       "s.toml:23:13: error: stiffness: neither stiffness nor damping: the spring exerts no force; for example stiffness = \"1 "
       "kN/m\""},
      {keys("rest = 1\n"),
       "s.toml:19:1: error: stiffness: neither stiffness nor damping: the spring exerts no force; for example stiffness = \"1 "
       "kN/m\""},
      {table("from = \"ground\"\nto = \"n/b\"\nstiffness = 1\n"),
       "s.toml:19:1: error: [[spring]] has no 'name'; name = \"rope\""},
      {table("name = \"s\"\nfrom = \"ground\"\nstiffness = 1\n"),
       "s.toml:19:1: error: [[spring]] has no 'to'; for example to = { body = \"ground\", point = [0, 0, 3] }"},
      {table("name = \"s\"\nfrom = \"n/c\"\nto = \"m/a\"\nstiffness = 1\n"),
       "s.toml:21:8: error: from: there is no body 'n/c'; did you mean 'n/b'?"},
      {table("name = \"s\"\nfrom = \"b\"\nto = \"m/a\"\nstiffness = 1\n"),
       "s.toml:21:8: error: from: there is no body 'b'; use the full name: 'n/b'"},
      {table("name = \"s\"\nfrom = { body = \"world\" }\nto = \"m/a\"\nstiffness = 1\n"),
       "s.toml:21:17: error: from: there is no body 'world'; the ground is \"ground\""},
      {table("name = \"s\"\nfrom = \"n/pin\"\nto = \"m/a\"\nstiffness = 1\n"),
       "s.toml:21:8: error: from: there is no body 'n/pin'; that is the name of a joint"},
      {table("name = \"s\"\nfrom = \"n/*\"\nto = \"m/a\"\nstiffness = 1\n"),
       "s.toml:21:8: error: from: there is no body 'n/*'; it has two ends: name one body"},
      {table("name = \"s\"\nfrom = \"n/b\"\nto = \"n/b\"\nstiffness = 1\n"),
       "s.toml:22:6: error: to: is the same point as 'from'; it acts along the line between two points"},
      {table("name = \"s\"\nfrom = \"n/b\"\nto = { body = \"n/b\", point = [1, 0, 0] }\nstiffness = 1\n"),
       "s.toml:22:6: error: to: is on the same body as 'from'; a force between two points of one body has no effect: one of them "
       "belongs to another body, or to \"ground\""},
      {table("name = \"n/pin\"\n" + ends + "stiffness = 1\n"),
       "s.toml:20:8: error: name: there is a joint 'n/pin' already, on line 16; events refer to springs, cables and joints by "
       "their "
       "names: "
       "give the spring another one"},
      {table("name = \"a/b/c\"\n" + ends + "stiffness = 1\n"),
       "s.toml:20:8: error: name: a spring cannot be named 'b/c': it has a character that is not allowed; a name has no / , \" * "
       "and "
       "no control characters"},
      {table(ends_of_s + "stiffness = 1\n[[spring]]\n" + ends_of_s + "stiffness = 1\n"),
       "s.toml:25:8: error: duplicate spring 's': the name is already used by another on line 20"},
      {table(ends_of_s + "stiffness = 1\nlength = 2\n"),
       "s.toml:24:1: error: unknown key 'length' in [[spring]]; write 'rest', as in rest = \"1.5 m\""},
  });
}

TEST_CASE("events name springs, also by wildcards; what makes no sense for a spring is an error") {
  const std::string springs = two_bodies + spring("", "west guy") + spring("", "east guy");
  const auto event = [&](const std::string& text) { return springs + "[[event]]\n" + text; };
  const Scenario each = read(event("when = { reaction_force = \"* guy\", exceeds = 5 }\nbreak = \"* guy\"\n"));
  REQUIRE(each.events.size() == 2);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string name = k == 0 ? "west guy" : "east guy";
    CHECK(each.events[k].condition->what->joints() == std::vector<std::string>{name});
    CHECK(each.events[k].actions.at(0)->joints() == std::vector<std::string>{name});
  }
  CHECK(read(event("at = 1\nbreak = \"*guy\"\n")).events.size() == 2);
  CHECK(read(event("at = 1\nset = { joint = \"* guy\", stiffness = \"1 N/m\", rest = \"2 cm\" }\n")).events.size() == 2);
  CHECK(read(event("after = \"strength of s\"\nlock = \"n/pin\"\n") + spring("stiffness = 1\nstrength = 3\n")).events.size() ==
        1);
  check({
      {event("at = 1\nlock = \"west guy\"\n"),
       "s.toml:31:8: error: lock: 'west guy' is a spring, not a joint; a spring can break and be set, and has a reaction_force"},
      {event("when = { reaction_torque = \"west guy\", exceeds = 1 }\nbreak = \"n/pin\"\n"),
       "s.toml:30:28: error: reaction_torque: 'west guy' is a spring, not a joint; a spring can break and be set, and has a "
       "reaction_force"},
      {event("at = 1\nbreak = \"west gui\"\n"),
       "s.toml:31:9: error: break: there is no joint or spring 'west gui'; did you mean 'west guy'?"},
      {event("at = 1\nlock = \"* guy\"\n"),
       "s.toml:31:8: error: lock: no joint matches '* guy'; * matches within a name: \"chain/*\""},
      {event("at = 1\nset = { joint = \"west guy\", armature = 2 }\n"),
       "s.toml:31:7: error: set: a spring has only 'stiffness', 'rest', 'damping' and the force of 'strength', each a number"},
      {event("at = 1\nset = { joint = \"west guy\", stiffness = \"2 N m\" }\n"),
       "s.toml:31:41: error: stiffness: '2 N m' is a torque (N m), not a stiffness (N/m); for example 2000, or \"2 kN/m\""},
      {event("at = 1\nbreak = [\"west guy\", \"east guy\"]\n[[event]]\nat = 2\nbreak = \"east guy\"\n"),
       "s.toml:34:9: error: break: spring 'east guy' is broken already on line 31; a spring can break only once"},
      {event("name = \"west guy\"\nat = 1\nweld = { body = \"m/a\", to = \"n/b\" }\nbreak = \"m/a\"\n"),
       "s.toml:32:8: error: weld: there is already a spring 'west guy'; give the action or its event another name"},
  });
}

TEST_CASE("a run that is continued from a document, or from a checkpoint, has the same bits; broken springs are state") {
  for (const char* integrate :
       {"method = \"dopri5\"\n", "method = \"rk4\"\nstep = \"1 ms\"\n", "method = \"dop853\"\nvariables = \"momenta\"\n"}) {
    CAPTURE(integrate);
    const Scenario scenario = read(swinging(integrate));
    const bool adaptive = std::string(integrate).find("rk4") == std::string::npos;
    const auto document = [&](const Session& session) {
      return state_json(session.simulation().world(), session.armed(),
                        adaptive ? step_memory(session.simulation()) : StepMemory{});
    };
    Session whole(scenario);
    run_to(whole, 2);
    REQUIRE(whole.simulation().events().size() == 3);
    CHECK(whole.simulation().events()[1].name == "strength of rod");
    const std::string end = document(whole);
    CHECK(end.find("\"springs\": {") != std::string::npos);
    for (const double stop : {0.2, 0.5, 1.0, 1.5}) {
      CAPTURE(stop);
      Session first(scenario);
      run_to(first, stop);
      std::vector<Diagnostic> problems;
      const auto state = read_state(document(first), "d.json", scenario.model, "", problems);
      REQUIRE(state);
      Session second(scenario, {*state});
      CHECK(second.simulation().world().spring({0}).law == first.simulation().world().spring({0}).law);
      run_to(second, 2);
      CHECK(state_json(second.simulation().world(), {}) == state_json(whole.simulation().world(), {}));

      const Checkpoint saved{{}, 0, first.simulation().run_state(), {}};
      const Checkpoint back = read_checkpoint(checkpoint_bytes(saved), "c");
      Session third(scenario);
      static_cast<void>(third.schedule());
      third.simulation().observe(0.01, [](const World&) { return true; });
      require_fit(third.simulation(), back, "c");
      continue_run(third.simulation(), back);
      REQUIRE(third.simulation().run_until(2));
      CHECK(document(third) == end);
      CHECK(third.simulation().events().size() == 3);

      Checkpoint damaged = back;
      damaged.run.world.engine.topology.springs.push_back({7, true, {}});
      CHECK(test::error_of([&] { require_fit(third.simulation(), damaged, "c"); }).find("is damaged") != std::string::npos);
      damaged.run.world.engine.topology.springs.back() = {0, false, {.stiffness = -1}};
      CHECK(test::error_of([&] { require_fit(third.simulation(), damaged, "c"); }).find("is damaged") != std::string::npos);
    }
  }
}

TEST_CASE("springs of a state document: partial ones, mistakes, and those without effect on models that have none") {
  const Scenario scenario = read(two_bodies + spring());
  const auto restored = [&](const std::string& text) {
    std::vector<Diagnostic> problems;
    const auto state = read_state(text, "d.json", scenario.model, "", problems);
    if (!state) return problems.at(0).message();
    Session session(scenario, {*state});
    const SpringView spring = session.simulation().world().spring({0});
    return std::string(spring.broken ? "broken" : "whole") + " " + std::to_string(static_cast<int>(spring.law.stiffness));
  };
  CHECK(restored("{\"springs\": {\"s\": {\"broken\": true}}}") == "broken 10");
  CHECK(restored("{\"springs\": {\"s\": {\"stiffness\": 25, \"strength\": null, \"tension\": 3}}}") == "whole 25");
  CHECK(restored("{\"springs\": {}}") == "whole 10");
  CHECK(restored("{\"springs\": {\"r\": {}}}") == "d.json:1:14: error: unknown spring 'r'");
  CHECK(restored("{\"springs\": {\"s\": {\"stiffness\": -1}}}").find("stiffness: must not be negative") != std::string::npos);
  CHECK(restored("{\"springs\": {\"s\": {\"brokn\": true}}}").find("unknown key 'brokn'") != std::string::npos);
  CHECK(restored("{\"springs\": {\"s\": 3}}").find("expected a table") != std::string::npos);
  const Scenario without = read(two_bodies);
  CHECK(state_json(Simulation(without.model).world(), {}).find("spring") == std::string::npos);
  CHECK(model_json(Simulation(without.model).world(), "").find("spring") == std::string::npos);
}

TEST_CASE("convert writes springs that read back to the same numbers") {
  const std::string keys = "stiffness = \"2 kN/m\"\nrest = \"50 cm\"\ndamping = 3\ntension_only = true\nstrength = 1500\n";
  const Scenario scenario = read(two_bodies + spring(keys) + spring("", "m/t"));
  CHECK(read(to_toml(scenario.model, scenario.shapes)).model.springs() == scenario.model.springs());
  CHECK(read(to_toml(scenario, "").text).model.springs() == scenario.model.springs());
}

TEST_CASE("springs.csv has lengths, rates and tensions, empty once a spring is broken; a record has the same numbers") {
  const test::TemporaryFolder folder;
  const Scenario scenario = read(swinging());
  Session session(scenario);
  static_cast<void>(session.schedule());
  Simulation& sim = session.simulation();
  const std::string model = model_json(sim.world(), "");
  Recorder files(sim, {}, model, {.directory = folder / "live", .joints = session.joints(), .every = 0.01});
  RunRecord record(sim, {}, model, false);
  std::vector<double> tensions;
  sim.observe(0.01, [&](const World& world) {
    record.observe(sim);
    tensions.resize(record.rows());
    tensions.back() = world.spring({0}).tension;
    return files.observe(world);
  });
  REQUIRE(sim.run_until(2));
  Diagnostic problem;
  const auto column = ResultColumn::find("rod.tension", sim.world(), session.joints(), problem);
  REQUIRE(column);
  CHECK(column->unit() == "N");
  CHECK(std::isnan(column->value(sim)));  // it is broken
  CHECK(!ResultColumn::find("rod.tensions", sim.world(), session.joints(), problem));
  CHECK(problem.hint == "'rod' has length rate tension");
  sim.observe(0, {});
  files.finish("done", session.armed());
  record.finish(sim, "done", session.armed());
  const std::string live = read_text_file(folder / "live/springs.csv");
  CHECK(live.starts_with("time,rope.length,rope.rate,rope.tension,rod.length,rod.rate,rod.tension\n"));
  CHECK(live.ends_with(",,,,,,\n"));
  record.write(folder / "kept", {});
  CHECK(read_text_file(folder / "kept/springs.csv") == live);
  const std::vector<double> rows = record.spring("rope");
  REQUIRE(rows.size() == 3 * record.rows());
  for (std::size_t k = 0; k < record.rows(); ++k) {
    const bool broken = record.times()[k] >= 0.7;
    CHECK(std::isnan(rows[3 * k]) == broken);
    if (!broken) CHECK(rows[3 * k + 2] == tensions[k]);
  }
  CHECK_THROWS_WITH_AS(static_cast<void>(record.spring("rop")), doctest::Contains("did you mean 'rope'"), Error);
  CHECK(read_text_file(folder / "live/events.jsonl").find("\"broken_springs\"") != std::string::npos);
}

TEST_CASE("a model without springs has no springs.csv, and another run removes that of an earlier one") {
  const test::TemporaryFolder folder;
  for (const bool with : {true, false}) {
    const Scenario scenario = read(with ? swinging() : two_bodies + "[integrate]\nuntil = 0.1\n");
    Session session(scenario);
    Recorder files(session.simulation(), {}, "{}", {.directory = folder / "r", .joints = session.joints(), .every = 0.1});
    session.simulation().observe(0.1, [&](const World& world) { return files.observe(world); });
    REQUIRE(session.simulation().run_until(0.1));
    files.finish("done", {});
    CHECK(files.is_published());
    CHECK(is_there(folder / "r/springs.csv") == with);
  }
}
