#include <momentree/dynamics/forward.hpp>

#include <momentree/joint/dispatch.hpp>

namespace momentree {

void add_joint_forces(const Tree& tree, const double* q, Work<double>& work) noexcept {
  work.power = {};
  if (tree.has_forces()) {
    const double *damping = tree.damping(), *effort = tree.effort(), *v = work.v.get();
    double* pdot = work.pdot.get();
    double dissipated = 0, given = 0;
    for (int i = 0; i < tree.nv(); ++i) {
      const double friction = damping[i] * v[i];
      pdot[i] += effort[i] - friction;
      dissipated += friction * v[i];
      given += effort[i] * v[i];
    }
    work.power = {dissipated, given};
  }
  for (int b : tree.spring_joints()) {
    double force[6];
    joint_spring(tree, q, b, force);
    const unsigned locked = tree.joint(b).locked;
    for (int i = 0; i < info(tree.joint(b).kind).nv; ++i)
      if ((locked >> i & 1u) == 0) work.pdot[static_cast<std::size_t>(tree.first_p(b) + i)] += force[i];
  }
}

double joint_spring(const Tree& tree, const double* q, int b, double* force) noexcept {
  return dispatch(tree.joint(b).kind, [&](auto tag) {
    using K = typename decltype(tag)::type;
    const JointParameters& p = *tree.parameters(b);
    double stiffness[6] = {}, rest[7] = {};
    K::Kernels::zero(rest);
    for (int i = 0; i < K::info.nv; ++i) stiffness[i] = p.stiffness.size() == 1 ? p.stiffness[0] : p.stiffness[i];
    if (!p.rest.empty())
      for (int i = 0; i < K::info.nq; ++i) rest[i] = p.rest[i];
    return K::Kernels::spring(q + tree.first_q(b), rest, stiffness, force);
  });
}

void forward_dynamics(const Tree& tree, const State& state, Work<double>& work) noexcept {
  MT_REQUIRE(state.topology() == tree.revision(), "the state is of this tree's present topology");
  if (work.evaluated == state.stamp()) return;
  evaluate_rates<double>(tree, state.q().data(), state.p().data(), work);
  add_joint_forces(tree, state.q().data(), work);
  work.evaluated = state.stamp();
}

void locate_bodies(const Tree& tree, const State& state, Work<double>& work) noexcept {
  forward_dynamics(tree, state, work);
  if (work.located == state.stamp()) return;
  for (int b : tree.order()) {
    const int parent = tree.parent(b);
    const Kinematics<double> outer =
        parent < 0 ? Kinematics<double>{identity3<double>(), {}, {}} : work.bodies[static_cast<std::size_t>(parent)];
    work.bodies[static_cast<std::size_t>(b)] = across_joint(tree, state, work, b, outer);
  }
  work.located = state.stamp();
}

Kinematics<double> across_joint(const Tree& tree, const State& state, const Work<double>& work, int b,
                                const Kinematics<double>& outer) noexcept {
  return dispatch_kernels(tree.joint(b).kind, tree.variant(b), [&](auto tag) {
    using K = typename decltype(tag)::type;
    const JointState<double> joint{state.q().data() + tree.first_q(b), work.cos.get() + tree.first_angle(b),
                                   work.sin.get() + tree.first_angle(b)};
    const DenseCrossing<double> x = dense_crossing<K, double>(tree.link(b), joint);
    Kinematics<double> own{outer.R * x.R, outer.r + outer.R * x.r, outer.velocity};
    x.outboard(own.velocity);
    own.velocity = K::template spatial_velocity<double>(tree.link(b), joint, own.velocity, work.v.get() + tree.first_p(b));
    return own;
  });
}

}  // namespace momentree
