// Actions as users see them: names, order at one instant, which mechanism joins which, what is skipped and what is refused.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <momentree/base/error.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>

using namespace momentree;

namespace {

BodySpec part(std::string name, BodyId parent, JointSpec joint, Values q = {}, Values v = {}) {
  return {.name = std::move(name),
          .mass = 1.5,
          .com = {0.2, 0.05, -0.1},
          .inertia = {0.05, 0.06, 0.07, 0.004, -0.003, 0.002},
          .parent = parent,
          .at = Pose{{0.4, 0.1, -0.05}, normalized(Quat{0.9, 0.1, -0.2, 0.3})},
          .joint = std::move(joint),
          .q = q,
          .v = v};
}

// A crane on the ground, a free tug with an arm, a free satellite with a panel: all of them move.
Model yard(Vec3 gravity = {}) {
  Model model({.gravity = gravity});
  const BodyId base = model.add(part("crane/base", ground, Revolute{}, 0.3, 0.7));
  model.add(part("crane/boom", base, Revolute{.axis = {0, 1, 0}, .damping = 0.1}, -0.4, -1.1));
  const BodyId tug = model.add(part("tug/hull", ground, Free{}, {0.5, 1, 2, 1, 0, 0, 0}, {0.1, -0.2, 0.3, 0.4, 0.5, -0.6}));
  const BodyId upper = model.add(part("tug/upper", tug, Revolute{.axis = {1, 0, 0}, .stiffness = 3, .armature = 0.02}, 0.5, 0.9));
  model.add(part("tug/hand", upper, Ball{}, {0.8, 0.6, 0, 0}, {0.3, -0.2, 0.8}));
  const BodyId sat = model.add(part("sat/hull", ground, Free{}, {3, 1, 0, 1, 0, 0, 0}, {-0.3, 0.1, 0, 0.2, 0.1, 0.9}));
  model.add(part("sat/panel", sat, Revolute{.axis = {0, 0, 1}, .stiffness = 2}, 0.2, -0.4));
  return model;
}

std::string refused(Simulation& sim, const std::vector<Action>& actions) {
  try {
    sim.apply(actions);
  } catch (const Error& error) {
    return error.message();
  }
  return "";
}

std::vector<double> bits(const World& world) {
  std::vector<double> all{world.time()};
  for (double x : world.state().q()) all.push_back(x);
  for (double x : world.p()) all.push_back(x);
  for (const BodyMotion& m : world.motions())
    for (double x : {m.pose.position.x, m.pose.rotation.w, m.linear.x, m.linear.y, m.angular.z}) all.push_back(x);
  return all;
}

double fastest_change(const std::vector<BodyMotion>& a, const std::vector<BodyMotion>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max({most, norm(a[i].linear - b[i].linear), norm(a[i].angular - b[i].angular)});
  return most;
}

double furthest_change(const std::vector<BodyMotion>& a, const std::vector<BodyMotion>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max({most, norm(a[i].pose.position - b[i].pose.position),
                     norm(log_rotation(conjugate(a[i].pose.rotation) * b[i].pose.rotation))});
  return most;
}

}  // namespace

TEST_CASE("a capture, a lock and a release: names, mechanisms, parent and child") {
  Simulation sim(yard());
  const Event grasp = sim.apply(weld("sat/panel", "tug/hand"), "grasp");
  CHECK(grasp.mechanisms_before == std::vector<std::string>{"crane", "tug", "sat"});
  CHECK(grasp.mechanisms_after == std::vector<std::string>{"crane", "tug"});  // both were free: `to`'s root is kept
  const World& world = sim.world();
  const int joint = world.find_joint("grasp");
  REQUIRE(joint >= 0);
  CHECK(world.joint({joint}).kind == Kind::weld);
  CHECK(world.joint({joint}).child == world.model().body("sat/panel"));
  CHECK(world.joint({joint}).parent == world.model().body("tug/hand"));
  CHECK(world.find_joint("sat/hull") == -1);  // the free root joint no longer exists
  const JointView hinge = world.joint(world.model().joint("sat/panel"));
  CHECK(hinge.reversed);  // re-rooted, but presented as declared
  CHECK(hinge.child == world.model().body("sat/panel"));
  CHECK(hinge.parent == world.model().body("sat/hull"));
  CHECK(hinge.q[0] == 0.2);

  sim.apply(lock("tug/upper"));
  CHECK(world.joint(world.model().joint("tug/upper")).locked == 1);
  CHECK(world.joint(world.model().joint("tug/upper")).v[0] == 0);

  sim.apply(break_joint("grasp"), "let go");
  CHECK(world.mechanism_names() == std::vector<std::string>{"crane", "tug", "sat/panel"});  // now named after its root body
  // Its free joint would have the panel's name, but the hinge already has that name.
  CHECK(world.find_joint("sat/panel~free") >= 0);
  CHECK(world.find_joint("sat/panel") == world.model().joint("sat/panel").index);
}

TEST_CASE("the grounded partner's root is kept, whichever is named first; the joint has its declared direction") {
  for (const bool crane_first : {false, true}) {
    Simulation sim(yard());
    const Event e = crane_first ? sim.apply(attach("crane/boom", "sat/panel", Ball{}), "hook")
                                : sim.apply(attach("sat/panel", "crane/boom", Ball{}), "hook");
    CHECK(e.mechanisms_after == std::vector<std::string>{"crane", "tug"});
    const JointView hook = sim.world().joint({sim.world().find_joint("hook")});
    CHECK(hook.reversed == crane_first);
    CHECK(sim.world().model()[hook.child].name == (crane_first ? "crane/boom" : "sat/panel"));
    CHECK(sim.world().model()[hook.parent].name == (crane_first ? "sat/panel" : "crane/boom"));
    CHECK(hook.q[0] == 1);  // the present pose is its zero
    // Its frame is at the body's origin, with `to`'s axes.
    CHECK(norm(log_rotation(hook.at.rotation)) < 1e-15);
    const std::vector<BodyMotion>& m = sim.world().motions();
    CHECK(norm(m[static_cast<std::size_t>(hook.parent.index)].pose * hook.at.position -
               m[static_cast<std::size_t>(hook.child.index)].pose.position) < 1e-14);
  }
}

TEST_CASE("impossible actions are refused, name both sides, and change no bit of the world") {
  Simulation sim(yard({0, 0, -9.81}), {.method = "damped"});
  CHECK(sim.run_until(0.05) == Status::ok);
  const std::vector<double> before = bits(sim.world());
  const auto says = [&](const std::vector<Action>& actions, const std::vector<const char*>& words) {
    const std::string message = refused(sim, actions);
    INFO(message);
    for (const char* word : words) CHECK_MESSAGE(message.find(word) != std::string::npos, word);
    CHECK(bits(sim.world()) == before);
    CHECK(sim.events().empty());
  };
  says({weld("tug/hand", "tug/hand")}, {"itself"});
  says({weld("tug/hand", "tug/upper")}, {"already joined", "joint 'tug/hand'"});
  says({attach("sat/hull", "tug/hand", Universal{.axis = {0, 0, 1}, .axis2 = {0, 0, 2}})}, {"axis2", "parallel"});
  says({lock("tug/upper"), unlock("tug/upper")}, {"contradicts", "lock tug/upper", "unlock tug/upper"});
  says({break_joint("tug/upper"), lock("tug/upper")}, {"contradicts", "break tug/upper"});
  says({lock("tug/hand", {3})}, {"no degree of freedom 3", "0 to 2"});
  says({lock("tug/hand"), weld("sat/panel", "tug/hand"), weld("sat/hull", "sat/panel")},
       {"already joined"});  // after two valid ones
  says({change_joint("tug/hand", Kind::revolute)}, {"axis"});
  says({reroot("crane/boom")}, {"attached to the ground"});
  says({set_parameters("tug/upper", {.damping = -1})}, {"damping"});
  CHECK_THROWS_AS(sim.at(1).then(break_joint("tug/elbow")), Error);
  CHECK_THROWS_AS(sim.at(1).then(weld("tug/hand", "tug/elbow")), Error);
  // Locks of different DoFs do not contradict each other.
  CHECK(refused(sim, {lock("tug/hand", {0}), lock("tug/hand", {1})}) == "");
  CHECK(sim.world().joint(sim.world().model().joint("tug/hand")).locked == 3);
  CHECK(refused(sim, {lock("tug/hand", {2}), unlock("tug/hand", {1})}) == "");
  CHECK(sim.world().joint(sim.world().model().joint("tug/hand")).locked == 5);
}

TEST_CASE(
    "an impossible action stops the run before its instant, with a message; an action without effect is skipped and reported") {
  Simulation sim(yard());
  sim.at(0.01).then(break_joint("tug/hand"));
  sim.at(0.02).then(break_joint("tug/hand"));
  sim.at(0.025).then(lock("tug/hand"));
  sim.at(0.03).then(weld("tug/upper", "tug/hull")).named("loop");
  CHECK(sim.run_until(1) == Status::refused);
  CHECK(sim.time() == 0.03);
  CHECK(sim.result().reason.find("event 'loop' at t = 0.03 s: weld tug/upper to tug/hull: ") == 0);
  REQUIRE(sim.events().size() == 3);
  CHECK(sim.events()[1].actions[0].text().find("break tug/hand skipped: ") == 0);
  CHECK(sim.events()[2].actions[0].text().find("lock tug/hand skipped: ") ==
        0);  // the part's free joint has its name, but is another joint
}

TEST_CASE("at one instant: releases, then one impact, then impulses, then parameters, whatever the order of scheduling") {
  const auto run = [](const std::vector<std::vector<Action>>& events) {
    Simulation sim(yard());
    for (const auto& actions : events) {
      auto e = sim.at(0.02);
      for (const Action& action : actions) e.then(action);
    }
    REQUIRE(sim.run_until(0.02) == Status::ok);
    return std::pair{sim.world().motions(), sim.energy()};
  };
  const Action push = impulse("tug/hull", {1, 2, 3}, {0.1, 0.2, 0.3}, {0.1, 0, 0});
  const Action soft = set_parameters("sat/panel", {.stiffness = 1});
  const auto a = run({{break_joint("tug/upper"), lock("tug/hand"), weld("sat/panel", "crane/boom"), push, soft}});
  const auto b = run({{soft, push}, {weld("sat/panel", "crane/boom")}, {lock("tug/hand"), break_joint("tug/upper")}});
  CHECK(fastest_change(a.first, b.first) < 1e-12);
  CHECK(std::fabs(a.second.error) < 1e-10);
  CHECK(std::fabs(b.second.error) < 1e-10);
  CHECK(a.second.lost_in_impacts == doctest::Approx(b.second.lost_in_impacts).epsilon(1e-10));
  CHECK(a.second.released > 0);
  CHECK(a.second.work == doctest::Approx(b.second.work).epsilon(1e-10));
}

TEST_CASE("changes of the kind of joint are one impact with the others, in any order") {
  const Action turn = change_joint("tug/upper", Prismatic{.axis = {0, 1, 0}});
  const Action slide = change_joint("tug/hand", Revolute{.axis = {0, 0, 1}});
  const auto run = [](const std::vector<Action>& actions) {
    Simulation sim(yard());
    sim.apply(actions);
    CHECK(std::fabs(sim.energy().error) < 1e-12);
    CHECK(sim.energy().lost_in_impacts > 1e-3);
    return sim.world().motions();
  };
  const auto one = run({turn, lock("crane/boom"), slide}), other = run({slide, turn, lock("crane/boom")});
  CHECK(fastest_change(one, other) < 1e-12);
}

TEST_CASE("a mechanism remains grounded through a joint that changes at the same instant") {
  const Action turn = change_joint("crane/base", Prismatic{.axis = {0, 1, 0}});
  Simulation sim(yard());
  sim.apply(weld("sat/hull"), "held");
  const auto loops_after = [&sim](const std::vector<Action>& actions) {
    Simulation branch = sim.branch();
    branch.apply(actions);
    return branch.world().loops().size();
  };
  CHECK(loops_after({turn, weld("crane/boom", "sat/panel")}) == 1);
  CHECK(loops_after({weld("crane/boom", "sat/panel"), turn}) == 1);
  CHECK(loops_after({turn, weld("crane/boom", "tug/hand")}) == 0);  // the crane carries the tug, not the other way round
  sim.apply(std::vector<Action>{turn, weld("crane/boom", "tug/hand")});
  CHECK(sim.world().mechanism_names() == std::vector<std::string>{"crane", "sat"});
}

TEST_CASE("a change keeps the coordinates that the new kind can represent, and the pose always") {
  struct Case {
    const char* joint;
    Action action;
    Values q;
    bool lossless;
  };
  const std::vector<Case> cases = {
      {"tug/upper", change_joint("tug/upper", Kind::cylindrical), {0.5, 0}, true},
      {"tug/upper", change_joint("tug/upper", Kind::ball), {std::cos(0.25), std::sin(0.25), 0, 0}, true},
      {"tug/upper", free_joint("tug/upper"), {0, 0, 0, std::cos(0.25), std::sin(0.25), 0, 0}, true},
      {"tug/upper", change_joint("tug/upper", Kind::prismatic), {0}, false},
      {"tug/upper", change_joint("tug/upper", Kind::weld), {}, false},
      {"tug/upper", change_joint("tug/upper", Revolute{.axis = {0, 1, 0}}), {0}, false},
      {"tug/hand", free_joint("tug/hand"), {0, 0, 0, 0.8, 0.6, 0, 0}, true},
      {"tug/hand", change_joint("tug/hand", Universal{.axis = {1, 0, 0}, .axis2 = {0, 1, 0}}), {0, 0}, false},
      {"tug/hull", change_joint("tug/hull", Kind::weld), {}, false},
  };
  for (const Case& c : cases) {
    Simulation sim(yard());
    const std::vector<BodyMotion> before = sim.world().motions();
    const Event e = sim.apply(c.action);
    CAPTURE(c.action.text());
    const JointView joint = sim.world().joint(sim.world().model().joint(c.joint));
    REQUIRE(static_cast<int>(joint.q.size()) == c.q.size());
    for (int i = 0; i < c.q.size(); ++i) CHECK(joint.q[static_cast<std::size_t>(i)] == doctest::Approx(c.q[i]).epsilon(1e-15));
    CHECK(furthest_change(before, sim.world().motions()) < 1e-14);
    CHECK((fastest_change(before, sim.world().motions()) < 1e-12) == c.lossless);
    CHECK((std::fabs(e.lost) < 1e-12) == c.lossless);
    CHECK(std::fabs(sim.energy().error) < 1e-12);
  }
}

TEST_CASE("a part that breaks off and is attached again keeps its pose and velocity, and no energy is lost") {
  Simulation sim(yard());
  const std::vector<BodyMotion> before = sim.world().motions();
  sim.apply(break_joint("sat/panel"));
  sim.apply(attach("sat/panel", "sat/hull", Revolute{.axis = {0, 0, 1}},
                   Pose{{0.4, 0.1, -0.05}, normalized(Quat{0.9, 0.1, -0.2, 0.3})}),
            "hinge");
  CHECK(furthest_change(before, sim.world().motions()) < 1e-14);
  CHECK(fastest_change(before, sim.world().motions()) < 1e-13);
  CHECK(std::fabs(sim.energy().lost_in_impacts) < 1e-13);
}

TEST_CASE("snapshots, branches and undo are exact to the bit, across any number of changes") {
  Simulation sim(yard({0, -9.81, 0}), {.step = 2e-3});
  sim.keep_history();
  sim.at(0.1).then(weld("sat/panel", "tug/hand")).named("grasp");
  sim.at(0.2).then(lock("tug/upper")).then(change_joint("tug/hand", Kind::free));
  sim.at(0.3).then(break_joint("grasp")).then(impulse("sat/hull", {1, 0, 0}));
  CHECK(sim.run_until(0.05) == Status::ok);
  const SimulationSnapshot early = sim.snapshot();
  CHECK(sim.run_until(0.25) == Status::ok);
  Simulation branch = sim.branch();
  CHECK(sim.run_until(0.4) == Status::ok);
  const std::vector<double> end = bits(sim.world());
  const EnergyBalance balance = sim.energy();

  CHECK(branch.run_until(0.4) == Status::ok);
  CHECK(bits(branch.world()) == end);
  CHECK(branch.energy().error == balance.error);

  sim.restore(early);
  CHECK(sim.time() == 0.05);
  CHECK(sim.events().empty());
  CHECK(sim.world().mechanism_names() == std::vector<std::string>{"crane", "tug", "sat"});
  CHECK(sim.run_until(0.25) == Status::ok);  // steps land on the requested times: identical bits require identical steps
  CHECK(sim.run_until(0.4) == Status::ok);
  CHECK(bits(sim.world()) == end);
  CHECK(sim.energy().error == balance.error);
  CHECK(sim.events().size() == 3);

  sim.undo(1, true);  // and let it happen again
  CHECK(sim.time() == 0.2);
  CHECK(sim.events().size() == 1);
  CHECK(sim.run_until(0.25) == Status::ok);
  CHECK(sim.run_until(0.4) == Status::ok);
  CHECK(bits(sim.world()) == end);

  sim.undo(1);  // another branch: the lock never happened
  CHECK(sim.run_until(0.4) == Status::ok);
  CHECK(sim.events().size() == 2);
  CHECK(sim.world().joint(sim.world().model().joint("tug/upper")).locked == 0);
  CHECK(bits(sim.world()) != end);
  CHECK_THROWS_AS(sim.undo(5), Error);
}

TEST_CASE("a dry run finds impossible actions and all joints that will exist, and changes nothing") {
  Simulation sim(yard());
  sim.at(0.1).then(weld("sat/panel", "tug/hand")).named("grasp");
  sim.at(0.2).then(break_joint("grasp"));
  sim.at(0.3).then(break_joint("grasp"));
  sim.at(0.4).then(weld("tug/hand", "tug/upper"));
  const std::vector<double> before = bits(sim.world());
  const DryRun found = sim.dry_run();
  CHECK(bits(sim.world()) == before);
  REQUIRE(found.issues.size() == 2);
  CHECK(found.issues[0].event == 2);
  CHECK(found.issues[0].result.outcome == ActionResult::Outcome::skipped);
  CHECK(found.issues[1].event == 3);
  CHECK(found.issues[1].message.find("t = 0.4 s") != std::string::npos);
  const auto has = [&](const char* name, Kind kind) {
    return std::find(found.joints.begin(), found.joints.end(), std::pair<std::string, Kind>{name, kind}) != found.joints.end();
  };
  CHECK(has("grasp", Kind::weld));
  CHECK(has("sat/panel~free", Kind::free));
  CHECK(has("sat/hull", Kind::free));
  CHECK(found.joints.size() == 9);
}

TEST_CASE("a break that would separate a massless part is refused") {
  Model model = yard();
  BodySpec sensor{.name = "tug/sensor", .parent = model.body("tug/hand"), .at = {0.1, 0, 0}, .joint = Weld{}};
  model.add(sensor);
  Simulation sim(model);
  const std::vector<double> before = bits(sim.world());
  CHECK(refused(sim, {break_joint("tug/sensor")}).find("mass") != std::string::npos);
  CHECK(bits(sim.world()) == before);
}

TEST_CASE("too many actions at one instant are an error that lists them") {
  Simulation sim(yard());
  const std::vector<Action> many(10'001, impulse("tug/hull", {1e-9, 0, 0}));
  CHECK(refused(sim, many).find("more than 10000 actions at one instant") != std::string::npos);
  CHECK(sim.events().empty());
}

TEST_CASE("a free root that is locked or damped can break, and has no lock or parameters then") {
  for (const bool locked : {true, false}) {
    Model model;
    model.add({.name = "hull",
               .mass = 2,
               .inertia = diagonal(0.1),
               .joint = Free{.damping = locked ? Values{} : Values{0.5}},
               .v = {0.3, 0, 0, 0, 0, 1}});
    Simulation sim(model);
    if (locked) sim.apply(lock("hull"));
    CHECK(sim.apply(break_joint("hull")).actions.front().text() == "break hull");
    const JointView joint = sim.world().joint({0});
    CHECK(joint.locked == 0);
    CHECK((joint.parameters == nullptr || !joint.parameters->any()));
    CHECK(sim.world().motions()[0].linear.x == doctest::Approx(locked ? 0 : 0.3));
    CHECK(sim.apply(break_joint("hull")).actions.front().text().find("skipped: it holds nothing") != std::string::npos);
  }
}

TEST_CASE("a break that would separate a body without inertia about an axis is refused") {
  Model model({.gravity = {0, 0, -9.81}});
  const BodyId base = model.add({.name = "base", .mass = 1.5, .inertia = diagonal(0.135), .joint = Free{}});
  model.add({.name = "rod",
             .mass = 7,
             .com = {0.283, -0.262, -0.1},
             .inertia = {0, 0.1575, 0.1575},
             .parent = base,
             .joint = Revolute{.axis = {0, 1, 0}},
             .v = 0.5});
  Simulation sim(model);
  REQUIRE(sim.run_until(0.1) == Status::ok);
  const std::vector<double> before = bits(sim.world());
  CHECK(refused(sim, {break_joint("rod")}).find("lack the mass or inertia to move freely") != std::string::npos);
  CHECK(bits(sim.world()) == before);
  sim.apply(lock("rod"));  // held, it does no harm
  REQUIRE(sim.run_until(0.2) == Status::ok);
}

TEST_CASE("a joint with armature can be attached to a moving body: the armature's energy is work") {
  Model model;
  model.add({.name = "cart", .mass = 1.5, .inertia = diagonal(0.07), .joint = Free{}, .v = {1, 0, 0, 0, 0, 0}});
  Simulation sim(model);
  Prismatic rail{.axis = x_axis};
  rail.armature = 0.3;
  sim.at(0.1).then(attach("cart", "ground", rail));
  CHECK(sim.dry_run().issues.empty());
  REQUIRE(sim.run_until(0.2) == Status::ok);
  REQUIRE(sim.events().size() == 1);
  CHECK(sim.events()[0].after.kinetic == doctest::Approx(0.5 * (1.5 + 0.3)));
  CHECK(sim.events()[0].work == doctest::Approx(0.5 * 0.3));
  CHECK(std::fabs(sim.energy().error) < 1e-14);
}

TEST_CASE("a dry run does not judge inertia by the joint positions before the run") {
  Model model;
  const BodyId gimbal = model.add({.name = "gimbal", .joint = Revolute{.axis = z_axis}});
  model.add({.name = "rod",
             .mass = 1,
             .com = {0, 0, 0.5},
             .inertia = {0.1, 0.1, 0},
             .parent = gimbal,
             .joint = Revolute{.axis = x_axis},
             .v = 1});
  Simulation sim(model);
  sim.apply(lock("gimbal"));
  sim.at(0.1).then(unlock("gimbal"));  // the rod is along the gimbal's axis now, but not then
  sim.at(0.25).then(change_joint("gimbal", Cylindrical{.axis = x_axis}));
  sim.at(0.25).then(change_joint("rod", Cylindrical{.axis = y_axis}));
  const DryRun found = sim.dry_run();
  CHECK(found.issues.empty());
  CHECK_FALSE(found.complete);  // nothing can be tried after it
  CHECK(sim.run_until(0.2) == Status::ok);
  CHECK(sim.world().joint({0}).locked == 0);
}

TEST_CASE("events of one instant are ordered by rank, then by scheduling") {
  Simulation sim(yard());
  sim.at(0.1).named("second").ranked(2).then(impulse("tug/hull", {1, 0, 0}));
  sim.at(0.1).named("first").ranked(1).then(impulse("tug/hull", {0, 1, 0}));
  REQUIRE(sim.run_until(0.2) == Status::ok);
  REQUIRE(sim.events().size() == 2);
  CHECK(sim.events()[0].name == "first");
}

TEST_CASE("actions on a broken joint do not act on the separated part, whose free joint has its name") {
  constexpr Vec3 y_axis{0, 1, 0};
  const auto arm = [y_axis] {
    Model model({.gravity = {}});
    const BodyId a = model.add(
        {.name = "arm/a", .mass = 1, .com = {0.3, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{.axis = y_axis}, .v = 2.0});
    model.add({.name = "arm/b",
               .mass = 1,
               .com = {0.3, 0, 0},
               .inertia = diagonal(0.1),
               .parent = a,
               .at = {0.6, 0, 0},
               .joint = Revolute{.axis = y_axis}});
    return model;
  };
  for (const Action& action : {lock("arm/b"), unlock("arm/b"), set_parameters("arm/b", {.damping = 3}), break_joint("arm/b"),
                               change_joint("arm/b", JointSpec(Revolute{.axis = y_axis}))}) {
    CAPTURE(action.text());
    Simulation sim(arm());
    REQUIRE(sim.run_until(0.5) == Status::ok);
    sim.apply(break_joint("arm/b"));
    const Event event = sim.apply(action);
    REQUIRE(event.actions.size() == 1);
    CHECK(event.actions[0].text().find("skipped: the joint no longer exists") != std::string::npos);
    const Totals before = sim.world().totals();
    REQUIRE(sim.run_until(1) == Status::ok);
    CHECK(norm(sim.world().totals().linear - before.linear) > 0);  // arm/a still holds
    CHECK(norm(sim.world().motions()[1].linear) > 0.5);
  }
  // A free joint within a mechanism is a joint like others.
  Model loose({.gravity = {}});
  const BodyId hull = loose.add({.name = "m/a", .mass = 1, .inertia = diagonal(0.1), .joint = Free{}});
  loose.add({.name = "m/b",
             .mass = 1,
             .inertia = diagonal(0.1),
             .parent = hull,
             .at = {1, 0, 0},
             .joint = Free{},
             .v = {0, 1, 0, 0, 0, 0}});
  for (const Action& action : {lock("m/b"), set_parameters("m/b", {.damping = 3}), break_joint("m/b"),
                               change_joint("m/b", JointSpec(Prismatic{.axis = y_axis}))}) {
    CAPTURE(action.text());
    Simulation sim(loose);
    sim.when(reaction_force("m/b").below(1)).then(impulse("m/a", {0, 0, 1})).named("unloaded");
    sim.apply(break_joint("m/b"));
    CHECK(sim.apply(action).actions.at(0).text().find("skipped: the joint no longer exists") != std::string::npos);
    REQUIRE(sim.run_until(1) == Status::ok);
    CHECK(sim.events().size() == 2);  // a joint that is gone has no reaction
    CHECK(sim.world().motions()[1].pose.position.y == doctest::Approx(1).epsilon(1e-12));
  }
  Simulation root(loose);  // its free root is the same joint before and after
  CHECK(root.apply(lock("m/a")).actions.at(0).text() == "lock m/a");
  // A joint that is released for the impact of its change is another matter: it exists.
  Simulation turned(arm());
  CHECK(
      turned.apply(change_joint("arm/a", JointSpec(Prismatic{.axis = {0, 0, 1}}))).actions[0].text().starts_with("change arm/a"));
  // So is one that was freed.
  Simulation sim(arm());
  sim.apply(free_joint("arm/b"));
  CHECK(sim.apply(lock("arm/b")).actions[0].text() == "lock arm/b");
}
