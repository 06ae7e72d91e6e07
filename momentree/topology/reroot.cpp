#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/reverse_path.hpp>
#include <momentree/topology/velocities.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

BodyId root_of(const Tree& tree, BodyId body) noexcept {
  while (tree.parent(body.index) >= 0) body = {tree.parent(body.index)};
  return body;
}

bool floats(const Tree& tree, BodyId body) noexcept {
  if (!tree.alive(body.index)) return false;
  const int root = root_of(tree, body).index;
  const JointParameters* p = tree.parameters(root);
  return tree.joint(root).kind == Kind::free && tree.joint(root).locked == 0 && tree.joint(root).function < 0 &&
         (p == nullptr || !(p->stiffness.any() || p->damping.any() || p->armature.any() || p->effort.any() || p->friction.any() ||
                            p->drive != nullptr));
}

// total = Pb of the root; along the path, total ← X⁻ᵀ total, and each reversed joint keeps the momentum of its other side: p ← p
// − Eᵀ total.
Force<double> reverse_momenta(const Tree& tree, const State& state, Workspace<double>& workspace, int b, double* p) noexcept {
  int length = 0, root = b;
  for (; tree.parent(root) >= 0; root = tree.parent(root)) workspace.path[static_cast<std::size_t>(length++)] = root;
  Force<double> total =  // of the root's joint, whose momenta may be under edit: Pb = E⁻ᵀ p
      FreeKernels::wrench<double>(FreeKernels::offset<double>(tree.link(root)), state.p().data() + tree.first_p(root));
  while (length > 0) {
    const int x = workspace.path[static_cast<std::size_t>(--length)];
    const DenseTransform<double> crossing = joint_transform_of(tree, state, workspace, x);
    total = {transpose_times(crossing.R, total.l), transpose_times(crossing.R, total.h - cross(crossing.r, total.l))};
    absorb(tree, x, joint_state(tree, state, workspace, x), total, -1, p);
  }
  return to_user_frame(tree.frame(b), total);
}

Released apply(const Reroot& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  const int b = change.body.index;
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  MT_REQUIRE(floats(tree, {b}), floating);
  const Pose pose = user_pose(tree, locate_body(tree, state, workspace, b), b);
  const int root = root_of(tree, {b}).index, first_q = tree.first_q(root), first_p = tree.first_p(root);
  const Motion<double> velocity = user_velocity(tree, workspace, b);
  const bool velocities = in_velocities(state);  // those of the joints on the way stay
  Force<double> P{};
  if (!velocities) {
    const State::Edit edit = state.edit();
    P = reverse_momenta(tree, state, workspace, b, edit.p.data());
  }
  tree.edit().reroot(b);
  double q[7];
  free_coordinates(pose, q);
  double y[6] = {P.l.x, P.l.y, P.l.z, P.h.x, P.h.y, P.h.z};
  if (velocities) joint_velocities(tree, b, q, velocity, {}, y);
  state.replace(first_q, 7, q, first_p, 6, y, tree);
  return {};
}

}  // namespace momentree
