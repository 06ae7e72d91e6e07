#include <momentree/scenario/part_reader.hpp>

#include <functional>
#include <string>

#include <doctest/doctest.h>

#include <momentree/momentree.hpp>

using namespace momentree;

namespace {

Value text(const char* words) { return {std::string(words), Place{}}; }
Value number(double x) { return {x, Place{}}; }
Value table(std::initializer_list<std::pair<const char*, Value>> entries) {
  Value::Table all;
  for (const auto& [key, value] : entries) all.push_back({key, Place{}, value});
  return {std::move(all), Place{}};
}

std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const io::InputError& error) {
    return error.what();
  } catch (const Error& error) {
    return "not an InputError: " + error.message();
  }
  return "";
}

Value rod(const char* kind) {
  return table({{"mass", text("2 kg")},
                {"com", {Value::Array{number(0.5), number(0), number(0)}, Place{}}},
                {"inertia", number(0.1)},
                {"joint", table({{"kind", text(kind)}, {"damping", number(0.2)}, {"q", number(0.3)}})}});
}

Simulation two_rods() {
  Model model;
  const BodyId first = model.add({.name = "m/one", .mass = 1, .com = {0.5, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{}});
  model.add({.name = "m/two",
             .mass = 1,
             .com = {0.5, 0, 0},
             .inertia = diagonal(0.1),
             .parent = first,
             .at = {1, 0, 0},
             .joint = Revolute{},
             .joint_name = "m/elbow"});
  return Simulation(model);
}

}  // namespace

TEST_CASE("a body is read with the keys and units of scenario files") {
  const io::BodyPart part = io::PartReader("Model.add").body("m/rod", rod("revolute"));
  CHECK(part.spec.name == "m/rod");
  CHECK(part.spec.joint_name == "m/rod");
  CHECK(part.spec.mass == 2);
  CHECK(part.spec.joint.kind == Kind::revolute);
  CHECK(part.spec.joint.parameters.damping.of(0) == 0.2);
  CHECK(part.spec.q.of(0) == 0.3);
  CHECK(io::PartReader("Model.add").body("rod", rod("revolute")).spec.name == "rod");
}

TEST_CASE("errors begin with the call and have the reader's hints") {
  const auto read = [](const char* kind) {
    return error_of([=] { (void)io::PartReader("Model.add").body("m/rod", rod(kind)); });
  };
  CHECK(read("revolut") == "Model.add: error: unknown joint kind 'revolut'; did you mean 'revolute'?");
  const std::string name = error_of([] { (void)io::PartReader("add").body("m/a*b", rod("revolute")); });
  CHECK(name.find("cannot be named 'a*b'") != std::string::npos);
}

TEST_CASE("a condition with a wildcard is one trigger for each match, and actions act on that match") {
  Simulation sim = two_rods();
  const io::PartReader reader("when");
  const Value event = table({{"when", table({{"reaction_force", text("m/*")}, {"exceeds", number(5)}})}});
  const std::vector<io::TriggerPart> parts = reader.triggers(event, sim.world());
  REQUIRE(parts.size() == 2);
  const std::vector<Action> actions = reader.actions("break", text("m/*"), parts[1], sim.world());
  REQUIRE(actions.size() == 1);
  CHECK(actions[0]->joints() == std::vector<std::string>{"m/elbow"});
  CHECK(reader.actions("lock", text("m/*"), {}, sim.world()).size() == 2);
  CHECK(error_of([&] {
          (void)reader.triggers(table({{"when", table({{"reaction_force", text("m/one")}})}}), sim.world());
        }).find("has no threshold") != std::string::npos);
}

TEST_CASE("parameters of an action have the units of the joint's present kind") {
  Simulation sim = two_rods();
  const Value value = table({{"joint", text("m/elbow")}, {"damping", text("0.5 N m s/rad")}});
  const std::vector<Action> actions = io::PartReader("set").actions("set", value, {}, sim.world());
  REQUIRE(actions.size() == 1);
  const Event event = sim.apply(actions[0]);
  CHECK(event.lost == 0);
  CHECK(sim.world().joint({1}).parameters->damping.of(0) == 0.5);
  const Value wrong = table({{"joint", text("m/elbow")}, {"damping", text("0.5 N s/m")}});
  CHECK(error_of([&] { (void)io::PartReader("set").actions("set", wrong, {}, sim.world()); }).find("damping") !=
        std::string::npos);
}

TEST_CASE("forces act on the bodies of the model, and integration settings are checked") {
  const Simulation sim = two_rods();
  const Value force = table({{"body", text("m/*")}, {"force", {Value::Array{number(1), number(0), number(0)}, Place{}}}});
  CHECK(io::PartReader("add_force").forces(force, sim.world().model()).size() == 2);
  CHECK(io::PartReader("Simulation").integration(table({{"method", text("dopri5")}, {"rtol", number(1e-6)}})).rtol == 1e-6);
  CHECK(error_of([] {
          (void)io::PartReader("Simulation").integration(table({{"step", number(-1)}}));
        }).find("step") != std::string::npos);
}

TEST_CASE("joints are found by their numbers in worlds whose bodies and joints have different ones") {
  Model model;
  const BodyId first = model.add({.name = "m/one", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
  model.add({.name = "m/two", .mass = 1, .inertia = diagonal(1), .parent = first, .at = {1, 0, 0}, .joint = Revolute{}});
  Simulation sim(model);
  sim.apply(reroot("m/two"));
  sim.remove(first);  // the free joint, number 0, now has body 1
  const std::vector<Action> actions = io::PartReader("lock").actions("lock", text("m/one"), {}, sim.world());
  REQUIRE(actions.size() == 1);
  sim.apply(actions[0]);
  CHECK(sim.world().joint({0}).locked == 0b111111);
}

TEST_CASE("an action of an unknown kind is an error") {
  const Simulation sim = two_rods();
  CHECK(error_of([&] {
          (void)io::PartReader("brek").actions("brek", text("m/one"), {}, sim.world());
        }).find("unknown action 'brek'; did you mean 'break'?") != std::string::npos);
}
