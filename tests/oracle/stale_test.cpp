// A change that uses a workspace of another state terminates the program: each misuse runs in a separate process.
#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/tree/edit.hpp>
#include <tests/misuse.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;
using namespace momentree::test;

namespace {

/// A chain of revolute joints with everything that a change needs, evaluated.
struct Scene {
  Model model =
      oracle::random_tree(4, {.min_bodies = 6, .max_bodies = 6, .several_mechanisms = false, .kinds = {Kind::revolute}}).model;
  Tree tree{model};
  State state = start_state(model, tree);
  Workspace<double> workspace{tree};
  Scene() { forward_dynamics(tree, state, workspace); }
};

const char* const stale = "the workspace was evaluated with this state and this tree as they are now";
const char* const unaccelerated = "the workspace holds the accelerations of this state and this tree as they are now";

}  // namespace

TEST_CASE("a change accepts only a workspace of the same state") {
  const BodyId joint{3};
  check_fine("the work of this state", [&] {
    Scene s;
    apply(Break{s.tree.inboard_joint(joint)}, s.tree, s.state, s.workspace);
  });
  check_stopped("a work never evaluated", stale, [&] {
    Scene s;
    Workspace<double> fresh(s.tree);
    apply(Break{s.tree.inboard_joint(joint)}, s.tree, s.state, fresh);
  });
  check_stopped("the state was edited since", stale, [&] {
    Scene s;
    s.state.edit().p[0] += 1e-3;
    apply(Break{s.tree.inboard_joint(joint)}, s.tree, s.state, s.workspace);
  });
  check_stopped("the work holds the last stage of a step", stale, [&] {
    Scene s;
    Evaluator evaluate(s.tree, s.workspace);
    EnergyLedger ledger;
    static_cast<void>(make_integrator("rk4", s.tree)->step(evaluate, s.state, ledger, 1e-3));
    apply(Break{s.tree.inboard_joint(joint)}, s.tree, s.state, s.workspace);
  });
  check_stopped("the work is of another state with equal numbers", stale, [&] {
    Scene s;
    State copy = s.state;
    apply(Break{s.tree.inboard_joint(joint)}, s.tree, copy, s.workspace);
  });
  check_stopped("a second change without an evaluation between", stale, [&] {
    Scene s;
    apply(Break{s.tree.inboard_joint(joint)}, s.tree, s.state, s.workspace);
    apply(Break{s.tree.inboard_joint({2})}, s.tree, s.state, s.workspace);
  });
  check_stopped("a joint that broke already", "holds a body", [&] {
    Scene s;
    apply(Break{s.tree.inboard_joint(joint)}, s.tree, s.state, s.workspace);
    forward_dynamics(s.tree, s.state, s.workspace);
    apply(Break{s.tree.inboard_joint(joint)}, s.tree, s.state, s.workspace);
  });
  check_stopped("a state of another topology", "the state belongs to this tree as it is now", [&] {
    Scene s;
    Tree other(s.model);
    other.edit().detach(joint.index);
    forward_dynamics(other, s.state, s.workspace);
  });
  check_stopped("a momentum read from a stale work", stale, [&] {
    Scene s;
    static_cast<void>(s.state.edit());
    static_cast<void>(articulated_momentum(s.tree, s.state, s.workspace, 2));
  });
  check_stopped("a reaction read before accelerations were asked for", unaccelerated, [&] {
    Scene s;
    static_cast<void>(reaction(s.tree, s.state, s.workspace, s.tree.inboard_joint({2})));
  });
  check_stopped("a reaction read after the state was edited", unaccelerated, [&] {
    Scene s;
    accelerate(s.tree, s.state, s.workspace);
    static_cast<void>(s.state.edit());
    forward_dynamics(s.tree, s.state, s.workspace);
    static_cast<void>(reaction(s.tree, s.state, s.workspace, s.tree.inboard_joint({2})));
  });
  check_stopped("the acceleration of a body that is not located", "the bodies are located at this state", [&] {
    Scene s;
    accelerate(s.tree, s.state, s.workspace);
    static_cast<void>(body_acceleration(s.tree, s.state, s.workspace, BodyId{2}));
  });
}

TEST_CASE("removed bodies no longer exist; added bodies need room in the workspace") {
  const auto remove = [](Scene& s) {
    apply(Break{s.tree.inboard_joint({3})}, s.tree, s.state, s.workspace);
    apply(Remove{{3}}, s.tree, s.state, s.workspace);
    forward_dynamics(s.tree, s.state, s.workspace);
  };
  check_fine("another body", [&] {
    Scene s;
    remove(s);
    apply(Break{s.tree.inboard_joint({2})}, s.tree, s.state, s.workspace);
  });
  check_stopped("its joint is asked for", "it was not removed", [&] {
    Scene s;
    remove(s);
    static_cast<void>(s.tree.joint(3));
  });
  check_stopped("it is broken off again", "holds a body", [&] {
    Scene s;
    remove(s);
    apply(Break{{3}}, s.tree, s.state, s.workspace);
  });
  check_stopped("it is joined to", "the ground or in the tree", [&] {
    Scene s;
    apply(Break{s.tree.inboard_joint({2})}, s.tree, s.state, s.workspace);
    forward_dynamics(s.tree, s.state, s.workspace);
    apply(Break{s.tree.inboard_joint({4})}, s.tree, s.state, s.workspace);
    apply(Remove{{4}}, s.tree, s.state, s.workspace);
    forward_dynamics(s.tree, s.state, s.workspace);
    apply(Join{{2}, {4}}, s.tree, s.state, s.workspace);
  });
  check_stopped("a part that is joined to something is removed", "the root of a mechanism that floats", [&] {
    Scene s;
    apply(Remove{{3}}, s.tree, s.state, s.workspace);
  });
  check_stopped("a body came, the work did not grow", "the workspace has room for the tree's bodies", [&] {
    Scene s;
    apply(Add{&s.model[{1}]}, s.tree, s.state, s.workspace);
    forward_dynamics(s.tree, s.state, s.workspace);
  });
}
