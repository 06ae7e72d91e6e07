// Joints that follow others: compared with closed forms, and errors in couplings.
#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/results/session.hpp>
#include <momentree/results/summary.hpp>
#include <momentree/scenario/convert/convert.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <tests/bad_input.hpp>

namespace momentree::io {
namespace {

using namespace bad_input;

std::string wheel(const std::string& name, double inertia, const std::string& more = "") {
  return "[[mechanism.body]]\nname = \"" + name + "\"\nmass = 1\ninertia = " + std::to_string(inertia) +
         "\n[mechanism.body.joint]\nkind = \"revolute\"\naxis = [0, 0, 1]\n" + more + "\n";
}
const std::string two = "format = 1\n[[mechanism]]\nname = \"m\"\nroots = 2\n";
const std::string wheels = two + wheel("a", 0.01, "v = 2") + wheel("b", 0.08);

double q(const Simulation& run, int joint) { return run.world().joint({joint}).q[0]; }
double p(const Simulation& run, int joint) { return run.world().joint({joint}).p[0]; }

}  // namespace

TEST_CASE("two coupled wheels swing about their gear as two masses on a spring do") {
  const double m = -0.5, k = 500, inertia_a = 0.01, inertia_b = 0.08;
  const ReadResult read = read_scenario_text(
      wheels + "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nmultiplier = -0.5\nstiffness = 500\n[integrate]\nstep = 1e-4\n",
      "s.toml");
  REQUIRE(read.scenario);
  Simulation run(read.scenario->model, read.scenario->integration);
  // e = b − m a: ë = −k (1/I_b + m²/I_a) e; the spring does not change the momentum p_a + m p_b.
  const double w = std::sqrt(k * (1 / inertia_b + m * m / inertia_a)), rate = -m * 2;
  for (const double t : {0.01, 0.1, 0.5}) {
    REQUIRE(run.run_until(t) == Status::ok);
    CAPTURE(t);
    CHECK(q(run, 1) - m * q(run, 0) == doctest::Approx(rate / w * std::sin(w * t)).epsilon(0).scale(1).epsilon(1e-9));
    CHECK(p(run, 0) + m * p(run, 1) == doctest::Approx(inertia_a * 2).epsilon(1e-13));
  }
  // A branch continues identically, and a coupling ends when one of its joints breaks.
  run.at(0.5).then(break_joint("m/b"));
  REQUIRE(run.run_until(0.501) == Status::ok);
  const double left = p(run, 0);
  REQUIRE(run.run_until(1) == Status::ok);
  CHECK(p(run, 0) == left);
}

TEST_CASE("a coupling by a spring that ended stays ended after a restart") {
  const ReadResult read = read_scenario_text(
      wheels + "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nmultiplier = -0.5\nstiffness = 500\n[integrate]\nstep = 1e-4\n",
      "s.toml");
  REQUIRE(read.scenario);
  Simulation run(read.scenario->model, read.scenario->integration);
  REQUIRE(run.run_until(0.01) == Status::ok);
  run.apply({change_joint("m/b", Revolute{{1, 0, 0}})});
  Simulation again(read.scenario->model, read.scenario->integration);
  restore(again, {read_state(state_json(run.world(), {}, step_memory(run)), "s.json", first_model(again.world()))});
  const double left = p(run, 0);
  for (Simulation* each : {&run, &again}) {
    REQUIRE(each->run_until(0.1) == Status::ok);
    CHECK(p(*each, 0) == left);
  }
}

TEST_CASE("functions that drive coupled joints act beside the springs, and end with them") {
  const ReadResult read = read_scenario_text(
      wheels + "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nmultiplier = -0.5\nstiffness = 500\n[integrate]\nstep = 1e-4\n",
      "s.toml");
  REQUIRE(read.scenario);
  Simulation run(read.scenario->model, read.scenario->integration);
  Simulation without = run.branch();
  run.drive("m/a", [](const EvaluationContext&) { return 0.3; });
  run.drive("m/a", [](const EvaluationContext&) { return 0.2; });  // in place of the former function, not of the spring
  REQUIRE(run.run_until(0.1) == Status::ok);
  CHECK(p(run, 0) - 0.5 * p(run, 1) == doctest::Approx(0.02 + 0.2 * 0.1).epsilon(1e-12));
  CHECK(std::abs(q(run, 1) + 0.5 * q(run, 0)) < 0.05);
  Simulation branch = run.branch();
  for (Simulation* each : {&run, &branch}) each->drive("m/a", {});
  for (Simulation* each : {&run, &branch, &without}) REQUIRE(each->run_until(0.2) == Status::ok);
  for (Simulation* each : {&run, &branch}) CHECK(p(*each, 0) - 0.5 * p(*each, 1) == doctest::Approx(0.04).epsilon(1e-12));
  CHECK(p(without, 0) - 0.5 * p(without, 1) == doctest::Approx(0.02).epsilon(1e-12));
  // The free joint that a break leaves is not coupled, also if it is driven.
  run.apply({break_joint("m/b")});
  const double left = p(run, 0);
  run.drive_all("m/b", [](const EvaluationContext&, std::span<double> efforts) { efforts[0] = 1; });
  run.drive("m/a", [](const EvaluationContext&) { return 1.0; });
  REQUIRE(run.run_until(0.3) == Status::ok);
  CHECK(p(run, 0) == doctest::Approx(left + 0.1).epsilon(1e-12));
}

TEST_CASE("a damped coupling ends in step, and a locked leader holds its followers") {
  const ReadResult read = read_scenario_text(wheels +
                                                 "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nmultiplier = 2\noffset = "
                                                 "\"90 deg\"\nstiffness = 5\ndamping = 0.5\n",
                                             "s.toml");
  REQUIRE(read.scenario);
  CHECK(said(read).find("starts -1.571 rad from where it should follow 'm/a'") != std::string::npos);
  Simulation run(read.scenario->model, read.scenario->integration);
  run.at(1).then(lock("m/a"));
  REQUIRE(run.run_until(1) == Status::ok);
  const double held = q(run, 0);
  REQUIRE(run.run_until(10) == Status::ok);
  CHECK(q(run, 0) == held);
  CHECK(q(run, 1) == doctest::Approx(2 * held + std::acos(0.0)).epsilon(1e-9));
}

TEST_CASE("several joints may follow one") {
  const ReadResult read = read_scenario_text(two.substr(0, two.rfind("roots")) + "roots = 3\n" + wheel("a", 0.01, "v = 1") +
                                                 wheel("b", 0.02) + wheel("c", 0.03) +
                                                 "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nstiffness = 300\n"
                                                 "[[coupling]]\njoint = \"m/c\"\nfollows = \"m/a\"\nstiffness = 200\n",
                                             "s.toml");
  REQUIRE(read.scenario);
  Simulation run(read.scenario->model, read.scenario->integration);
  REQUIRE(run.run_until(1) == Status::ok);
  CHECK(p(run, 0) + p(run, 1) + p(run, 2) == doctest::Approx(0.01).epsilon(1e-12));
  CHECK(run.world().totals().kinetic < 0.5 * 0.01);  // the rest of the energy is in the springs
}

TEST_CASE("the Panda's second finger follows the first if the scenario requests it") {
  const auto panda = [](const std::string& mimic) {
    return read_scenario(MOMENTREE_SOURCE_DIR "/scenarios/panda_lets_go.toml",
                         {"mechanism.panda.mimic=" + mimic, "mechanism.panda.state={ joints = { panda_finger_joint1 = 0.02 } }"});
  };
  const ReadResult read = panda("{ stiffness = 2e4, damping = 20 }"), independent = panda("independent");
  CAPTURE(said(read));
  REQUIRE(read.scenario);
  CHECK(said(read).find("should follow") == std::string::npos);
  REQUIRE(independent.scenario);
  const Model& model = read.scenario->model;
  REQUIRE(model.elements().size() == 1);
  const auto& pair = std::get<elements::SpringCoupling>(model.elements()[0]);
  CHECK(model[pair.joint].joint_name == "panda/panda_finger_joint2");
  CHECK(model[pair.joint].q[0] == 0.02);  // its initial value follows its leader's

  Simulation coupled(model, read.scenario->integration), alone(independent.scenario->model, read.scenario->integration);
  const auto apart = [&](Simulation& run) {
    const Status status = run.run_until(0.2);
    REQUIRE_MESSAGE(status == Status::ok, run.result().reason);
    return std::abs(q(run, pair.joint.index) - q(run, pair.follows.index));
  };
  CHECK(apart(coupled) < 1e-4);
  CHECK(apart(alone) > 10 * apart(coupled));

  // Written as a scenario, it is an ordinary coupling.
  const ReadResult again = read_scenario_text(to_toml(*read.scenario, ".").text, "panda.toml");
  CAPTURE(said(again));
  REQUIRE(again.scenario);
  REQUIRE(again.scenario->model.elements().size() == 1);
  const auto& same = std::get<elements::SpringCoupling>(again.scenario->model.elements()[0]);
  CHECK(again.scenario->model[same.joint].joint_name == "panda/panda_finger_joint2");
  CHECK(same.stiffness == 2e4);
  CHECK(same.damping == 20);
  CHECK(same.multiplier == pair.multiplier);
}

TEST_CASE("an exact coupling holds at the start, in the run and in its documents, until a joint breaks") {
  const std::string text = wheels +
                           "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nmultiplier = -0.5\noffset = 0.25\n"
                           "[[event]]\nat = 0.5\nbreak = \"m/b\"\n[integrate]\nuntil = 1\nstep = 0.01\n";
  const ReadResult read = read_scenario_text(text, "s.toml");
  REQUIRE_MESSAGE(read.scenario, said(read));
  CHECK(read.scenario->model.elements().empty());
  REQUIRE(read.scenario->model.couplings().size() == 1);
  Session session = load_text(text, "s.toml");
  Simulation& sim = session.simulation();
  const auto check = [&] {
    CHECK(q(sim, 1) == doctest::Approx(0.25 - 0.5 * q(sim, 0)).epsilon(1e-13));
    CHECK(sim.world().loop_status().rows == 1);
    CHECK(sim.world().loop_status().rank == 1);
  };
  check();
  REQUIRE(sim.run_until(0.3) == Status::ok);
  check();
  const auto reread = [&] {
    const std::string document = state_json(sim.world(), {}, step_memory(sim));
    Simulation again(read.scenario->model, read.scenario->integration);
    const RestoredState state = read_state(document, "s.json", first_model(again.world()));
    restore(again, {state});
    resume(again, {}, state.memory);
    CHECK(state_json(again.world(), {}, step_memory(again)) == document);
    return document;
  };
  CHECK(reread().find("\"ended\": false") != std::string::npos);
  REQUIRE(session.run() == Status::ok);
  CHECK(sim.world().coupling({0}).ended);
  CHECK(reread().find("\"ended\": true") != std::string::npos);
  CHECK(event_json(sim.events().back()).find(R"("ended_couplings": [{"joint": "m/b", "follows": "m/a"}])") != std::string::npos);

  const ReadResult again = read_scenario_text(to_toml(*read.scenario, ".").text, "s.toml");
  REQUIRE_MESSAGE(again.scenario, said(again));
  CHECK(again.scenario->model.couplings() == read.scenario->model.couplings());
  CHECK(read_scenario_text(to_toml(read.scenario->model, {}), "s.toml").scenario->model.couplings() ==
        read.scenario->model.couplings());
}

TEST_CASE("start values of a document that a coupling does not allow are a warning with both values") {
  const ReadResult read =
      read_scenario_text(wheels + "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nmultiplier = -0.5\n", "s.toml");
  REQUIRE_MESSAGE(read.scenario, said(read));
  const auto warnings = [&](const std::string& joints) {
    Session session(*read.scenario, {read_state("{\"joints\": {\n" + joints + "}}", "a:b.json", read.scenario->model)});
    CHECK(q(session.simulation(), 1) == doctest::Approx(-0.5 * q(session.simulation(), 0)).epsilon(1e-13));
    return rendered(session.schedule());
  };
  CHECK(warnings(R"("m/a": {"q": [0.5], "v": [2]}, "m/b": {"q": [-0.25], "v": [-1]})").empty());
  CHECK(warnings(R"("m/b": {"q": [0.25]})").empty());  // the other one follows from it
  const std::string both = warnings("\"m/a\": {\"q\": [0.5], \"v\": [2]},\n\"m/b\": {\"q\": [-0.3], \"v\": [1]}");
  CHECK(both.starts_with(
      "a:b.json:3:1: warning: the loops and couplings don't allow these start values: 'm/b' starts at -0.25 rad, "
      "not at -0.3 rad; "));
  CHECK(both.find("'m/b' starts at -1 rad/s, not at 1 rad/s") != std::string::npos);
}

TEST_CASE("a coupled joint without a start is within limits that exclude zero, or is named") {
  const auto start = [](const std::string& leader, const std::string& follower, const std::string& document) {
    const std::string text = two + wheel("a", 0.01, leader) + wheel("b", 0.08, follower) +
                             "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nmultiplier = -2\noffset = 0.25\n";
    const ReadResult read = read_scenario_text(text, "s.toml");
    REQUIRE_MESSAGE(read.scenario, said(read));
    CHECK(said(read).empty());
    std::vector<RestoredState> documents;
    if (!document.empty()) documents.push_back(read_state(document, "s.json", read.scenario->model));
    Session session(*read.scenario, documents);
    CHECK(rendered(session.schedule()).empty());
    const JointView a = session.simulation().world().joint({0}), b = session.simulation().world().joint({1});
    CHECK(b.q[0] == doctest::Approx(0.25 - 2 * a.q[0]).epsilon(1e-14));
    CHECK(b.v[0] == doctest::Approx(-2 * a.v[0]).epsilon(1e-14));
    return std::pair(a.q[0], b.q[0]);
  };
  const std::string limits = "limits = { lower = 0.5, upper = 1.2 }\n", low = "limits = { lower = -1, upper = -0.2 }\n";
  CHECK(start("angle = -0.3\nspeed = 2\n", limits, "").first == -0.3);
  CHECK(start(low, "angle = 1.1\nspeed = 2\n" + limits, "").second == 1.1);
  CHECK(start(low, limits, "").first == -0.2);
  CHECK(start(low, limits, R"({"joints": {"m/a": {"q": [-0.4], "v": [1]}}})").first == -0.4);
  CHECK(start(low, limits, R"({"joints": {"m/b": {"q": [0.8], "v": [1]}}})").second == 0.8);
  check({{two + wheel("a", 0.01) + wheel("b", 0.08, limits) + "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\n",
          "s.toml:14:8: error: joint 'm/b': it starts beyond its limits, at 0, where loops or couplings put it; give another "
          "joint of the loop or coupling a start that keeps this one within its limits"}});
}

TEST_CASE("doubled and circular exact couplings are redundant, and held joints stay") {
  const auto status = [](const std::string& couplings) {
    const ReadResult read = read_scenario_text(wheels + couplings, "s.toml");
    REQUIRE_MESSAGE(read.scenario, said(read));
    const World world(read.scenario->model, Variables::velocities);
    return std::pair(world.loop_status().rows, world.loop_status().rank);
  };
  const std::string one = "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nmultiplier = 2\n";
  CHECK(status(one + one) == std::pair(2, 1));
  CHECK(status(one + "[[coupling]]\njoint = \"m/a\"\nfollows = \"m/b\"\nmultiplier = 0.5\n") == std::pair(2, 1));
  CHECK(status(one + "[[coupling]]\njoint = \"m/a\"\nfollows = \"m/b\"\n") == std::pair(2, 2));  // both stay at 0
  CHECK(status(one + "[[coupling]]\njoint = \"m/a\"\noffset = \"20 deg\"\n") == std::pair(2, 2));
  CHECK(status("[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\npolynomial = [0, 1, 0.5]\n") == std::pair(1, 1));
}

TEST_CASE("the Panda's second finger follows the first exactly if the scenario requests it") {
  const ReadResult read = read_scenario(MOMENTREE_SOURCE_DIR "/scenarios/panda_lets_go.toml",
                                        {"mechanism.panda.mimic=exact", "integrate.variables=velocities",
                                         "mechanism.panda.state={ joints = { panda_finger_joint1 = 0.02 } }"});
  REQUIRE_MESSAGE(read.scenario, said(read));
  CHECK(said(read).find("should follow") == std::string::npos);
  REQUIRE(read.scenario->model.couplings().size() == 1);
  const Coupling pair = read.scenario->model.couplings()[0];
  Simulation run(read.scenario->model, read.scenario->integration);
  const Status status = run.run_until(0.2);
  REQUIRE_MESSAGE(status == Status::ok, run.result().reason);
  CHECK(q(run, pair.joint.index) == doctest::Approx(q(run, pair.follows.index)).epsilon(1e-12));
  const ReadResult again = read_scenario_text(to_toml(*read.scenario, ".").text, "panda.toml");
  REQUIRE_MESSAGE(again.scenario, said(again));
  CHECK(again.scenario->model.couplings() == read.scenario->model.couplings());
  const ReadResult wrong = read_scenario(MOMENTREE_SOURCE_DIR "/scenarios/panda_lets_go.toml", {"mechanism.panda.mimic=exactly"});
  CHECK(said(wrong).find("mimic: expected") != std::string::npos);
}

TEST_CASE("couplings that form a cycle are refused at the first of them") {
  const std::string three = two.substr(0, two.rfind("roots")) + "roots = 3\n" + wheel("a", 1) + wheel("b", 1) + wheel("c", 1);
  const auto coupling = [](const char* joint, const char* leader) {
    return "[[coupling]]\nstiffness = 1\njoint = \"m/" + std::string(joint) + "\"\nfollows = \"m/" + leader + "\"\n";
  };
  const auto words = [&](const std::string& couplings) { return said(read_scenario_text(three + couplings, "s.toml")); };
  CHECK(words(coupling("b", "a") + coupling("c", "b") + coupling("c", "a")).empty());
  CHECK(words(coupling("b", "a") + coupling("c", "b") + coupling("a", "c")) ==
        "s.toml:29:1: error: coupling: joint 'm/b' follows 'm/a', which follows 'm/c', which follows 'm/b'; one of them must "
        "lead and follow no other");
}

TEST_CASE("errors in a coupling are reported at its place") {
  const auto refused = [](const std::string& text, const std::string& message) {
    CAPTURE(text);
    const std::string words = said(read_scenario_text(text, "s.toml"));
    CHECK_MESSAGE(words.find(message) != std::string::npos, words);
  };
  const std::string coupling = wheels + "[[coupling]]\n";
  refused(coupling + "joint = \"m/b\"\n", "[[coupling]] has no 'follows'");
  refused(coupling + "joint = \"m/b\"\nstiffness = 1\n", "follows");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/a\"\ndamping = 1\n", "damping: belongs to the spring of a coupling");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/a\"\npolynomial = [1, 2, 3, 4, 5, 6]\n", "expected 1 to 5 numbers");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/a\"\npolynomial = [1, 2]\noffset = 1\n",
          "give either these or the polynomial");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/a\"\npolynomial = [1, 2]\nstiffness = 1\n", "a spring follows by");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/a\"\n[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\noffset = 1\n",
          "error: coupling of 'm/b' with 'm/a': it can't hold from these start values");
  refused(
      coupling + "joint = \"m/b\"\nfollows = \"m/a\"\n[[event]]\nat = 1\nchange = { joint = \"m/a\", kind = \"prismatic\" }\n",
      "change: joint 'm/a' is coupled to another");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/a\"\nstiffness = 0\n", "stiffness");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/b\"\nstiffness = 1\n", "a joint cannot follow itself");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/aa\"\nstiffness = 1\n", "there is no joint 'm/aa'; did you mean 'm/a'?");
  refused(coupling + "joint = \"m/b\"\nfollows = \"m/a\"\nstiffness = \"1 N\"\n", "stiffness");
  refused(coupling +
              "joint = \"m/b\"\nfollows = \"m/a\"\nstiffness = 1\n[[event]]\nat = 1\nchange = { joint = \"m/a\", kind = "
              "\"prismatic\" }\n",
          "change: joint 'm/a' is coupled to another");
  refused(two + wheel("a", 1, "drive = { motion = { sine = { amplitude = 1, frequency = 1 } } }") + wheel("b", 1) +
              "[[coupling]]\njoint = \"m/b\"\nfollows = \"m/a\"\nstiffness = 1\n",
          "the motion of joint 'm/a' is prescribed");
  refused(one_body + "[[mechanism]]\nname = \"n\"\nmimic = { stiffness = 1 }\n[[mechanism.body]]\nname = \"x\"\nmass = 1\n",
          "mimic: only a model has joints that follow others");
}

}  // namespace momentree::io
