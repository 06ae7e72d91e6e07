// Invalid arguments to models, trees and states: a message or an error, never an access out of bounds.
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/snapshot.hpp>
#include <momentree/tree/edit.hpp>
#include <tests/error_of.hpp>
#include <tests/misuse.hpp>

using namespace momentree;
using namespace momentree::test;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

// A base on the ground with an arm of two revolute joints, and a floating body.
Model arm(double mass = 1) {
  Model model;
  BodyId last = ground;
  for (const char* name : {"base", "upper", "lower"})
    last = model.add({.name = name,
                      .mass = mass,
                      .com = {0.1, 0, 0},
                      .inertia = diagonal(0.1),
                      .parent = last,
                      .joint = last == ground ? JointSpec(Weld{}) : JointSpec(Revolute{})});
  model.add({.name = "float", .mass = mass, .inertia = diagonal(0.1), .joint = Free{}});
  return model;
}

const char* const no_body = "the tree has a body of that number, and it was not removed";

}  // namespace

TEST_CASE("misuse: a model") {
  Model model = arm();
  check_fine("the last body", [&] { static_cast<void>(model[BodyId{3}]); });
  for (const int b : {-1, 4, 77, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
    check_stopped("model[no body]", "a body of this model", [&] { static_cast<void>(model[BodyId{b}]); });
    check_stopped("mechanism_name(no body)", "a body of this model", [&] { static_cast<void>(model.mechanism_name({b})); });
  }
  check_stopped("keep(-1)", "a number of bodies", [&] { model.keep(-1); });
  check_stopped("no kind", "one of the kinds of joint", [&] {
    JointSpec joint;
    joint.kind = static_cast<Kind>(99);
    model.add({.name = "x", .mass = 1, .joint = joint});
  });
  for (const double x : {no_number, inf, -inf}) {
    CAPTURE(x);
    CHECK(error_of([&] { Model({.gravity = {0, x, 0}}); }).find("gravity must be finite") != std::string::npos);
    CHECK(error_of([&] { model.set_gravity({x, 0, 0}); }).find("gravity must be finite") != std::string::npos);
    CHECK(error_of([&] { model.add({.name = "x", .mass = x}); }).find("mass") != std::string::npos);
    CHECK(error_of([&] {
            model.add({.name = "x", .mass = 1, .at = {0, x, 0}});
          }).find("at: must be finite") != std::string::npos);
    CHECK(error_of([&] {
            model.add({.name = "x", .mass = 1, .inertia = diagonal(1), .joint = Revolute{}, .v = x});
          }).find("v: must be finite") != std::string::npos);
    CHECK(error_of([&] {
            model.add_force({.body = {0}, .force = {x, 0, 0}});
          }).find("force: must be finite") != std::string::npos);
  }
  for (const int b : {-1, 4})
    CHECK(error_of([&] { model.add_force({.body = {b}}); }).find("no body of this model") != std::string::npos);
  for (const int b : {-2, 4})
    CHECK(error_of([&] { model.add({.name = "x", .mass = 1, .parent = {b}}); }).find("the parent is not a body") !=
          std::string::npos);
  CHECK(model.size() == 4);
}

TEST_CASE("misuse: values and indices") {
  check_stopped("an index past the end", "an index below size()", [] { static_cast<void>(Values{1, 2}[2]); });
  check_stopped("a negative index", "an index below size()", [] { static_cast<void>(Values{1, 2}[-1]); });
  check_stopped("an eighth value", "at most 7 values", [] { Values{1, 2, 3, 4, 5, 6, 7, 8}; });
  const Tree tree(arm());
  State state(tree);
  check_stopped("q()[nq]", "an index below size()", [&] { static_cast<void>(state.q()[9]); });
  check_stopped("q().front() of no coordinates", "an index below size()", [&] { static_cast<void>(State().q().front()); });
  check_stopped("edit().p[nv]", "an index below size()", [&] { state.edit().p[8] = 0; });
}

TEST_CASE("misuse: queries about a body that the tree does not have") {
  const Tree tree(arm());
  for (const int b : {-1, 4, 1 << 30}) {
    CAPTURE(b);
    const Misuse all[] = {
        {"parent", no_body, [&] { static_cast<void>(tree.parent(b)); }},
        {"first_child", no_body, [&] { static_cast<void>(tree.first_child(b)); }},
        {"next_sibling", no_body, [&] { static_cast<void>(tree.next_sibling(b)); }},
        {"first_q", no_body, [&] { static_cast<void>(tree.first_q(b)); }},
        {"first_p", no_body, [&] { static_cast<void>(tree.first_p(b)); }},
        {"link", no_body, [&] { static_cast<void>(tree.link(b)); }},
        {"subtree_mass", no_body, [&] { static_cast<void>(tree.subtree_mass(b)); }},
        {"joint", no_body, [&] { static_cast<void>(tree.joint(b)); }},
        {"joint_of", no_body, [&] { static_cast<void>(tree.joint_of(b)); }},
        {"carrier", "the tree has a joint of that number", [&] { static_cast<void>(tree.carrier(b)); }},
        {"kind", no_body, [&] { static_cast<void>(tree.kind(b)); }},
        {"variant", no_body, [&] { static_cast<void>(tree.variant(b)); }},
        {"reversed", no_body, [&] { static_cast<void>(tree.reversed(b)); }},
        {"frame", no_body, [&] { static_cast<void>(tree.frame(b)); }},
        {"at_centre_of_mass", no_body, [&] { static_cast<void>(at_centre_of_mass(tree, b)); }},
        {"parameters", no_body, [&] { static_cast<void>(tree.parameters(b)); }},
        {"function", no_body, [&] { static_cast<void>(tree.function(b)); }},
        {"detached", no_body, [&] { static_cast<void>(is_detached(tree, b)); }},
        {"motion", no_body, [&] { static_cast<void>(prescribed_motion(tree, b)); }},
    };
    for (const Misuse& misuse : all) check_stopped(misuse);
    CHECK_FALSE(tree.alive(b));
  }
  check_stopped("motion of a joint that is free to move", "motion is prescribed",
                [&] { static_cast<void>(prescribed_motion(tree, 1)); });
}

TEST_CASE("misuse: impossible edits of a tree") {
  Tree tree(arm());
  const Joint hinge = tree.joint(1);
  Joint locked = hinge, parameters = hinge, function = hinge, kind = hinge;
  locked.locked = 2, parameters.parameters = 5, function.function = 0, kind.kind = static_cast<Kind>(50);
  const Misuse all[] = {
      {"detach", no_body, [&] { tree.edit().detach(9); }},
      {"reroot", no_body, [&] { tree.edit().reroot(-1); }},
      {"reroot of what is held", "the root is joined to the ground by a free joint", [&] { tree.edit().reroot(2); }},
      {"attach to itself", "belongs to another tree", [&] { tree.edit().attach(3, 3, hinge, false); }},
      {"attach to no body", no_body, [&] { tree.edit().attach(3, 9, hinge, false); }},
      {"attach to less than the ground", "a body or the ground", [&] { tree.edit().attach(3, -2, hinge, false); }},
      {"set_joint", no_body, [&] { tree.edit().set_joint(4, hinge); }},
      {"set_joint reversed on the ground", "the ground is not a joint's child", [&] { tree.edit().set_joint(0, hinge, true); }},
      {"set_joint with a locked freedom that it has not", "those of its kind", [&] { tree.edit().set_joint(1, locked); }},
      {"set_joint with parameters that there are not", "parameters exist in the tree",
       [&] { tree.edit().set_joint(1, parameters); }},
      {"set_joint with a function that there is not", "function exists in the tree", [&] { tree.edit().set_joint(1, function); }},
      {"set_joint of no kind", "one of the kinds of joint", [&] { tree.edit().set_joint(1, kind); }},
      {"set_parameters", no_body, [&] { tree.edit().set_parameters(-1, {}); }},
      {"set_function", no_body, [&] { tree.edit().set_function(7, nullptr); }},
      {"set_body_function", no_body, [&] { tree.edit().set_body_function(7, nullptr); }},
      {"set_gravity", "a finite gravity",
       [&] {
         tree.edit().set_gravity({no_number, 0, 0});
       }},
      {"remove", "the body is a root", [&] { tree.edit().remove(2); }},
      {"remove no body", "the body is a root", [&] { tree.edit().remove(9); }},
      {"add", "the ground or a body of this tree", [&] { tree.edit().add({.name = "x", .mass = 1, .parent = {9}}); }},
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
}

TEST_CASE("misuse: a topology or snapshot of another tree") {
  Tree tree(arm());
  State state(tree);
  const Topology good = tree.topology();
  const auto with = [&](auto change) {
    return [&, change] {
      Topology topology = good;
      change(topology);
      tree.edit().restore(topology);
    };
  };
  check_fine("its own", with([](Topology&) {}));
  const Misuse all[] = {
      {"a body more", "compiled from the same model", with([](Topology& t) { t.places.push_back({}); })},
      {"of another model", "compiled from the same model", [&] { tree.edit().restore(Tree(arm(2)).topology()); }},
      {"a parent that is not there", "the ground or a body", with([](Topology& t) { t.places[1].parent = 9; })},
      {"a joint that is not there", "a body carries a joint", with([](Topology& t) { t.places[1].joint = 9; })},
      {"a joint twice", "carried by one body", with([](Topology& t) { t.places[1].joint = 2; })},
      {"a loop", "every body is joined to the ground", with([](Topology& t) { t.places[0].parent = 2; })},
      {"reversed on the ground", "the ground is not a joint's child", with([](Topology& t) { t.places[0].reversed = true; })},
      {"a changed joint that is not there", "one of the topology's", with([](Topology& t) {
         t.changed.push_back({7, Joint{}});
       })},
      {"parameters that are not there", "parameters exist", with([](Topology& t) {
         Joint joint;
         joint.parameters = 3;
         t.changed.push_back({1, joint});
       })},
      {"parameters of no joint", "those of a joint", with([](Topology& t) {
         t.own.push_back({-1, {}});
       })},
      {"a function that is null", "a function is not null", with([](Topology& t) { t.functions.push_back(nullptr); })},
      {"a load on no body", "acts on a body", with([](Topology& t) {
         t.loads.push_back({5, nullptr});
       })},
      {"a snapshot of another tree", "belongs to this tree as it is now",
       [&] {
         const Tree other(arm());
         static_cast<void>(take_snapshot(other, state));
       }},
      {"a snapshot with coordinates missing", "the coordinates and momenta or velocities are of this topology",
       [&] {
         Snapshot snapshot = take_snapshot(tree, state);
         snapshot.q.pop_back();
         restore(snapshot, tree, state);
       }},
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
}

TEST_CASE("misuse: a state of another tree") {
  Model model = arm();
  Tree tree(model);
  State state = start_state(model, tree);
  const std::vector<double> few(3);
  const Misuse all[] = {
      {"start_state with another model", "compiled from this model",
       [&] {
         Model larger = arm();
         larger.add({.name = "x", .mass = 1});
         static_cast<void>(start_state(larger, tree));
       }},
      {"start_state of a tree that changed", "as it was compiled from this model",
       [&] {
         tree.edit().detach(1);
         static_cast<void>(start_state(model, tree));
       }},
      {"assign of too few numbers", "as many coordinates and momenta", [&] { state.assign(0, few, few, tree); }},
      {"replace past the end", "as many coordinates and momenta", [&] { state.replace(9, 2, {}, 0, 0, {}, tree); }},
      {"assigned while it is edited", "the state's Edit has ended",
       [&] {
         const State::Edit edit = state.edit();
         state = State(tree);
       }},
      {"moved while it is edited", "the state's Edit has ended",
       [&] {
         const State::Edit edit = state.edit();
         const State moved = std::move(state);
       }},
      {"restored while it is edited", "the state's Edit has ended",
       [&] {
         const State::Edit edit = state.edit();
         state.assign(0, state.q(), state.p(), tree);
       }},
  };
  for (const Misuse& misuse : all) check_stopped(misuse);
}
