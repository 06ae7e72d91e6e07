// A change that reads a work of another state stops the program: each misuse in a process of its own.
#include <csignal>
#include <cstdio>
#include <functional>

#include <sys/wait.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/topology/change.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;

namespace {

/// What a child process printed to standard error, and the signal that ended it (0: none).
struct End {
  std::string said;
  int signal = 0;
};
End in_child(const std::function<void()>& misuse) {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  std::fflush(nullptr);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    std::signal(SIGABRT, SIG_DFL);
    misuse();
    _exit(0);
  }
  close(ends[1]);
  End end;
  char buffer[512];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) end.said.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  return end;
}

void check_stopped(const char* how, const std::function<void()>& misuse) {
  CAPTURE(how);
  const End end = in_child(misuse);
  INFO(end.said);
  CHECK(end.signal == SIGABRT);
  CHECK(end.said.find("was used wrongly") != std::string::npos);
}

/// A chain of pins with everything that a change needs, evaluated.
struct Scene {
  Model model =
      oracle::random_tree(4, {.min_bodies = 6, .max_bodies = 6, .several_mechanisms = false, .kinds = {Kind::revolute}}).model;
  Tree tree{model};
  State state = start_state(model, tree);
  Work<double> work{tree};
  Scene() { forward_dynamics(tree, state, work); }
};

}  // namespace

TEST_CASE("a change reads only a work of this very state") {
  const Body joint{3};
  {
    Scene s;  // the right way, so that the others fail for the reason meant
    const End end = in_child([&] { apply(Break{joint}, s.tree, s.state, s.work); });
    INFO(end.said);
    CHECK(end.signal == 0);
  }
  check_stopped("a work never evaluated", [&] {
    Scene s;
    Work<double> fresh(s.tree);
    apply(Break{joint}, s.tree, s.state, fresh);
  });
  check_stopped("the state was edited since", [&] {
    Scene s;
    s.state.edit().p[0] += 1e-3;
    apply(Break{joint}, s.tree, s.state, s.work);
  });
  check_stopped("the work holds the last stage of a step", [&] {
    Scene s;
    Evaluator evaluate(s.tree, s.work);
    Books books;
    make_integrator("rk4", s.tree)->step(evaluate, s.state, books, 1e-3);
    apply(Break{joint}, s.tree, s.state, s.work);
  });
  check_stopped("the work is of another state with equal numbers", [&] {
    Scene s;
    State copy = s.state;
    apply(Break{joint}, s.tree, copy, s.work);
  });
  check_stopped("a second change without an evaluation between", [&] {
    Scene s;
    apply(Break{joint}, s.tree, s.state, s.work);
    apply(Break{{2}}, s.tree, s.state, s.work);
  });
  check_stopped("a joint that broke already", [&] {
    Scene s;
    apply(Break{joint}, s.tree, s.state, s.work);
    forward_dynamics(s.tree, s.state, s.work);
    apply(Break{joint}, s.tree, s.state, s.work);
  });
  check_stopped("a state of another topology", [&] {
    Scene s;
    Tree other(s.model);
    other.detach(joint.index);
    forward_dynamics(other, s.state, s.work);
  });
  check_stopped("a momentum read from a stale work", [&] {
    Scene s;
    s.state.edit();
    articulated_momentum(s.tree, s.state, s.work, 2);
  });
  check_stopped("a reaction read before accelerations were asked for", [&] {
    Scene s;
    reaction(s.tree, s.state, s.work, 2);
  });
  check_stopped("a reaction read after the state was edited", [&] {
    Scene s;
    accelerate(s.tree, s.state, s.work);
    s.state.edit();
    forward_dynamics(s.tree, s.state, s.work);
    reaction(s.tree, s.state, s.work, 2);
  });
  check_stopped("the acceleration of a body that is not located", [&] {
    Scene s;
    accelerate(s.tree, s.state, s.work);
    body_acceleration(s.tree, s.state, s.work, 2);
  });
}

TEST_CASE("what was removed is gone; what was added needs room") {
  const auto remove = [](Scene& s) {
    apply(Break{{3}}, s.tree, s.state, s.work);
    apply(Remove{{3}}, s.tree, s.state, s.work);
    forward_dynamics(s.tree, s.state, s.work);
  };
  {
    const End end = in_child([&] {
      Scene s;
      remove(s);
      apply(Break{{2}}, s.tree, s.state, s.work);
    });
    INFO(end.said);
    CHECK(end.signal == 0);
  }
  check_stopped("its joint is asked for", [&] {
    Scene s;
    remove(s);
    s.tree.joint(3);
  });
  check_stopped("it is broken off again", [&] {
    Scene s;
    remove(s);
    apply(Break{{3}}, s.tree, s.state, s.work);
  });
  check_stopped("it is joined to", [&] {
    Scene s;
    apply(Break{{2}}, s.tree, s.state, s.work);
    forward_dynamics(s.tree, s.state, s.work);
    apply(Break{{4}}, s.tree, s.state, s.work);
    apply(Remove{{4}}, s.tree, s.state, s.work);
    forward_dynamics(s.tree, s.state, s.work);
    apply(Join{{2}, {4}}, s.tree, s.state, s.work);
  });
  check_stopped("a part that hangs on something is removed", [&] {
    Scene s;
    apply(Remove{{3}}, s.tree, s.state, s.work);
  });
  check_stopped("a body came, the work did not grow", [&] {
    Scene s;
    apply(Add{&s.model[{1}]}, s.tree, s.state, s.work);
    forward_dynamics(s.tree, s.state, s.work);
  });
}
