// momentree: the changes of topology/change.hpp with the evaluations around them, the changes alone, and as a user's actions.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/topology/change.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

#include "evaluation.hpp"
#include "loops.hpp"
#include "measure.hpp"
#include "momentree_model.hpp"

namespace {

using namespace peers;

struct Engine : Trial {
  Engine(const Experiment& experiment, bool evaluations)
      : e(experiment), around(evaluations), model(model_of(e.links)), tree(mt::compile(model)), workspace(tree) {
    state = mt::start_state(model, tree);
    if (!around) forward_dynamics(tree, state, workspace);
  }

  void change() override {
    if (around) forward_dynamics(tree, state, workspace);
    const mt::BodyId body{e.body}, to{e.to};
    if (e.change == Change::cut) apply(mt::Break{tree.inboard_joint(body)}, tree, state, workspace);
    if (e.change == Change::lock) apply(mt::Lock{tree.inboard_joint(body)}, tree, state, workspace);
    if (e.change == Change::capture) {
      apply(mt::Join{body, to}, tree, state, workspace);
      forward_dynamics(tree, state, workspace);
      const double* q = state.q().data() + tree.first_q(e.body);  // pose in the hand
      mt::ChangeJoint weld;
      weld.joint = tree.inboard_joint(body);
      weld.to.at = mt::Pose{{q[0], q[1], q[2]}, {q[3], q[4], q[5], q[6]}};
      apply(weld, tree, state, workspace);
    }
    if (around) forward_dynamics(tree, state, workspace);
  }

  std::vector<Motion> motions() override {
    locate_bodies(tree, state, workspace);
    std::vector<Motion> all;
    for (int b = 0; b < tree.bodies(); ++b) {
      const auto& k = workspace.bodies[b];
      const mt::Pose pose = mt::user_pose(tree, k, b);
      const mt::Vec3 w = k.R * k.velocity.w;
      const mt::Vec3 v = k.R * k.velocity.v + cross(w, pose.position - k.r);
      all.push_back({mat(rotation_matrix(pose.rotation)), vec(pose.position), vec(v), vec(w)});
    }
    return all;
  }

  Experiment e;
  bool around;
  mt::Model model;
  mt::Tree tree;
  mt::State state;
  mt::Workspace<double> workspace;
};

struct User : Trial {
  explicit User(const Experiment& experiment) : e(experiment), simulation(model_of(e.links)) {}
  void change() override {
    const std::string& body = e.links[e.body].name;
    if (e.change == Change::cut) simulation.apply(mt::break_joint(body));
    if (e.change == Change::lock) simulation.apply(mt::lock(body));
    if (e.change == Change::capture) simulation.apply(mt::weld(body, e.links[e.to].name));
  }
  std::vector<Motion> motions() override {
    std::vector<Motion> all;
    for (const mt::BodyMotion& m : simulation.world().motions()) {
      all.push_back({mat(rotation_matrix(m.pose.rotation)), vec(m.pose.position), vec(m.linear), vec(m.angular)});
    }
    return all;
  }
  Experiment e;
  mt::Simulation simulation;
};

std::vector<Way> ways(Change change) {
  const std::string low = change == Change::cut ? "apply(Break)" : change == Change::lock ? "apply(Lock)" : "Join, ChangeJoint";
  const std::string high = change == Change::cut ? "break_joint" : change == Change::lock ? "lock" : "weld";
  std::vector<Way> found{{low, "with the evaluations before and after", maker<Engine>(true)}};
  if (change == Change::capture) {
    found.push_back({low, "the change and an evaluation between", maker<Engine>(false)});
  } else {
    found.push_back({low, "the change alone", maker<Engine>(false)});
  }
  found.push_back({"Simulation::apply(" + high + ")", "by name, checked, with certificate and impulses", maker<User>()});
  return found;
}

/// Momenta are the state: they are computed from the velocities outside the measured time, as a step would have left them.
struct Rates : Evaluator {
  explicit Rates(const EvaluationModel& m) : model(model_of(m.links, gravity)), tree(mt::compile(model)), workspace(tree) {
    for (mt::State& state : states) state = start_state(model, tree);
    first = m.floating() ? 1 : 0;
    for (int b = 0; b < tree.bodies(); ++b) places.push_back(static_cast<std::size_t>(tree.first_q(b)));
  }
  void evaluate(const double* q, const double* u) override {
    last = turn_of(q, u);
    evaluate_rates(tree, put(last, q), states[last].p().data(), workspace);
  }
  /// The index of the state that has these momenta, with its coordinates set.
  int turn_of(const double* q, const double* u) {
    if (q == seen[0]) return 0;
    if (q == seen[1]) return 1;
    const int k = count++ % 2;
    seen[k] = q;
    const double* coordinates = put(k, q);
    std::vector<double> v(static_cast<std::size_t>(tree.nv()));
    if (first > 0) std::copy(model.bodies()[0].v.begin(), model.bodies()[0].v.end(), v.begin());
    for (int b = first; b < tree.bodies(); ++b) v[tree.first_p(b)] = u[b];
    const mt::State::Edit edit = states[k].edit();
    project_momentum(tree, coordinates, v.data(), edit.p.data());
    return k;
  }
  const double* put(int k, const double* q) {
    const mt::State::Edit edit = states[k].edit();
    for (std::size_t i = static_cast<std::size_t>(first); i < places.size(); ++i) edit.q[places[i]] = q[i];
    return states[k].q().data();
  }
  /// Computed differently, from the state with these momenta.
  std::vector<double> accelerations() override {
    mt::Workspace<double> other(tree);
    accelerate(tree, states[last], other);
    double worst = 0, largest = 0;
    for (int i = 0; i < tree.nv(); ++i) {
      for (const auto& [x, y] : {std::pair(workspace.v[i], other.v[i]), std::pair(workspace.pdot[i], other.pdot[i])}) {
        worst = std::max(worst, std::abs(x - y)), largest = std::max(largest, std::abs(y));
      }
    }
    if (!(worst < 1e-7 * largest)) std::fprintf(stderr, "momentree: two ways of an evaluation differ\n"), std::exit(1);
    return read(other);
  }
  std::vector<double> read(const mt::Workspace<double>& found) const {
    std::vector<double> a(static_cast<std::size_t>(tree.bodies()));
    for (int b = first; b < tree.bodies(); ++b) a[b] = found.a[tree.first_p(b)];
    if (first == 0) return a;
    const double *v = found.v.get(), *rate = found.a.get(), *q = states[last].q().data();  // in the body's axes
    const Matrix3d turn = Eigen::Quaterniond(q[3], q[4], q[5], q[6]).toRotationMatrix();
    const Matrix3d R = mat(rotation_matrix(model.bodies()[0].at.rotation)) * turn;
    const Vector3d linear = R * (Vector3d(rate) + Vector3d(v + 3).cross(Vector3d(v))), angular = R * Vector3d(rate + 3);
    for (const Vector3d& each : {linear, angular}) a.insert(a.end(), each.data(), each.data() + 3);
    return a;
  }
  mt::Model model;
  mt::Tree tree;
  mt::Workspace<double> workspace;
  mt::State states[2];
  std::vector<std::size_t> places;  // of the bodies' coordinates
  const double* seen[2] = {nullptr, nullptr};
  int count = 0, last = 0, first = 0;
};

/// The same, followed by accelerations and all joint wrenches.
struct Accelerations : Rates {
  using Rates::Rates;
  void evaluate(const double* q, const double* u) override {
    last = turn_of(q, u);
    put(last, q);
    accelerate(tree, states[last], workspace);
  }
  std::vector<double> accelerations() override { return read(workspace); }
};

}  // namespace

int main(int count, char** words) {
  if (count == 1) return run("momentree", ways);
  if (std::string(words[1]) == "loops") return evaluate_loops("momentree", loop_ways(), count > 2 ? words[2] : "");
  return evaluate(
      "momentree",
      {{"evaluate_rates", evaluator<Rates>()}, {"accelerate (accelerations, all reactions)", evaluator<Accelerations>()}},
      {words + 2, words + count});
}
