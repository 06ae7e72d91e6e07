#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/topology/velocities.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

bool can_break(const Tree& tree, JointId joint) noexcept {
  if (joint.index < 0 || joint.index >= tree.bodies()) return false;
  const int b = tree.carrier(joint.index);
  if (b < 0) return false;
  if (tree.parent(b) >= 0 || tree.joint(b).kind != Kind::free) return true;
  // A floating root is still held by locks, springs, dampers and armatures.
  const JointParameters* p = tree.parameters(b);
  return tree.joint(b).locked != 0 || (p != nullptr && p->any());
}

Released apply(const Break& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  MT_REQUIRE(can_break(tree, change.joint), "the joint is in the tree, and holds a body: see can_break()");
  const int b = tree.carrier(change.joint).index;

  const Force<double> Pb = articulated_momentum(tree, state, workspace, b);
  const Pose pose = user_pose(tree, locate_body(tree, state, workspace, b), b);
  const Released released{joint_energy(tree, state, workspace, b)};
  const KernelFrame frame = tree.frame(b);
  const int first_q = tree.first_q(b), first_p = tree.first_p(b);
  const KindInfo& old = info(tree.joint(b).kind);
  const bool velocities = in_velocities(state);
  Motion<double> velocity{};
  if (velocities) {
    velocity = user_velocity(tree, workspace, b);
  } else {
    const State::Edit edit = state.edit();
    shed_momentum(tree, state, workspace, b, Pb, -1, edit.p.data());
  }

  tree.edit().detach(b);  // now the user frame of b is its kernel frame
  const Force<double> P = to_user_frame(frame, Pb);
  const double q[7] = {pose.position.x, pose.position.y, pose.position.z, pose.rotation.w,
                       pose.rotation.x, pose.rotation.y, pose.rotation.z};
  double y[6] = {P.l.x, P.l.y, P.l.z, P.h.x, P.h.y, P.h.z};
  if (velocities) joint_velocities(tree, b, q, velocity, {}, y);
  state.replace(first_q, old.nq, q, first_p, old.nv, y, tree);
  return released;
}

}  // namespace momentree
