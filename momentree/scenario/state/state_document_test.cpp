#include <momentree/scenario/state/state_document.hpp>

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include <momentree/results/session.hpp>
#include <momentree/scenario/test_support.hpp>
#include <momentree/text/json_writer.hpp>

namespace momentree::io {
namespace {

// Runs with a break of a joint whose name differs from that of its body.
Simulation broken_arm() {
  Simulation simulation(test::two_mechanisms(), {.step = 0.01});
  simulation.at(0.105).then(break_joint("arm/shoulder"));
  REQUIRE(simulation.run_until(0.5) == Status::ok);
  return simulation;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

std::string mistake(const std::string& text, const std::string& mechanism = "") {
  Simulation simulation(test::two_mechanisms());
  return test::error_of([&] { restore(simulation, {read_state(text, "s.json", simulation.world().model(), mechanism)}); });
}

TEST_CASE("a world comes back bit for bit, changed topology included") {
  const Simulation first = broken_arm();
  const Armed armed = {{"#1", 1}};
  const std::string text = state_json(first.world(), armed);

  Simulation second(test::two_mechanisms());
  const RestoredState state = read_state(text, "s.json", second.world().model());
  CHECK(state.armed == armed);
  REQUIRE(state.forest.changed.size() == 1);
  CHECK(state.forest.changed[0].joint == 1);
  CHECK(state.forest.changed[0].name == "arm/link");
  restore(second, {state});
  CHECK(second.time() == 0.5);
  CHECK(second.world().joint_name({1}) == "arm/link");
  CHECK(second.world().mechanism_names() == first.world().mechanism_names());
  CHECK(state_json(second.world(), armed) == text);
}

TEST_CASE("a restored world continues as if nothing had happened") {
  Simulation first = broken_arm();
  Simulation second(test::two_mechanisms(), {.step = 0.01});
  restore(second, {read_state(state_json(first.world(), {}), "s.json", second.world().model())});
  CHECK(first.run_until(0.8) == Status::ok);
  CHECK(second.run_until(0.8) == Status::ok);
  CHECK(state_json(first.world(), {}) == state_json(second.world(), {}));
}

TEST_CASE("the broken joint in the document") {
  const std::string text = state_json(broken_arm().world(), {});
  CHECK(text.find("\"arm/link\": {\"kind\": \"free\", \"parent\": null, \"child\": \"arm/link\"") != std::string::npos);
  CHECK(text.find("arm/shoulder") == std::string::npos);
  CHECK(text.find("{\"name\": \"arm/link\", \"root\": \"arm/link\", \"bodies\": [\"arm/link\", \"arm/hand\"]}") !=
        std::string::npos);
}

TEST_CASE("accelerations and reactions are written, but not read from documents") {
  const Simulation simulation = broken_arm();
  const World& world = simulation.world();
  const std::string text = state_json(world, {});
  using Json = nlohmann::json;
  const Json document = Json::parse(text);
  const auto numbers = [](const Json& of, const char* key) { return of.at(key).get<std::vector<double>>(); };
  const auto same = [](const std::vector<double>& x, const Vec3& v) { return x == std::vector<double>{v.x, v.y, v.z}; };
  for (int j = 0; j < 4; ++j) {
    const JointForces forces = world.joint_forces({j});
    const Json& joint = document.at("joints").at(std::string(world.joint_name({j})));
    CHECK(numbers(joint, "a") == std::vector<double>(forces.a.begin(), forces.a.end()));
    CHECK(same(numbers(joint.at("reaction"), "force"), forces.reaction.force));
    const Vec3 arm = world.joint({j}).child_at.position;  // in documents, torques are about the child's frame
    CHECK(same(numbers(joint.at("reaction"), "torque"), forces.reaction.torque + cross(arm, forces.reaction.force)));
    const BodyAcceleration& a = world.accelerations()[static_cast<std::size_t>(j)];
    const Json& body = document.at("bodies").at(world.model()[BodyId{j}].name);
    CHECK(same(numbers(body, "linear_acceleration"), a.linear));
    CHECK(same(numbers(body, "angular_acceleration"), a.angular));
  }
  const std::size_t from = text.rfind("\"a\": ["), to = text.find("}}", from) + 1;
  for (const char* other : {"\"a\": null, \"reaction\": null", "\"a\": [99], \"reaction\": {}", "\"a\": [1, 2, 3]"}) {
    Simulation again(test::two_mechanisms());
    restore(again, {read_state(std::string(text).replace(from, to - from, other), "s.json", again.world().model())});
    CHECK(state_json(again.world(), {}) == text);
  }
}

// Successive events of two_mechanisms: every kind of change, a joint on its stop, a re-rooted tree.
const std::vector<std::pair<const char*, std::vector<Action>>>& story() {
  static const std::vector<std::pair<const char*, std::vector<Action>>> all = {
      {"", {lock("arm/shoulder", {1}), set_parameters("arm/wrist", {.damping = 0.5, .armature = {0.25}})}},
      {"", {impulse("arm/hand", {0.1, 0.2, 0.3}, {}, {0, 0.1, 0}), reroot("arm/hand")}},
      {"grasp", {weld("arm/hand", "pendulum")}},
      {"", {lock("arm/wrist"), unlock("arm/shoulder")}},
      {"", {change_joint("grasp", Universal{.axis = {1, 0, 0}, .axis2 = {0, 1, 0}, .damping = {0.1, 0.2}})}},
      {"", {set_parameters("arm/wrist", {.limits = {.lower = -1, .upper = 2, .restitution = 0.5}}), unlock("arm/wrist")}},
      {"", {change_joint("arm/shoulder", Revolute{.axis = {0, 0, 1}}), change_joint("pendulum", Kind::cylindrical)}},
      {"", {break_joint("grasp")}},
      {"", {attach("arm/base", "ground", Ball{.stiffness = 2}, Pose{{0, 0, 1}, {}})}},
      {"", {break_joint("arm/shoulder"), change_joint("pendulum", Kind::weld)}},
  };
  return all;
}

TEST_CASE("after every kind of change a state reads back to the same text and continues to the same bits") {
  for (std::size_t chapters = 1; chapters <= story().size(); ++chapters) {
    CAPTURE(chapters);
    Simulation first(test::two_mechanisms(), {.step = 0.01});
    std::size_t k = 0;
    const auto tell = [&k](Simulation& simulation) {
      REQUIRE(test::error_of([&] { simulation.apply(story()[k].second, story()[k].first); }) == "");
      REQUIRE(simulation.run_until(simulation.time() + 0.05) == Status::ok);
    };
    for (; k < chapters; ++k) tell(first);
    const std::string text = state_json(first.world(), {});

    Simulation second(test::two_mechanisms(), {.step = 0.01});
    restore(second, {read_state(text, "s.json", second.world().model())});
    CHECK(state_json(second.world(), {}) == text);
    CHECK(second.world().mechanism_names() == first.world().mechanism_names());
    for (const std::size_t from = k; k < story().size(); ++k) {
      tell(first);
      const std::size_t now = k;
      tell(second);
      k = now;
      CHECK(state_json(second.world(), {}) == state_json(first.world(), {}));
      CHECK(from <= k);
    }
  }
}

TEST_CASE("locks and new joints in the document") {
  Simulation simulation(test::two_mechanisms(), {.step = 0.01});
  simulation.apply(lock("arm/shoulder", {1}));
  simulation.apply(lock("arm/wrist"));
  simulation.apply(weld("arm/hand", "pendulum"), "grasp");
  const std::string text = state_json(simulation.world(), {});
  CHECK(text.find("\"locked\": [false, true, false], \"reversed\": true") != std::string::npos);
  CHECK(text.find("\"arm/wrist\": {\"kind\": \"revolute\", \"parent\": \"arm/link\", \"child\": \"arm/hand\"") !=
        std::string::npos);
  CHECK(text.find("\"locked\": true, \"reversed\": true") != std::string::npos);
  CHECK(text.find("\"grasp\": {\"kind\": \"weld\", \"parent\": \"pendulum\", \"child\": \"arm/hand\"") != std::string::npos);
  CHECK(text.find("{\"name\": \"pendulum\", \"root\": \"pendulum\"") != std::string::npos);

  CHECK(mistake(text) == "");
  CHECK(mistake(replaced(text, "\"reversed\": true", "\"reversed\": false")).find("already has a joint") != std::string::npos);
  CHECK(mistake(replaced(text, "[false, true, false]", "[false, true]")).find("one entry per degree of freedom, 3, found 2") !=
        std::string::npos);
  CHECK(mistake(replaced(text, "\"kind\": \"weld\"", "\"kind\": \"wled\"")).find("unknown joint kind 'wled'") !=
        std::string::npos);
  CHECK(mistake(replaced(text, "\"kind\": \"weld\", \"parent\": \"pendulum\"", "\"kind\": \"weld\", \"parent\": \"arm/base\""))
            .find("form a cycle") != std::string::npos);
  CHECK(mistake(replaced(text, "\"damping\": 0.01", "\"damping\": -0.01")).find("error: damping: must not be negative") !=
        std::string::npos);
}

TEST_CASE("a joint that rests on its stop continues to rest") {
  Model model({.gravity = {0, 0, -9.81}});
  model.add({.name = "slider",
             .mass = 1,
             .inertia = diagonal(1),
             .joint = Prismatic{.limits = {.lower = -0.1, .upper = std::numeric_limits<double>::infinity()}}});
  Simulation first(model, {.step = 0.01}), second(model, {.step = 0.01});
  REQUIRE(first.run_until(0.5) == Status::ok);
  const std::string text = state_json(first.world(), {});
  CHECK(text.find("\"locked\": false, \"reversed\": false, \"resting\": [-1]") != std::string::npos);
  CHECK(text.find("\"limits\": {\"lower\": -0.1, \"upper\": null, \"rest_speed\": 0.001}") != std::string::npos);
  restore(second, {read_state(text, "s.json", model)});
  CHECK(state_json(second.world(), {}) == text);
  for (Simulation* simulation : {&first, &second}) {
    simulation->apply(impulse("slider", {0, 0, 1}));
    REQUIRE(simulation->run_until(0.6) == Status::ok);
  }
  CHECK(first.world().joint({0}).q[0] > -0.1);
  CHECK(state_json(second.world(), {}) == state_json(first.world(), {}));
}

TEST_CASE("a partial document changes what it names") {
  Simulation simulation(test::two_mechanisms());
  const Model& model = simulation.world().model();
  restore(simulation, {read_state(R"({"time": 2, "joints": {"pendulum": {"q": [0.5], "v": [3]}}})", "s.json", model)});
  CHECK(simulation.time() == 2);
  CHECK(simulation.world().joint({3}).q[0] == 0.5);
  CHECK(simulation.world().joint({3}).v[0] == doctest::Approx(3));
  CHECK(simulation.world().joint({2}).q[0] == 0.7);

  restore(simulation, {read_state(R"({"joints": {"pendulum": {"p": [4]}}})", "s.json", model)});
  CHECK(simulation.world().joint({3}).p[0] == 4);
  CHECK(simulation.world().joint({3}).q[0] == 1);
}

TEST_CASE("one mechanism out of a document of a whole world") {
  const std::string text = state_json(broken_arm().world(), {});
  Simulation simulation(test::two_mechanisms());
  restore(simulation, {read_state(text, "s.json", simulation.world().model(), "pendulum")});
  CHECK(simulation.time() == 0);
  CHECK(simulation.world().joint({3}).q[0] != 1);
  CHECK(simulation.world().joint({2}).q[0] == 0.7);
  CHECK(mistake(text, "arm").find("unknown joint 'arm/link'") != std::string::npos);
}

TEST_CASE("momenta of one mechanism come together") {
  CHECK(mistake(R"({"joints": {"arm/wrist": {"p": [1]}}})").find("`p` of every joint of the mechanism") != std::string::npos);
  CHECK(mistake(R"({"joints": {"arm/wrist": {"p": [1], "v": [2]}}})") == "");
}

TEST_CASE("v and p must agree") {
  Simulation simulation(test::two_mechanisms());
  const std::string text = state_json(simulation.world(), {});
  CHECK(mistake(text) == "");
  const std::string message = mistake(replaced(text, "\"v\": [0], \"p\": [0]", "\"v\": [0.001], \"p\": [0]"));
  CHECK(message.find("`v` of joint 'pendulum' does not fit its `p`") != std::string::npos);
  CHECK(mistake(replaced(text, "\"v\": [0], \"p\": [0]", "\"v\": [1e-7], \"p\": [0]")) == "");
}

TEST_CASE("bad documents are refused with their place") {
  const std::string whole = state_json(Simulation(test::two_mechanisms()).world(), {});
  CHECK(mistake("{\n \"joints\": {\n  \"arm/wirst\": {\"q\": [1]}}}") ==
        "s.json:3:3: error: unknown joint 'arm/wirst'; did you mean 'arm/wrist'?");
  CHECK(mistake(R"({"joint": {}})").find("did you mean 'joints'?") != std::string::npos);
  CHECK(mistake(R"({"joints": {"pendulum": {"q": [1, 2]}}})").find("q: expected 1 number, found a list of 2") !=
        std::string::npos);
  CHECK(mistake(R"({"joints": {"pendulum": {"kind": "ball"}}})").find("kind: is not that of joint 'pendulum' in the model") !=
        std::string::npos);
  CHECK(mistake(R"({"joints": {"arm/shoulder": {"q": [1, 1, 0, 0]}}})").find("quaternion") != std::string::npos);
  CHECK(mistake(R"({"joints": {"pendulum": {"locked": true}}})").find("locked: is not that of joint 'pendulum' in the model") !=
        std::string::npos);
  CHECK(mistake(R"({"joints": {"pendulum": {"parameters": {"damping": 1}}}})").find("parameters: is not that") !=
        std::string::npos);
  CHECK(mistake(R"({"bodies": {"pendulun": {}}})").find("did you mean 'pendulum'?") != std::string::npos);
  CHECK(mistake(R"({"mechanisms": []})").find("no joint for body 'arm/base'") != std::string::npos);
  CHECK(mistake(R"({"armed": {"e": {"fired": 0.5}}})").find("fired: expected a count") != std::string::npos);
  CHECK(mistake(R"([1])").find("this is not a state document") != std::string::npos);
  CHECK(mistake(replaced(whole, "\"bodies\": [\"arm/base\", ", "\"bodies\": [")).find("is in no mechanism") != std::string::npos);
  CHECK(mistake(replaced(whole, "\"root\": \"arm/base\"", "\"root\": \"arm/link\"")).find("root: does not fit") !=
        std::string::npos);
  CHECK(mistake(replaced(whole, "\"arm/link\", \"arm/hand\"]", "\"arm/link\"]")).find("'arm/hand' is in no mechanism") !=
        std::string::npos);
}

TEST_CASE("contacts of a document: what it names exists, and contacts that no longer fit are found anew") {
  Model model({.gravity = {0, 0, -9.81}});
  const BodyId box =
      model.add({.name = "box", .mass = 1, .inertia = diagonal(0.01), .joint = Free{}, .q = {0, 0, 0.1, 1, 0, 0, 0}});
  model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
  model.add_collider({.plane = true});
  Simulation sim(model, {.method = "rk4"});
  REQUIRE(sim.run_until(0.1));
  const std::string text = state_json(sim.world(), {}, step_memory(sim));
  const auto mistake_in = [&](const std::string& from, const std::string& to) {
    std::vector<Diagnostic> problems;
    static_cast<void>(read_state(replaced(text, from, to), "s.json", model, "", problems));
    return rendered(problems);
  };
  CHECK(mistake_in("", "") == "");
  CHECK(mistake_in("\"one\": \"box\"", "\"one\": \"bos\"").find("did you mean 'box'?") != std::string::npos);
  CHECK(mistake_in("\"one\": \"box\"", "\"one\": \"ground\"").find("a contact is between two bodies") != std::string::npos);
  CHECK(mistake_in("\"shapes\": [0, 0]", "\"shapes\": [1, 0]").find("'box' has no collision shape of that number") !=
        std::string::npos);
  CHECK(mistake_in("\"feature\": \"", "\"feature\": \"-").find("feature: expected a whole number") != std::string::npos);
  CHECK(mistake_in("\"state\": \"stick\"", "\"state\": \"stuck\"").find("expected smooth, stick or slip") != std::string::npos);
  CHECK(mistake_in("\"state\": \"stick\"", "\"state\": \"slip\"").find("direction: its length is not 1") != std::string::npos);
  CHECK(mistake_in("\"one\": \"box\"", "\"cable\": \"tow\", \"one\": \"box\"").find("there is no cable 'tow'") !=
        std::string::npos);

  CHECK(mistake_in("\"one\": \"box\"", "\"overlapping\": true, \"one\": \"box\"")
            .find("overlapping: only two bodies that a joint connected can pass through each other") != std::string::npos);
  CHECK(mistake_in("\"contacts\": [", "\"contacts\": [1, {\"one\": \"box\"}, ").find("found a number") != std::string::npos);

  const auto events_from = [&](const std::string& velocity) {
    const std::size_t at = text.find("\"v\": [") + 5;
    std::string changed = text;
    if (!velocity.empty()) changed.replace(at, text.find("\"pdot\"", at) - at, velocity + ", ");  // without `p`
    Simulation again(model, {.method = "rk4"});
    const RestoredState state = read_state(changed, "s.json", model);
    restore(again, {state});
    resume(again, {}, state.memory);
    REQUIRE(again.run_until(0.11));
    std::string names;
    for (const Event& event : again.events()) names += event.name.substr(0, 4) + " ";
    return names;
  };
  CHECK(events_from("") == "");
  CHECK(events_from("[0, 0, 1, 0, 0, 0]") == "lift ");
  CHECK(events_from("[0, 0, -1, 0, 0, 0]") == "impa ");
}

TEST_CASE("a run that continues from a document sees what stops carry that only a contact or a cable presses") {
  constexpr double g = 9.81, mass = 10;
  for (const std::string method : {"dop853", "rk4", "stepping"})
    for (const bool cable : {false, true})
      for (const double at : {-1.0, 0.0, 0.02}) {  // before a run, at its start, and later
        CAPTURE(method);
        CAPTURE(cable);
        CAPTURE(at);
        Model model({.gravity = {0, 0, -g}});
        const BodyId seat =
            model.add({.name = "seat", .mass = mass, .inertia = diagonal(0.5), .joint = Free{}, .q = {0, 0, 0.5, 1, 0, 0, 0}});
        const BodyId part = model.add({.name = "part",
                                       .mass = 1,
                                       .inertia = diagonal(0.01),
                                       .parent = seat,
                                       .at = {0, 0, cable ? 0.4 : -0.4},
                                       .joint = Prismatic{.axis = {0, 0, 1}, .limits = {.upper = 0}}});
        if (cable) {
          model.add_cable({.name = "cable", .from = {ground, {0, 0, 1.9}}, .to = {part, {}}, .length = 1});
        } else {
          model.add_collider({.body = part, .solid = contact::box({0.2, 0.2, 0.2})});
          model.add_collider({.plane = true});
        }
        Simulation first(model, {.method = method, .step = 1e-3}), second(model, {.method = method, .step = 1e-3});
        if (at >= 0) REQUIRE(first.run_until(at));
        const std::string text = state_json(first.world(), {}, step_memory(first));
        const RestoredState state = read_state(text, "s.json", model);
        restore(second, {state});
        resume(second, {}, state.memory);
        if (at > 0) {
          CHECK(state_json(second.world(), {}, step_memory(second)) == text);
          CHECK((text.find("\"resting\": [1]") != std::string::npos));
          CHECK((text.find("\"stop_forces\"") != std::string::npos) == (method == "stepping"));
        }
        second.when(reaction_force("part").exceeds(0.9 * mass * g)).named("loaded");
        second.when(reaction_force("part").below(0.9 * mass * g)).named("unloaded");
        for (Simulation* each : {&first, &second}) REQUIRE(each->run_until(0.04));
        const auto named = [&](const std::string& name) {
          return std::find_if(second.events().begin(), second.events().end(), [&](const Event& e) { return e.name == name; });
        };
        REQUIRE(named("loaded") != second.events().end());
        CHECK(named("loaded")->time == std::max(at, 0.0));
        CHECK(named("unloaded") == second.events().end());
        CHECK((at <= 0 || named("stop") == second.events().end()));
        for (std::size_t i = 0; i < first.world().state().q().size(); ++i)
          CHECK(std::fabs(first.world().state().q()[i] - second.world().state().q()[i]) < 1e-12);
        CHECK(norm(second.world().reaction(model.joint("part")).force) == doctest::Approx(mass * g).epsilon(1e-4));
      }
}

TEST_CASE("bodies that overlap where their joint broke are in the document, and touch once they are apart") {
  Model model({.gravity = {0, 0, -9.81}});
  const BodyId plate = model.add({.name = "plate", .mass = 1, .inertia = diagonal(0.1)});
  model.add_collider({.body = plate, .solid = contact::box({2, 2, 0.1})});
  const BodyId box = model.add({.name = "box",
                                .mass = 1,
                                .inertia = diagonal(0.01),
                                .parent = plate,
                                .at = {0, 0, 0.12},
                                .joint = Revolute{.axis = {0, 0, 1}}});
  model.add_collider({.body = box, .solid = contact::box({0.2, 0.2, 0.2})});
  for (const char* method : {"rk4", "stepping"}) {
    CAPTURE(method);
    Simulation sim(model, {.method = method});
    static_cast<void>(sim.apply(break_joint("box")));
    static_cast<void>(sim.apply(impulse("box", {0, 0, 1})));
    REQUIRE(sim.run_until(0.02));
    const std::string text = state_json(sim.world(), {}, step_memory(sim));
    CHECK(text.find("\"overlapping\": true") != std::string::npos);
    Simulation again(model, {.method = method});
    const RestoredState state = read_state(text, "s.json", model);
    restore(again, {state});
    resume(again, {}, state.memory);
    CHECK(state_json(again.world(), {}, step_memory(again)) == text);
    for (Simulation* each : {&sim, &again}) {
      REQUIRE(each->run_until(0.5));
      CHECK(each->world().motions()[1].pose.position.z == doctest::Approx(0.15).epsilon(1e-6));
    }
    CHECK(state_json(again.world(), {}) == state_json(sim.world(), {}));
  }
}

TEST_CASE("gravity that was changed is in the document; a document that is refused changes nothing") {
  const Model model = test::two_mechanisms();
  Simulation first(model, {.step = 0.01}), second(model, {.step = 0.01});
  REQUIRE(first.run_until(0.1) == Status::ok);
  CHECK(state_json(first.world(), {}).find("gravity") == std::string::npos);
  first.set_gravity({0.5, -1, 3});
  REQUIRE(first.run_until(0.2) == Status::ok);
  const std::string text = state_json(first.world(), {});
  CHECK(text.find("\"gravity\": [0.5, -1, 3]") != std::string::npos);
  CHECK(state_json(first.branch().world(), {}) == text);

  // Of one mechanism: the joints alone.
  restore(second, {read_state(text, "s.json", model, "arm")});
  CHECK(second.world().model().gravity() == model.gravity());

  const std::string before = state_json(second.world(), {});
  const std::size_t at = text.find("\"v\": [") + 6;
  const std::string wrong = text.substr(0, at) + "7, " + text.substr(text.find_first_of(",]", at) + 2);
  std::vector<Diagnostic> problems;
  const std::optional<RestoredState> refused = read_state(wrong, "s.json", model, "", problems);
  REQUIRE_MESSAGE(refused, rendered(problems));
  CHECK_THROWS_WITH(restore(second, {*refused}), doctest::Contains("does not fit its `p`"));
  CHECK(state_json(second.world(), {}) == before);

  restore(second, {read_state(text, "s.json", model)});
  CHECK(state_json(second.world(), {}) == text);
  for (Simulation* simulation : {&first, &second}) REQUIRE(simulation->run_until(0.3) == Status::ok);
  CHECK(state_json(second.world(), {}) == state_json(first.world(), {}));

  CHECK_FALSE(read_state(R"({"gravity": [1, 2], "time": 0})", "s.json", model, "", problems));
  CHECK(rendered(problems) ==
        "s.json:1:13: error: gravity: expected three numbers, found a list of 2; write x, y and z, as in gravity = [1, 2, 0]\n");
}

TEST_CASE("a partial document with momenta restores a world to which a body was added") {
  const Model model = test::two_mechanisms();
  Simulation first(model), second(model);
  first.add({.name = "new/body", .mass = 1, .inertia = diagonal(0.1), .parent = model.body("arm/hand"), .joint = Revolute{}});
  std::string joints;
  for (int j = 0; j < model.size(); ++j) {
    const JointView joint = second.world().joint({j});
    if (joint.name.substr(0, 4) != "arm/" || joint.v.empty()) continue;
    JsonWriter json(joints += joints.empty() ? "" : ", ", 2);
    json.key(joint.name).begin_object().member("q", joint.q).member("p", joint.p).end_object();
  }
  const RestoredState document = read_state("{\"joints\": {" + joints + "}}", "s.json", model);
  for (Simulation* simulation : {&first, &second}) restore(*simulation, {document});
  CHECK(state_json(first.world(), {}) == state_json(second.world(), {}));
}

TEST_CASE("a run that begins with another gravity than the scenario's says so") {
  const auto scenario = std::make_shared<const Scenario>(
      *read_scenario_text("format = 1\n[[mechanism]]\nname = \"a\"\n[mechanism.chain]\nlinks = 1\nlength = 1\nmass = 1\n",
                          "s.toml")
           .scenario);
  const auto warnings = [&](const std::string& gravity) {
    Session session(scenario, {read_state("{\"gravity\": " + gravity + "}", "s.json", scenario->model)});
    return rendered(session.schedule());
  };
  CHECK(warnings("[0, 0, -9.81]") == "");
  CHECK(warnings("[0, 1, -3]") == "s.toml: warning: gravity is that of the state document: [0, 1, -3] m/s²\n");
}

TEST_CASE("a document keeps where a stop acts deeper than its limit") {
  Model model({.gravity = {0, 0, -9.81}});
  model.add({.name = "slider", .mass = 1, .inertia = diagonal(1), .joint = Prismatic{.limits = {.lower = -0.1}}, .q = -0.1});
  Simulation sim(model, {.step = 0.01});
  const std::string text =
      replaced(state_json(sim.world(), {}), "\"reversed\": false", "\"reversed\": false, \"deeper\": [[-0.1001, null]]");
  const RestoredState state = read_state(text, "s.json", model);
  restore(sim, {state});
  resume(sim, {}, state.memory);
  CHECK(state_json(sim.world(), {}, {.deeper = step_memory(sim).deeper}) == text);
  REQUIRE(sim.run_until(1) == Status::ok);
  CHECK(sim.world().joint({0}).resting == 1);
  CHECK(sim.world().joint({0}).q[0] == doctest::Approx(-0.1001).epsilon(1e-9));
}

TEST_CASE("all mistakes of a document are reported at once") {
  const Model model = test::two_mechanisms();
  const auto mistakes = [&](const std::string& text) {
    std::vector<Diagnostic> problems;
    CHECK_FALSE(read_state(text, "s.json", model, "", problems));
    return rendered(problems);
  };
  CHECK(mistakes(R"({"time": "1 s", "tiem": 2,
 "joints": {
  "arm/wirst": {"q": [1]},
  "pendulum": {"q": ["1"], "v": [1, 2], "lokced": true, "deeper": [[1]], "at": {"quat": [1, 1, 0, 0]},
               "parameters": {"damping": -1, "limits": {"lower": 1, "upper": null}}}},
 "armed": {"e": {"fired": -1, "looked": [[1]]}}, "integration": {"step": 0}})") ==
        "s.json:1:10: error: time: expected a number, found a string\n"
        "s.json:1:17: error: unknown key 'tiem' in the state document; did you mean 'time'?\n"
        "s.json:3:3: error: unknown joint 'arm/wirst'; did you mean 'arm/wrist'?\n"
        "s.json:4:22: error: q: expected a number, found a string\n"
        "s.json:4:33: error: v: expected 1 number, found a list of 2\n"
        "s.json:4:41: error: unknown key 'lokced' in joint 'pendulum'; did you mean 'locked'?\n"
        "s.json:4:68: error: deeper: expected where the lower and the upper stop act, two numbers or null\n"
        "s.json:4:89: error: quat: the length of the quaternion is not 1\n"
        "s.json:5:42: error: damping: must not be negative\n"
        "s.json:6:27: error: fired: expected a count\n"
        "s.json:6:42: error: looked: expected 2 numbers, found a list of 1\n"
        "s.json:6:74: error: step: must be greater than 0\n");
  // Joints that form no forest are found only once each of them is right.
  std::string whole = state_json(Simulation(model).world(), {});
  whole = replaced(whole, "\"root\": \"arm/base\"", "\"root\": \"arm/link\"");
  whole = replaced(whole, "\"arm/link\", \"arm/hand\"]", "\"arm/link\"]");
  const std::string two = mistakes(whole);
  CHECK(two.find("root: does not fit the joints") != std::string::npos);
  CHECK(two.find("body 'arm/hand' is in no mechanism") != std::string::npos);
}

}  // namespace
}  // namespace momentree::io
