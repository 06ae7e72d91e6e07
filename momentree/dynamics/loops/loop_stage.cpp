// Stages with closed loops by generated code.
#include <algorithm>
#include <cstring>
#include <type_traits>

#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/velocity.hpp>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct StageCalls : LoopCalls {
  const Tree* tree;
  double time;
  LoopWorkspace* loops;
  Power* power;
};

void answer_joint(const LoopCalls* calls, int loop, const double* numbers, int answers, double* answer) noexcept {
  const auto& stage = *static_cast<const StageCalls*>(calls);
  const Tree& tree = *stage.tree;
  const LoopWorkspace& loops = *stage.loops;
  const LoopLink& link = tree.loops().links[at(loop)];
  LoopPlace place;
  static_assert(std::is_trivially_copyable_v<LoopPlace> && sizeof place % sizeof(double) == 0);
  std::memcpy(static_cast<void*>(&place), numbers, sizeof place);
  const auto put = [&](const Vec3& a) {
    for (const double x : {a.x, a.y, a.z}) *answer++ = x;
  };
  Force<double> force{};
  if (detail::has_forces(tree.loops()[at(loop)]))
    force = detail::loop_force(tree, stage.time, loop, place, loops.turns[at(loop)], nullptr, *stage.power);
  put(force.l), put(force.h);
  for (int k = 0; loop_answers(k) < answers; ++k) {
    const LoopRow row = detail::dof_row(tree, loop, link.dof_rows[at(k)], place, loops.turns[at(loop)], loops.motions[at(loop)]);
    put(row.F), put(row.T);
    *answer++ = row.drift, *answer++ = row.softness;
  }
}

// The accelerations of prescribed motions of loop joints, in the order of their rows.
void put_loop_motions(const Tree& tree, const LoopWorkspace& loops, double* to) {
  if (tree.loops().motions == 0) return;
  for (std::size_t i = 0; i < tree.loops().size(); ++i)
    if (tree.loops()[i].driven()) *to++ = loops.motions[i].acceleration;
}

}  // namespace

bool evaluate_loop_stage(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                         const GeneratedRates& generated) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  if (generated.loops == nullptr || loops.topology != tree.loops().revision() || loops.rank < 0 ||
      !std::ranges::equal(loops.kept.rows, generated.rows))
    return false;
  workspace.evaluated = workspace.located = workspace.accelerated = {};
  std::copy_n(u, tree.nv(), workspace.v.get());
  double* const tau = loops.forces.data();
  workspace.power = joint_forces(tree, t, q, workspace, tau, workspace.passive.get());
  detail::add_extra_efforts(tree, loops, tau);
  detail::set_loop_motions(tree, t, workspace);
  put_loop_motions(tree, loops, tau + tree.nv());
  const std::size_t n = generated.rows.size();
  double* const effort = loops.answers.data() + n;
  StageCalls calls{{loops.least_pivots.data(), loops.answers.data(), effort, answer_joint}, &tree, t, &loops, &workspace.power};
  generated.loops(q, u, tau, &calls, workspace.qdot.get(), workspace.a.get());
  for (std::size_t i = 0; i < tree.joints_with().motions.size(); ++i) {
    const int b = tree.joints_with().motions[i];
    workspace.power.work += (effort[i] - workspace.passive[at(b)]) * u[tree.first_p(b)];
  }
  if (tree.loops().motions == 0) return true;
  std::fill(loops.lambda.begin(), loops.lambda.end(), 0.0);
  for (std::size_t i = 0; i < n; ++i) loops.lambda[at(generated.rows[i])] = loops.answers[i];
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const LoopMotion motion = loop_motion(tree, workspace, static_cast<int>(i));
    workspace.power.work += (motion.effort + motion.inertial) * motion.rate;
  }
  return true;
}

}  // namespace momentree
