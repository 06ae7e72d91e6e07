#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/new_joint.hpp>
#include <momentree/topology/reverse_path.hpp>
#include <momentree/topology/velocities.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

namespace {

// Re-roots the mechanism of b at b and attaches it to `to` by `joint` at `coordinates(relative pose)`; the ancestors of `to`
// absorb its momentum. Everything is read from the state before, since the two mechanisms do not interact there.
template <class Coordinates>
void attach(int b, int to, const Joint& joint, bool reversed, Coordinates coordinates, Tree& tree, State& state,
            Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  MT_REQUIRE(to == ground.index || tree.alive(to), "the other body is the ground or in the tree");
  MT_REQUIRE(floats(tree, {b}), floating);
  MT_REQUIRE(to < 0 || root_of(tree, {b}).index != root_of(tree, {to}).index, "the bodies belong to different mechanisms");
  Pose relative = user_pose(tree, locate_body(tree, state, workspace, b), b);
  if (to >= 0) relative = inverse(user_pose(tree, locate_body(tree, state, workspace, to), to)) * relative;
  const int root = root_of(tree, {b}).index, first_q = tree.first_q(root), first_p = tree.first_p(root);
  Force<double> Pb;
  const bool velocities = in_velocities(state);
  const Motion<double> own = user_velocity(tree, workspace, b), outer = user_velocity(tree, workspace, to);
  if (velocities) {
    carry_momenta(tree, workspace);
  } else {
    const State::Edit edit = state.edit();
    double* p = edit.p.data();
    Pb = reverse_momenta(tree, state, workspace, b, p);
    if (to >= 0) {  // to the kernel frame of `to`, whose own joint absorbs it first
      const Mat3 R = rotation_matrix(relative.rotation);
      Force<double> W{R * Pb.l, R * Pb.h};
      shift(W, relative.position);
      W = to_kernel_frame(tree.frame(to), W);
      absorb(tree, to, joint_state(tree, state, workspace, to), W, +1, p);
      shed_momentum(tree, state, workspace, to, W, +1, p);
    }
  }
  tree.edit().attach(b, to, joint, reversed);
  const KindInfo& kind = info(joint.kind);
  double q[7], y[6] = {};
  coordinates(relative, q);
  const bool free = joint.kind == Kind::free;
  if (!velocities)
    new_joint_momenta(tree, b, q, Pb, y);
  else if (free)
    joint_velocities(tree, b, q, own, outer, y);
  state.replace(first_q, 7, {q, static_cast<std::size_t>(kind.nq)}, first_p, 6, {y, static_cast<std::size_t>(kind.nv)}, tree);
  if (velocities && !free) settle_velocities(tree, state, workspace, b);
}

}  // namespace

Released apply(const Join& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  attach(change.body.index, change.to.index, floating_root_joint(), false, free_coordinates, tree, state, workspace);
  return {};
}

Released apply(const Attach& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  const KindInfo& kind = info(change.joint.kind);
  require_joint(change.joint, change.q);
  const auto given = [&](const Pose&, double* q) {
    for (int i = 0; i < kind.nq; ++i) q[i] = change.q[i];
  };
  attach(change.body.index, change.to.index, change.joint, change.reversed, given, tree, state, workspace);
  return {};
}

}  // namespace momentree
