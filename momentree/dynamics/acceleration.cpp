#include <momentree/dynamics/evaluate.hpp>

#include <momentree/dynamics/forces/body_forces.hpp>
#include <momentree/dynamics/loops/loop_momenta.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

// Transforms a wrench on body b through its inboard joint, in b's kernel frame, to the declared child's user frame.
Wrench on_declared_child(const Tree& tree, const State& state, const Workspace<double>& workspace, int b,
                         const Force<double>& W) {
  const auto wrench = [](const Force<double>& force) { return Wrench{force.l, force.h}; };
  if (!tree.reversed(b)) return wrench(to_user_frame(tree.frame(b), W));
  const int child = tree.parent(b);
  MT_REQUIRE(child >= 0, "the ground is not a joint's child");
  Force<double> back{-W.l, -W.h};
  joint_transform_of(tree, state, workspace, b).inboard(back);
  return wrench(to_user_frame(tree.frame(child), back));
}

}  // namespace

void accelerate(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  forward_dynamics(tree, state, workspace);
  if (tree.has_loops()) {
    if (!(workspace.accelerated == state.stamp())) accelerate_with_loops(tree, state, workspace);
    if (!workspace.loops->least) find_least_reactions(tree, state.time(), workspace);
    return;
  }
  if (workspace.accelerated == state.stamp()) return;
  joint_forces(tree, state.time(), state.q().data(), workspace, workspace.a.get());
  clear_other_loads(tree, workspace);
  evaluate_accelerations<double>(tree, state.q().data(), workspace);
  workspace.accelerated = state.stamp();
}

Motion<double> felt_acceleration(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept {
  const JointState<double> joint = joint_state(tree, q, workspace, b);
  return dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
    return decltype(tag)::type::template spatial_velocity<double>(
        tree.link(b), joint, workspace.inboard_accelerations[static_cast<std::size_t>(b)], workspace.a.get() + tree.first_p(b));
  });
}

Force<double> transmitted_wrench(const Tree& tree, const Workspace<double>& workspace, int b) noexcept {
  MT_REQUIRE(b >= 0 && b < tree.bodies() && tree.alive(b), "the tree has a body of that number, and it was not removed");
  Force<double> Tr = workspace.reduced_bias_wrenches[static_cast<std::size_t>(b)];
  dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
    using K = typename decltype(tag)::type;
    K::add_reduced(workspace.record<K>(tree, b), workspace.inboard_accelerations[static_cast<std::size_t>(b)], Tr);  // (44), (32)
  });
  return Tr;
}

Wrench reaction(const Tree& tree, const State& state, const Workspace<double>& workspace, JointId joint) noexcept {
  const int b = tree.carrier(joint).index;
  MT_REQUIRE(accelerated_on(tree, state, workspace), stale_accelerations(state));
  return on_declared_child(tree, state, workspace, b, transmitted_wrench(tree, workspace, b));
}

Wrench bearing_reaction(const Tree& tree, const State& state, const Workspace<double>& workspace, JointId joint) noexcept {
  const int b = tree.carrier(joint).index;
  MT_REQUIRE(accelerated_on(tree, state, workspace), stale_accelerations(state));
  const Force<double> Tr = transmitted_wrench(tree, workspace, b);
  const JointState<double> at = joint_state(tree, state, workspace, b);
  const Force<double> drive = dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
    using K = typename decltype(tag)::type;
    const auto E = K::template columns<double>(tree.link(b), at);
    double force[6] = {};
    for (std::size_t i = 0; i < E.size(); ++i)
      if ((tree.joint(b).locked >> i & 1u) == 0) force[i] = dot(E[i], Tr);
    return K::drive_wrench(tree.link(b), at, force);
  });
  return on_declared_child(tree, state, workspace, b, Tr - drive);
}

void joint_effort(const Tree& tree, const State& state, const Workspace<double>& workspace, JointId joint,
                  double* effort) noexcept {
  const int b = tree.carrier(joint).index;
  MT_REQUIRE(accelerated_on(tree, state, workspace), stale_accelerations(state));
  project(tree, b, joint_state(tree, state, workspace, b), transmitted_wrench(tree, workspace, b), effort);
  const int at = tree.first_p(b);
  for (int i = 0; i < info(tree.kind(b)).nv; ++i)
    effort[i] += tree.tables().armature[at + i] * workspace.a[static_cast<std::size_t>(at + i)];
}

BodyAcceleration body_acceleration(const Tree& tree, const State& state, const Workspace<double>& workspace,
                                   BodyId body) noexcept {
  const int b = body.index;
  MT_REQUIRE(accelerated_on(tree, state, workspace), stale_accelerations(state));
  MT_REQUIRE(workspace.located == state.stamp(), "the bodies are located at this state: call locate_bodies first");
  const Kinematics<double>& located = workspace.bodies[static_cast<std::size_t>(b)];
  const Motion<double> rate = felt_acceleration(tree, state.q().data(), workspace, b);
  const KernelFrame& frame = tree.frame(b);
  // The components of Ω are in rotating body axes: d(Rv)/dt = R (v̇ + ω × v). Then from the kernel frame's origin to the user
  // frame's, and plus gravity.
  const Vec3 &v = located.velocity.v, &w = located.velocity.w, to = -transpose_times(frame.R, frame.r);
  const Vec3 linear = rate.v + cross(w, v) + cross(rate.w, to) + cross(w, cross(w, to));
  return {located.R * linear + tree.gravity(), located.R * rate.w};
}

}  // namespace momentree
