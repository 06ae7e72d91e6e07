// momentree with closed loops: a stage of an integrator, which keeps the rows of the step, and whole states.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>

#include <algorithm>

#include "loops.hpp"
#include "momentree_model.hpp"

namespace {

using namespace peers;

enum class What { stage, state, reactions };

mt::Pose pose(const Matrix3d& turn, const Vector3d& at) { return {vec(at), mt::quaternion_of(mat(turn))}; }

mt::Model model_of(const LoopModel& m, bool pins) {
  mt::Model model = model_of(m.links, gravity);
  for (std::size_t i = 0; i < m.loops.size(); ++i) {
    const LoopJoint& loop = m.loops[i];
    mt::LoopSpec spec;
    spec.name = "loop" + std::to_string(i);
    spec.body = {loop.body}, spec.to = {loop.to};
    spec.at = pose(loop.to_turn, loop.to_at), spec.child_at = pose(loop.turn, loop.at);
    if (!m.planar) spec.joint = mt::Weld{};
    if (m.planar && pins) spec.joint = mt::Revolute{.axis = mt::z_axis};
    if (m.planar && !pins) spec.joint = mt::Ball{};
    model.add_loop(spec);
  }
  return model;
}

struct Loops : LoopEvaluator {
  Loops(const LoopModel& m, What evaluated, bool pins) : what(evaluated), model(model_of(m, pins)), tree(mt::compile(model)) {
    workspace = mt::Workspace<double>(tree);
    state = start_state(model, tree, mt::Variables::velocities);
    first = m.floating() ? 1 : 0;
    for (int k = 0; k < 2; ++k) {
      const LoopState& from = m.states[k];
      q[k].assign(state.q().begin(), state.q().end()), u[k].assign(static_cast<std::size_t>(tree.nv()), 0.0);
      for (int b = first; b < tree.bodies(); ++b) {
        const auto i = static_cast<std::size_t>(b);
        q[k][static_cast<std::size_t>(tree.first_q(b))] = from.q[i], u[k][static_cast<std::size_t>(tree.first_p(b))] = from.u[i];
      }
      if (first == 0) continue;
      R[k] = from.root.R, w[k] = from.root.w, v[k] = from.root.v;
      const Link& root = m.links.front();
      const Vector3d at = root.turn.transpose() * (from.root.p - root.at), own_v = R[k].transpose() * v[k],
                     own_w = R[k].transpose() * w[k];
      const Eigen::Quaterniond turn(Matrix3d(root.turn.transpose() * R[k]));
      const double coordinates[] = {at.x(), at.y(), at.z(), turn.w(), turn.x(), turn.y(), turn.z()};
      std::copy_n(coordinates, 7, q[k].data() + tree.first_q(0));
      std::copy_n(own_v.data(), 3, u[k].data() + tree.first_p(0)),
          std::copy_n(own_w.data(), 3, u[k].data() + tree.first_p(0) + 3);
    }
    put(0);
    evaluate_velocity_state(tree, state, workspace);  // chooses the rows
  }
  void evaluate(int k) override {
    last = k;
    if (what == What::stage) return evaluate_velocity_stage(tree, 0, q[k].data(), u[k].data(), workspace);
    put(k);
    if (what == What::state) evaluate_velocity_state(tree, state, workspace);
    if (what == What::reactions) accelerate(tree, state, workspace);
  }
  void put(int k) {
    const mt::State::Edit edit = state.edit();
    std::copy(q[k].begin(), q[k].end(), edit.q.begin());
    std::copy(u[k].begin(), u[k].end(), edit.u.begin());
  }
  std::vector<double> accelerations() override {
    std::vector<double> a(static_cast<std::size_t>(tree.bodies()));
    for (int b = first; b < tree.bodies(); ++b)
      a[static_cast<std::size_t>(b)] = workspace.a[static_cast<std::size_t>(tree.first_p(b))];
    if (first == 0) return a;
    const double* const rate = workspace.a.get() + tree.first_p(0);  // in the body's axes
    const Vector3d linear = R[last] * Vector3d(rate) + w[last].cross(v[last]), angular = R[last] * Vector3d(rate + 3);
    for (const Vector3d& each : {linear, angular}) a.insert(a.end(), each.data(), each.data() + 3);
    return a;
  }
  What what;
  mt::Model model;
  mt::Tree tree;
  mt::Workspace<double> workspace;
  mt::State state;
  std::vector<double> q[2], u[2];
  Matrix3d R[2];
  Vector3d v[2], w[2];  // of the root
  int first = 0, last = 0;
};

bool planar(const LoopModel& model) { return model.planar; }

}  // namespace

std::vector<LoopWay> peers::loop_ways() {
  return {{"evaluate_velocity_stage, ball or weld", loop_evaluator<Loops>(What::stage, false)},
          {"evaluate_velocity_stage, revolute", loop_evaluator<Loops>(What::stage, true), planar},
          {"evaluate_velocity_state, ball or weld", loop_evaluator<Loops>(What::state, false)},
          {"evaluate_velocity_state, revolute", loop_evaluator<Loops>(What::state, true), planar},
          {"accelerate (all reactions), ball or weld", loop_evaluator<Loops>(What::reactions, false)},
          {"accelerate (all reactions), revolute", loop_evaluator<Loops>(What::reactions, true), planar}};
}
