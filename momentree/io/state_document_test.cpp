#include <momentree/io/state_document.hpp>

#include <doctest/doctest.h>

#include <momentree/io/test_support.hpp>

namespace momentree::io {
namespace {

// Runs with a break of a joint that has another name than its body.
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
  REQUIRE(state.broken.size() == 1);
  CHECK(state.broken[0] == Body{1});
  restore(second, {state});
  CHECK(second.time() == 0.5);
  CHECK(second.world().joint_name({1}) == "arm/link");
  CHECK(second.world().mechanism_names() == first.world().mechanism_names());
  CHECK(state_json(second.world(), armed) == text);
}

TEST_CASE("a restored world goes on as if nothing had happened") {
  Simulation first = broken_arm();
  Simulation second(test::two_mechanisms(), {.step = 0.01});
  restore(second, {read_state(state_json(first.world(), {}), "s.json", second.world().model())});
  first.run_until(0.8);
  second.run_until(0.8);
  CHECK(state_json(first.world(), {}) == state_json(second.world(), {}));
}

TEST_CASE("what it says of the joint that broke") {
  const std::string text = state_json(broken_arm().world(), {});
  CHECK(text.find("\"arm/link\": {\"kind\": \"free\", \"parent\": null, \"child\": \"arm/link\"") != std::string::npos);
  CHECK(text.find("arm/shoulder") == std::string::npos);
  CHECK(text.find("{\"name\": \"arm/link\", \"root\": \"arm/link\", \"bodies\": [\"arm/link\", \"arm/hand\"]}") !=
        std::string::npos);
  CHECK(text.find("\"a\": null, \"reaction\": null") != std::string::npos);
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
  CHECK(mistake(R"({"joints": {"pendulum": {"q": [1, 2]}}})").find("should have 1 numbers, not 2") != std::string::npos);
  CHECK(mistake(R"({"joints": {"pendulum": {"kind": "ball"}}})").find("`kind` of joint 'pendulum' is not that of the model") !=
        std::string::npos);
  CHECK(mistake(R"({"joints": {"arm/shoulder": {"q": [1, 1, 0, 0]}}})").find("quaternion") != std::string::npos);
  CHECK(mistake(R"({"joints": {"pendulum": {"locked": true}}})").find("not supported yet") != std::string::npos);
  CHECK(mistake(R"({"joints": {"pendulum": {"parameters": {"damping": 1}}}})").find("`parameters`") != std::string::npos);
  CHECK(mistake(R"({"bodies": {"pendulun": {}}})").find("did you mean 'pendulum'?") != std::string::npos);
  CHECK(mistake(R"({"mechanisms": []})").find("no joint for body 'arm/base'") != std::string::npos);
  CHECK(mistake(R"({"armed": {"e": {"fired": 0.5}}})").find("should be a count") != std::string::npos);
  CHECK(mistake(R"([1])").find("should be an object") != std::string::npos);
  CHECK(mistake(replaced(whole, "\"bodies\": [\"arm/base\", ", "\"bodies\": [")).find("is in no mechanism") != std::string::npos);
  CHECK(mistake(replaced(whole, "\"root\": \"arm/base\"", "\"root\": \"arm/link\"")).find("`root` does not fit") !=
        std::string::npos);
  CHECK(mistake(replaced(whole, "\"arm/link\", \"arm/hand\"]", "\"arm/link\"]")).find("'arm/hand' is in no mechanism") !=
        std::string::npos);
}

}  // namespace
}  // namespace momentree::io
