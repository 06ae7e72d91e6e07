#include <momentree/dynamics/forward.hpp>

#include <momentree/dynamics/body_forces.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {
void add_springs(const Tree& tree, const double* q, double* force) noexcept {
  for (int b : tree.spring_joints()) {
    double spring[6];
    joint_spring(tree, q, b, spring);
    const unsigned locked = tree.joint(b).locked;
    for (int i = 0; i < info(tree.joint(b).kind).nv; ++i)
      if ((locked >> i & 1u) == 0) force[tree.first_p(b) + i] += spring[i];
  }
}
}  // namespace

void add_joint_forces(const Tree& tree, [[maybe_unused]] double t, const double* q, Work<double>& work) noexcept {
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
  add_springs(tree, q, work.pdot.get());
}

void joint_forces(const Tree& tree, [[maybe_unused]] double t, const double* q, const Work<double>& work, double* tau) noexcept {
  const double *damping = tree.damping(), *effort = tree.effort(), *v = work.v.get();
  for (int i = 0; i < tree.nv(); ++i) tau[i] = tree.has_forces() ? effort[i] - damping[i] * v[i] : 0.0;
  add_springs(tree, q, tau);
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
  evaluate_motions<double>(tree, state.q().data(), state.p().data(), work);
  add_joint_forces(tree, state.time(), state.q().data(), work);
  add_body_forces(tree, state.time(), state.q().data(), work);
  work.evaluated = state.stamp();
}

void locate_stage(const Tree& tree, const double* q, Work<double>& work) noexcept {
  for (int b : tree.order()) {
    const int parent = tree.parent(b);
    const DenseCrossing<double> x = joint_crossing(tree, q, work, b);
    Kinematics<double>& own = work.bodies[static_cast<std::size_t>(b)];
    Motion<double> velocity{};
    if (parent < 0) {
      own.R = x.R, own.r = x.r;
    } else {
      const Kinematics<double>& outer = work.bodies[static_cast<std::size_t>(parent)];
      own.R = outer.R * x.R;
      own.r = outer.r + outer.R * x.r;
      velocity = outer.velocity;
    }
    x.outboard(velocity);
    own.velocity = dispatch_kernels(tree.joint(b).kind, tree.variant(b), [&](auto tag) {
      return decltype(tag)::type::template spatial_velocity<double>(tree.link(b), joint_state(tree, q, work, b), velocity,
                                                                    work.v.get() + tree.first_p(b));
    });
  }
}

void locate_bodies(const Tree& tree, const State& state, Work<double>& work) noexcept {
  forward_dynamics(tree, state, work);
  if (work.located == state.stamp()) return;
  for (int b : tree.order()) {
    const auto i = static_cast<std::size_t>(b);
    const int parent = tree.parent(b);
    const DenseCrossing<double> x = joint_crossing(tree, state, work, b);
    Kinematics<double>& own = work.bodies[i];
    own.velocity = work.motions[i].velocity;
    if (parent < 0) {
      own.R = x.R, own.r = x.r;
    } else {
      const Kinematics<double>& outer = work.bodies[static_cast<std::size_t>(parent)];
      own.R = outer.R * x.R;
      own.r = outer.r + outer.R * x.r;
    }
  }
  work.located = state.stamp();
}

DenseCrossing<double> joint_crossing(const Tree& tree, const double* q, const Work<double>& work, int b) noexcept {
  return dispatch_kernels(tree.joint(b).kind, tree.variant(b), [&](auto tag) -> DenseCrossing<double> {
    using K = typename decltype(tag)::type;
    if constexpr (K::turns_about_z) {
      return dense_crossing<K, double>(tree.link(b), joint_state(tree, q, work, b));
    } else {
      return work.record<K>(tree, b).x;
    }
  });
}

}  // namespace momentree
