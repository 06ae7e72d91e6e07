// Invalid evaluations and changes: each stops the program before anything has happened.
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/new_joint.hpp>
#include <momentree/topology/snapshot.hpp>
#include <tests/misuse.hpp>

using namespace momentree;
using namespace momentree::test;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
const char* const no_body = "the tree has a body of that number, and it was not removed";
const char* const no_joint = "the joint is in the tree";

// Two revolute joints on the ground; a floating body with another one on a ball joint; all evaluated.
struct Scene {
  Model model;
  Tree tree;
  State state;
  Workspace<double> workspace;
  explicit Scene(double mass = 1) : model(make(mass)), tree(model), state(start_state(model, tree)), workspace(tree) {
    forward_dynamics(tree, state, workspace);
  }
  static Model make(double mass) {
    Model model;
    const auto add = [&](const char* name, BodyId parent, const JointSpec& joint) {
      return model.add(
          {.name = name, .mass = mass, .com = {0.1, 0, 0}, .inertia = diagonal(0.1), .parent = parent, .joint = joint});
    };
    add("lower", add("upper", ground, Revolute{}), Revolute{});
    add("panel", add("float", ground, Free{}), Ball{});
    return model;
  }
};

// A misuse of a separate scene.
template <class Act>
Misuse of_scene(const char* how, const char* expected, Act act) {
  return {how, expected, [act] {
            Scene scene;
            act(scene);
          }};
}
template <class Change>
Misuse of_change(const char* how, const char* expected, const Change& change) {
  return of_scene(how, expected, [change](Scene& s) { apply(change, s.tree, s.state, s.workspace); });
}

Joint hinge(const Vec3& axis) {
  Joint joint;
  joint.kind = Kind::revolute, joint.axis = axis;
  return joint;
}
Joint placed(const Pose& at) {
  Joint joint = hinge(z_axis);
  joint.at = at;
  return joint;
}

}  // namespace

TEST_CASE("misuse: changes of a body that does not exist") {
  for (const int b : {-1, 4, 77, -1000}) {
    CAPTURE(b);
    const BodyId body{b};
    const JointId joint{b};
    const Misuse all[] = {
        of_change("Break", "holds a body", Break{joint}),
        of_change("ChangeJoint", no_joint, ChangeJoint{joint, hinge(z_axis), {0}}),
        of_change("Lock", no_joint, Lock{joint}),
        of_change("Unlock", no_joint, Unlock{joint}),
        of_change("Reroot", "its mechanism floats", Reroot{body}),
        of_change("Join", "its mechanism floats", Join{body, {0}}),
        of_change("Attach", "its mechanism floats", Attach{body, {0}, hinge(z_axis), {0}}),
        of_change("Impulse", no_body, Impulse{body, {1, 0, 0}}),
        of_change("Impact", no_joint, Impact{joint, 0}),
        of_change("SetParameters", no_joint, SetParameters{joint, {}}),
        of_change("Remove", "the root of a mechanism that floats", Remove{body}),
    };
    for (const Misuse& misuse : all) check_stopped(misuse);
    CHECK_FALSE(can_break(Scene().tree, joint));
    CHECK_FALSE(floats(Scene().tree, {b}));
    if (b != -1) check_stopped(of_change("Join to no body", "the ground or in the tree", Join{{2}, body}));
    check_stopped(of_scene("root_of", no_body, [b](Scene& s) { static_cast<void>(root_of(s.tree, {b})); }));
  }
}

TEST_CASE("misuse: changes with invalid joints, impulses and bodies") {
  JointParameters negative, too_many;
  negative.damping = -1, too_many.armature = {1, 2};
  const Misuse all[] = {
      of_change("no coordinates", "as many coordinates", ChangeJoint{{1}, hinge(z_axis), {}}),
      of_change("coordinates that are no numbers", "finite coordinates", ChangeJoint{{1}, hinge(z_axis), {no_number}}),
      of_change("an axis that is longer than 1", "an axis of length 1", ChangeJoint{{1}, hinge({0, 0, 2}), {0}}),
      of_change("no axis", "a valid joint", ChangeJoint{{1}, hinge({0, 0, 0}), {0}}),
      of_change("a placement that is no number", "finite placements", ChangeJoint{{1}, placed({{0, inf, 0}, {}}), {0}}),
      of_change("a placement that is no rotation", "finite placements", ChangeJoint{{1}, placed({{}, {2, 0, 0, 0}}), {0}}),
      of_change("a ball's coordinates that are no rotation", "a quaternion of length 1",
                ChangeJoint{{1},
                            [] {
                              Joint j;
                              j.kind = Kind::ball;
                              return j;
                            }(),
                            {0, 0, 0, 0}}),
      of_change("reversed on the ground", "the ground is not a joint's child",
                ChangeJoint{{0}, hinge(z_axis), {0}, ChangeJoint::Direction::reversed}),
      of_change("Attach without coordinates", "as many coordinates", Attach{{2}, {0}, hinge(z_axis), {}}),
      of_change("Attach to itself", "different mechanisms", Attach{{2}, {3}, hinge(z_axis), {0}}),
      of_change("Join of what is held", "its mechanism floats", Join{{1}, {2}}),
      of_change("Reroot of what is held", "its mechanism floats", Reroot{{1}}),
      of_change("Remove of what is held", "the root of a mechanism that floats", Remove{{1}}),
      of_change("Remove of a part", "the root of a mechanism that floats", Remove{{3}}),
      of_change("Break of what is free", "holds a body", Break{{2}}),
      of_change("Impulse that is no number", "a finite impulse", Impulse{{1}, {no_number, 0, 0}}),
      of_change("Impulse without end", "a finite impulse", Impulse{{1}, {}, {0, inf, 0}}),
      of_change("Impulse at no point", "a finite impulse", Impulse{{1}, {1, 0, 0}, {}, {0, 0, no_number}}),
      of_change("Impact of a second freedom", "the joint has that degree of freedom", Impact{{1}, 1}),
      of_change("Impact of freedom -1", "the joint has that degree of freedom", Impact{{1}, -1}),
      of_change("Impact that makes energy", "a restitution from 0 to 1", Impact{{1}, 0, 1.5}),
      of_change("Impact that is no number", "a restitution from 0 to 1", Impact{{1}, 0, no_number}),
      of_change("SetParameters, negative", "valid parameters for this joint", SetParameters{{1}, negative}),
      of_change("SetParameters, too many", "valid parameters for this joint", SetParameters{{1}, too_many}),
      of_change("Add of nothing", "a body to add", Add{nullptr}),
      of_scene("Add of a body with too many coordinates", "a valid body",
               [](Scene& s) {
                 const BodySpec spec{.name = "x", .mass = 1, .joint = Revolute{}, .q = {0, 0}};
                 apply(Add{&spec}, s.tree, s.state, s.workspace);
               }),
      of_scene("Add to no body", "the ground or in the tree",
               [](Scene& s) {
                 BodySpec spec = s.model[{1}];
                 spec.parent = {9};
                 apply(Add{&spec}, s.tree, s.state, s.workspace);
               }),
      of_scene("Add of a mass that is no number", "a valid body",
               [](Scene& s) {
                 BodySpec spec = s.model[{1}];
                 spec.mass = no_number;
                 apply(Add{&spec}, s.tree, s.state, s.workspace);
               }),
      of_scene("a momentum that is no number", "a finite momentum",
               [](Scene& s) {
                 const Force<double> none{{no_number, 0, 0}, {}};
                 apply(ChangeJoint{{1}, hinge(z_axis), {0}}, none, s.tree, s.state, s.workspace);
               }),
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
}

TEST_CASE("misuse: a tree, state or workspace that do not belong together") {
  const char* const foreign = "the state belongs to this tree as it is now";
  const char* const stale = "the workspace was evaluated with this state and this tree as they are now";
  const Misuse all[] = {
      of_scene("forward_dynamics on a tree of the same shape", foreign,
               [](Scene& s) { forward_dynamics(Scene(2).tree, s.state, s.workspace); }),
      of_scene("forward_dynamics on another tree of the same model", foreign,
               [](Scene& s) { forward_dynamics(Tree(s.model), s.state, s.workspace); }),
      of_scene("forward_dynamics on a larger tree", foreign,
               [](Scene& s) {
                 Model larger = s.model;
                 larger.add({.name = "x", .mass = 1, .inertia = diagonal(1), .joint = Free{}});
                 const Tree tree(larger);
                 Workspace<double> workspace(tree);
                 forward_dynamics(tree, s.state, workspace);
               }),
      of_scene("forward_dynamics of a default state", foreign, [](Scene& s) { forward_dynamics(s.tree, State(), s.workspace); }),
      of_scene("forward_dynamics of a moved-from state", foreign,
               [](Scene& s) {
                 const State moved = std::move(s.state);
                 forward_dynamics(s.tree, s.state, s.workspace);
               }),
      of_scene("forward_dynamics on a moved-from tree", foreign,
               [](Scene& s) {
                 const Tree moved = std::move(s.tree);
                 forward_dynamics(s.tree, s.state, s.workspace);
               }),
      of_scene("forward_dynamics with a work of a smaller tree", "the workspace has room for the tree's bodies",
               [](Scene& s) {
                 Model small;
                 small.add({.name = "x", .mass = 1, .inertia = diagonal(1), .joint = Revolute{}});
                 Workspace<double> workspace{Tree(small)};
                 forward_dynamics(s.tree, s.state, workspace);
               }),
      of_scene("forward_dynamics with a moved-from work", "the workspace has room for the tree's bodies",
               [](Scene& s) {
                 const Workspace<double> moved = std::move(s.workspace);
                 forward_dynamics(s.tree, s.state, s.workspace);
               }),
      of_scene("a change while the state is edited", "the state's Edit has ended",
               [](Scene& s) {
                 const State::Edit edit = s.state.edit();
                 forward_dynamics(s.tree, s.state, s.workspace);
                 apply(Break{s.tree.inboard_joint({1})}, s.tree, s.state, s.workspace);
               }),
      of_scene("a reaction while the state is edited", "the state's Edit has ended",
               [](Scene& s) {
                 const State::Edit edit = s.state.edit();
                 accelerate(s.tree, s.state, s.workspace);
                 static_cast<void>(reaction(s.tree, s.state, s.workspace, s.tree.inboard_joint({1})));
               }),
      of_scene("a change of a tree of the same shape", stale,
               [](Scene& s) {
                 Scene other(2);
                 apply(Break{other.tree.inboard_joint({1})}, other.tree, s.state, s.workspace);
               }),
      of_scene("a change of a copy after the tree changed", stale,
               [](Scene& s) {
                 Tree copy = s.tree;
                 copy.edit().detach(3);
                 apply(Break{copy.inboard_joint({1})}, copy, s.state, s.workspace);
               }),
      of_scene("a momentum read on another tree", stale,
               [](Scene& s) { static_cast<void>(articulated_momentum(Scene(2).tree, s.state, s.workspace, 1)); }),
      of_scene("a body located on another tree", stale,
               [](Scene& s) { static_cast<void>(locate_body(Scene(2).tree, s.state, s.workspace, 1)); }),
      of_scene("a joint's energy on another tree", stale,
               [](Scene& s) { static_cast<void>(joint_energy(Scene(2).tree, s.state, s.workspace, 1)); }),
      of_scene("a reaction on another tree", "the workspace holds the accelerations of this state and this tree",
               [](Scene& s) {
                 accelerate(s.tree, s.state, s.workspace);
                 static_cast<void>(reaction(Scene(2).tree, s.state, s.workspace, s.tree.inboard_joint({1})));
               }),
      of_scene("a momentum of no body", no_body,
               [](Scene& s) { static_cast<void>(articulated_momentum(s.tree, s.state, s.workspace, 9)); }),
      of_scene("locate_body of no body", no_body,
               [](Scene& s) { static_cast<void>(locate_body(s.tree, s.state, s.workspace, 9)); }),
      of_scene("joint_energy of no body", no_body,
               [](Scene& s) { static_cast<void>(joint_energy(s.tree, s.state, s.workspace, -3)); }),
      of_scene("reaction of no joint", no_joint,
               [](Scene& s) {
                 accelerate(s.tree, s.state, s.workspace);
                 static_cast<void>(reaction(s.tree, s.state, s.workspace, {4}));
               }),
      of_scene("bearing_reaction of no joint", no_joint,
               [](Scene& s) {
                 accelerate(s.tree, s.state, s.workspace);
                 static_cast<void>(bearing_reaction(s.tree, s.state, s.workspace, {-1}));
               }),
      of_scene("joint_effort of no joint", no_joint,
               [](Scene& s) {
                 accelerate(s.tree, s.state, s.workspace);
                 double effort[6];
                 joint_effort(s.tree, s.state, s.workspace, {4}, effort);
               }),
      of_scene("body_acceleration of no body", no_body,
               [](Scene& s) {
                 locate_bodies(s.tree, s.state, s.workspace);
                 accelerate(s.tree, s.state, s.workspace);
                 static_cast<void>(body_acceleration(s.tree, s.state, s.workspace, BodyId{5}));
               }),
      of_scene("joint_spring of a joint without one", "the joint has a spring",
               [](Scene& s) {
                 double force[6];
                 static_cast<void>(joint_spring(s.tree, s.state.q().data(), 1, force));
               }),
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
}

TEST_CASE("misuse: methods of integration") {
  const auto with_method = [](const char* name, auto act) {
    return [name, act] {
      Scene s;
      Evaluator evaluate(s.tree, s.workspace);
      EnergyLedger ledger;
      const auto method = make_integrator(name, s.tree);
      act(s, evaluate, ledger, *method);
    };
  };
  using E = Evaluator;
  using B = EnergyLedger;
  using I = Integrator;
  for (const std::string& name : integration_methods()) {
    CAPTURE(name);
    const char* const method = name.c_str();
    check_fine("a step", with_method(method, [](Scene& s, E& e, B& b, I& m) { static_cast<void>(m.step(e, s.state, b, 1e-3)); }));
    const Misuse all[] = {
        {"a step that is no number", "the step is finite",
         with_method(method, [](Scene& s, E& e, B& b, I& m) { static_cast<void>(m.step(e, s.state, b, no_number)); })},
        {"a step without end", "the step is finite",
         with_method(method, [](Scene& s, E& e, B& b, I& m) { static_cast<void>(m.step(e, s.state, b, inf)); })},
        {"a state that is edited", "the state's Edit has ended",
         with_method(method,
                     [](Scene& s, E& e, B& b, I& m) {
                       const State::Edit edit = s.state.edit();
                       e(s.state);
                       static_cast<void>(m.step(e, s.state, b, 1e-3));
                     })},
        {"a state that was not evaluated", "the workspace was evaluated with this state",
         with_method(method,
                     [](Scene& s, E& e, B& b, I& m) {
                       s.state.edit().p[0] = 1;
                       static_cast<void>(m.step(e, s.state, b, 1e-3));
                     })},
        {"a tree that has grown", "the method was made for a tree of that many bodies",
         with_method(method,
                     [](Scene& s, E& e, B& b, I& m) {
                       apply(Add{&s.model[{1}]}, s.tree, s.state, s.workspace);
                       s.workspace = Workspace<double>(s.tree);
                       e(s.state);
                       static_cast<void>(m.step(e, s.state, b, 1e-3));
                     })},
        {"a step of 0 to choose from", "the step is positive and finite",
         [method] { make_integrator(method, Scene().tree, {.step = 0}); }},
        {"a tolerance that is no number", "rtol, atol and max_step are positive",
         [method] { make_integrator(method, Scene().tree, {.rtol = no_number}); }},
    };
    for (const Misuse& misuse : all) check_stopped(misuse);
  }
  CHECK(make_integrator("euler", Scene().tree) == nullptr);
}
