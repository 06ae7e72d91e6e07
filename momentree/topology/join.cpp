#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/new_joint.hpp>
#include <momentree/topology/turn_over.hpp>

namespace momentree {

namespace {

// The mechanism of b, re-rooted there, hangs on `to` by `joint` at `coordinates(relative pose)`; ancestors of `to` absorb its
// momentum. All that is read is of the state before: the two mechanisms know nothing of each other.
template <class Coordinates>
void attach(int b, int to, const Joint& joint, bool reversed, Coordinates coordinates, Tree& tree, State& state,
            Work<double>& work) noexcept {
  MT_REQUIRE(work.evaluated == state.stamp() && state.topology() == tree.revision(), "the work was evaluated on this state");
  MT_REQUIRE(to < 0 || tree.alive(to), "the body was not removed");
  MT_REQUIRE(floats(tree, b), "the mechanism floats");
  MT_REQUIRE(to < 0 || root_of(tree, b) != root_of(tree, to), "the bodies belong to different mechanisms");
  Pose relative = user_pose(tree, locate_body(tree, state, work, b), b);
  if (to >= 0) relative = inverse(user_pose(tree, locate_body(tree, state, work, to), to)) * relative;
  const int root = root_of(tree, b), first_q = tree.first_q(root), first_p = tree.first_p(root);
  double* p = state.edit().p.data();
  const Force<double> Pb = turn_over_momenta(tree, state, work, b, p);
  if (to >= 0) {  // into the kernel frame of `to`, whose own joint is the first to absorb it
    const Mat3 R = rotation_matrix(relative.rotation);
    Force<double> W{R * Pb.l, R * Pb.h};
    shift(W, relative.position);
    W = to_kernel_frame(tree.frame(to), W);
    absorb(tree, to, joint_state(tree, state, work, to), W, +1, p);
    shed_momentum(tree, state, work, to, W, +1, p);
  }
  tree.attach(b, to, joint, reversed);
  const KindInfo& kind = info(joint.kind);
  double q[7], momenta[6];
  coordinates(relative, q);
  new_joint_momenta(tree, b, q, Pb, momenta);
  state.replace(first_q, 7, {q, static_cast<std::size_t>(kind.nq)}, first_p, 6, {momenta, static_cast<std::size_t>(kind.nv)},
                tree.revision());
}

}  // namespace

Released apply(const Join& change, Tree& tree, State& state, Work<double>& work) noexcept {
  attach(change.body.index, change.to.index, made_free_joint(), false, free_coordinates, tree, state, work);
  return {};
}

Released apply(const Attach& change, Tree& tree, State& state, Work<double>& work) noexcept {
  const KindInfo& kind = info(change.joint.kind);
  MT_REQUIRE(change.q.size() == kind.nq, "the new joint's coordinates are given");
  const auto given = [&](const Pose&, double* q) {
    for (int i = 0; i < kind.nq; ++i) q[i] = change.q[i];
  };
  attach(change.body.index, change.to.index, change.joint, change.reversed, given, tree, state, work);
  return {};
}

}  // namespace momentree
