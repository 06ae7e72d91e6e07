#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

Released apply(const Join& change, Tree& tree, State& state, Work<double>& work) noexcept {
  const int b = change.body.index, to = change.to.index;
  MT_REQUIRE(to < 0 || root_of(tree, b) != root_of(tree, to), "the bodies belong to different mechanisms");
  apply(Reroot{change.body}, tree, state, work);  // also where b is the root already: its joint then stands at its own frame
  if (to < 0) return {};
  forward_dynamics(tree, state, work);
  const Pose pose = user_pose(tree, locate_body(tree, state, work, b), b);
  const Pose outer = user_pose(tree, locate_body(tree, state, work, to), to);
  const Pose relative = inverse(outer) * pose;
  const int first_q = tree.first_q(b), first_p = tree.first_p(b);
  const double* r = state.p().data() + first_p;
  Force<double> W{{r[0], r[1], r[2]}, {r[3], r[4], r[5]}};  // Pb of the whole mechanism, in b's frame
  // Into the kernel frame of `to`, whose own joint is the first to absorb it.
  const Mat3 R = rotation_matrix(relative.rotation);
  W = {R * W.l, R * W.h};
  shift(W, relative.position);
  W = to_kernel_frame(tree.frame(to), W);
  const auto p = state.edit().p;
  absorb(tree, to, joint_state(tree, state, work, to), W, +1, p.data());
  shed_momentum(tree, state, work, to, W, +1, p.data());
  tree.regraft(b, to);
  const double q[7] = {relative.position.x, relative.position.y, relative.position.z, relative.rotation.w,
                       relative.rotation.x, relative.rotation.y, relative.rotation.z};
  double momenta[6];
  for (int i = 0; i < 6; ++i) momenta[i] = state.p()[static_cast<std::size_t>(first_p + i)];
  state.replace(first_q, 7, q, first_p, 6, momenta, tree.revision());
  return {};
}

}  // namespace momentree
