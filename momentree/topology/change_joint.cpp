#include <algorithm>
#include <cmath>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/sine_cosine.hpp>
#include <momentree/math/unit.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/new_joint.hpp>
#include <momentree/topology/velocities.hpp>
#include <momentree/tree/edit.hpp>

namespace momentree {

namespace {

double armature_of(const Tree& tree, int b, int i) { return tree.tables().armature[tree.first_p(b) + i]; }

// Sets a driven joint to its motion's position; its place in y holds the rate.
void follow_motion(const Tree& tree, int b, double t, double* q, double* y) {
  if (tree.link(b).driven == 0) return;
  const Curve::Point s = prescribed_motion(tree, b).at(t);
  q[0] = s.value, y[0] = s.rate;
}

// Replaces the numbers of b's joint, whose kind had `old`.
void put_joint(const Tree& tree, State& state, int b, const KindInfo& old, const double* q, const double* y) {
  const KindInfo& now = info(tree.joint(b).kind);
  state.replace(tree.first_q(b), old.nq, {q, static_cast<std::size_t>(now.nq)}, tree.first_p(b), old.nv,
                {y, static_cast<std::size_t>(now.nv)}, tree);
}

}  // namespace

void require_joint(const Joint& joint, const Values& q) noexcept {
  const KindInfo& kind = info(joint.kind);
  MT_REQUIRE(q.size() == kind.nq, "as many coordinates as the new joint's kind has");
  MT_REQUIRE(check_joint(spec_of(joint)).empty(), "a valid joint, according to check_joint()");
  MT_REQUIRE(!kind.axis || is_direction(joint.axis), "an axis of length 1");
  MT_REQUIRE(!kind.axis2 || is_direction(joint.axis2), "a second axis of length 1");
  MT_REQUIRE(is_placement(joint.at) && is_placement(joint.child_at), "finite placements with quaternions of length 1");
  for (const double x : q) MT_REQUIRE(std::isfinite(x), "finite coordinates");
  for (int i = 0; i < kind.nq; ++i) {
    if (kind.q_units[i] != 'n') continue;
    MT_REQUIRE(is_rotation(Quat{q[i], q[i + 1], q[i + 2], q[i + 3]}), "a quaternion of length 1");
    break;
  }
}

void new_joint_momenta(const Tree& tree, int b, const double* q, const Force<double>& Pb, double* p) noexcept {
  double c[2] = {}, s[2] = {};
  dispatch(tree.joint(b).kind, [&](auto tag) {
    using K = typename decltype(tag)::type::Kernels;
    for (std::size_t i = 0; i < K::angles.size(); ++i) {
      const double angle = q[K::angles[i]] + (K::rotates_about_z ? tree.link(b).angle_0 : 0.0);
      const SineCosine both = sine_cosine(angle);
      c[i] = both.c, s[i] = both.s;
    }
  });
  project(tree, b, {q, c, s}, to_kernel_frame(tree.frame(b), Pb), p);
  for (int i = 0; i < info(tree.joint(b).kind).nv; ++i)
    if ((tree.link(b).locked >> i & 1u) != 0) p[i] = 0;
}

Released apply(const ChangeJoint& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  const int b = tree.carrier(change.joint).index;
  return apply(change, to_user_frame(tree.frame(b), articulated_momentum(tree, state, workspace, b)), tree, state, workspace);
}

Released apply(const ChangeJoint& change, const Force<double>& Pb, Tree& tree, State& state,
               Workspace<double>& workspace) noexcept {
  const int b = tree.carrier(change.joint).index;
  MT_REQUIRE(state.topology() == tree.revision(), foreign_state);
  MT_REQUIRE(is_finite(Pb.l) && is_finite(Pb.h), "a finite momentum");
  const KindInfo& old = info(tree.joint(b).kind);
  const KindInfo& now = info(change.to.kind);
  require_joint(change.to, change.q);
  const int first_p = tree.first_p(b);
  using Direction = ChangeJoint::Direction;
  const bool reversed = change.direction == Direction::keep ? tree.reversed(b) : change.direction == Direction::reversed;
  // The same kind with the same parameters keeps its spring and armature; otherwise these leave with the joint.
  const bool keeps =
      change.to.kind == tree.joint(b).kind && change.to.parameters == tree.joint(b).parameters && reversed == tree.reversed(b);
  double u[6] = {};
  Released released;
  const bool velocities = in_velocities(state);
  MT_REQUIRE(!velocities || evaluated_on(tree, state, workspace), stale_workspace(state));
  Motion<double> own{}, outer{};
  if (evaluated_on(tree, state, workspace)) {
    for (int i = 0; i < old.nv; ++i) u[i] = workspace.v[static_cast<std::size_t>(first_p + i)];
    if (!keeps) released.energy = joint_energy(tree, state, workspace, b);
  }
  if (velocities) {
    own = user_velocity(tree, workspace, b), outer = user_velocity(tree, workspace, tree.parent(b));
    carry_momenta(tree, workspace);
  }
  tree.edit().set_joint(b, change.to, reversed);
  if (velocities) {
    double y[6] = {};
    Values at = change.q;
    if (now.kind == Kind::free)
      joint_velocities(tree, b, at.begin(), own, outer, y);
    else if (keeps)
      std::copy_n(u, now.nv, y);
    follow_motion(tree, b, state.time(), at.data(), y);
    put_joint(tree, state, b, old, at.begin(), y);
    if (now.kind != Kind::free) settle_velocities(tree, state, workspace, b);
    return released;
  }
  double p[6] = {};
  new_joint_momenta(tree, b, change.q.begin(), Pb, p);
  for (int i = 0; i < now.nv && keeps; ++i)
    if ((tree.link(b).locked >> i & 1u) == 0) p[i] += armature_of(tree, b, i) * u[i];
  Values q = change.q;
  follow_motion(tree, b, state.time(), q.data(), p);
  put_joint(tree, state, b, old, q.begin(), p);
  return released;
}

namespace {
unsigned all_dofs(const Tree& tree, int b) { return (1u << info(tree.joint(b).kind).nv) - 1; }
}  // namespace

Released apply(const Lock& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  const int b = tree.carrier(change.joint).index;
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  Joint joint = tree.joint(b);
  const unsigned newly = change.dofs & all_dofs(tree, b) & ~joint.locked;
  joint.locked |= newly;
  const int first_p = tree.first_p(b), nv = info(joint.kind).nv;
  double y[6] = {};
  Released released;  // the armature of a locked DoF stops with it
  for (int i = 0; i < nv; ++i) {
    const double u = workspace.v[static_cast<std::size_t>(first_p + i)];
    if ((newly >> i & 1u) != 0) released.energy += 0.5 * armature_of(tree, b, i) * u * u;
    if ((joint.locked >> i & 1u) == 0) y[i] = state.y()[static_cast<std::size_t>(first_p + i)];
  }
  if (in_velocities(state)) carry_momenta(tree, workspace);
  tree.edit().set_joint(b, joint);
  const double* q = state.q().data() + tree.first_q(b);
  double keep[7];
  for (int i = 0; i < info(joint.kind).nq; ++i) keep[i] = q[i];
  put_joint(tree, state, b, info(joint.kind), keep, y);
  if (in_velocities(state)) settle_velocities(tree, state, workspace, b);
  return released;
}

Released apply(const Unlock& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  const int b = tree.carrier(change.joint).index;
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  const Force<double> Pb = articulated_momentum(tree, state, workspace, b);
  double all[6] = {}, y[6] = {};
  const bool velocities = in_velocities(state);
  if (velocities)
    carry_momenta(tree, workspace);  // the joint's velocities are zero, and stay
  else
    project(tree, b, joint_state(tree, state, workspace, b), Pb, all);
  Joint joint = tree.joint(b);
  const unsigned freed = change.dofs & joint.locked;
  joint.locked &= ~freed;
  const KindInfo& kind = info(joint.kind);
  const int first_q = tree.first_q(b), first_p = tree.first_p(b);
  for (int i = 0; i < kind.nv; ++i) y[i] = (freed >> i & 1u) != 0 ? all[i] : state.y()[static_cast<std::size_t>(first_p + i)];
  double keep[7];
  for (int i = 0; i < kind.nq; ++i) keep[i] = state.q()[static_cast<std::size_t>(first_q + i)];
  tree.edit().set_joint(b, joint);
  follow_motion(tree, b, state.time(), keep, y);
  put_joint(tree, state, b, kind, keep, y);
  if (velocities && tree.link(b).driven != 0) settle_velocities(tree, state, workspace, b);
  return {};
}

Released apply(const Impulse& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  const int b = change.body.index;
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  MT_REQUIRE(is_finite(change.force) && is_finite(change.torque) && is_finite(change.point),
             "a finite impulse at a finite point");
  const DenseTransform<double> body = locate_body(tree, state, workspace, b);
  const KernelFrame& frame = tree.frame(b);
  Force<double> W{transpose_times(body.R, change.force), transpose_times(body.R, change.torque)};
  shift(W, transpose_times(frame.R, change.point - frame.r));
  if (in_velocities(state)) {  // the change of velocities that this momentum alone would cause
    for (const int x : tree.order()) workspace.carried[static_cast<std::size_t>(x)] = {};
    workspace.carried[static_cast<std::size_t>(b)] = W;
    double* const du = workspace.impulse.get();
    std::fill_n(du, tree.nv(), 0.0);
    project_velocities(tree, state.q().data(), du, workspace);
    const State::Edit edit = state.edit();
    for (std::size_t i = 0; i < edit.u.size(); ++i) edit.u[i] += du[i];
    return {};
  }
  const State::Edit edit = state.edit();
  absorb(tree, b, joint_state(tree, state, workspace, b), W, +1, edit.p.data());
  shed_momentum(tree, state, workspace, b, W, +1, edit.p.data());
  return {};
}

Released apply(const SetParameters& change, Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  const int b = tree.carrier(change.joint).index;
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  const KindInfo& kind = info(tree.joint(b).kind);
  {
    JointSpec spec = spec_of(tree.joint(b));
    spec.parameters = change.parameters;
    MT_REQUIRE(check_joint(spec).empty(), "valid parameters for this joint, according to check_joint()");
  }
  const int first_q = tree.first_q(b), first_p = tree.first_p(b);
  double q[7], p[6], all[6] = {};
  if (in_velocities(state)) {  // they stay, unless a motion begins
    carry_momenta(tree, workspace);
    std::copy_n(state.q().data() + first_q, kind.nq, q);
    std::copy_n(state.u().data() + first_p, kind.nv, p);
    tree.edit().set_parameters(b, change.parameters);
    follow_motion(tree, b, state.time(), q, p);
    put_joint(tree, state, b, kind, q, p);
    if (tree.link(b).driven != 0) settle_velocities(tree, state, workspace, b);
    return {};
  }
  const unsigned was_driven = tree.link(b).driven;
  if (was_driven != 0)
    project(tree, b, joint_state(tree, state, workspace, b), articulated_momentum(tree, state, workspace, b), all);
  for (int i = 0; i < kind.nq; ++i) q[i] = state.q()[static_cast<std::size_t>(first_q + i)];
  for (int i = 0; i < kind.nv; ++i)
    p[i] = state.p()[static_cast<std::size_t>(first_p + i)] -
           armature_of(tree, b, i) * workspace.v[static_cast<std::size_t>(first_p + i)];
  for (int i = 0; i < kind.nv; ++i)
    if ((was_driven >> i & 1u) != 0) p[i] = all[i];
  tree.edit().set_parameters(b, change.parameters);
  for (int i = 0; i < kind.nv; ++i) p[i] += armature_of(tree, b, i) * workspace.v[static_cast<std::size_t>(first_p + i)];
  follow_motion(tree, b, state.time(), q, p);
  put_joint(tree, state, b, kind, q, p);
  return {};
}

}  // namespace momentree
