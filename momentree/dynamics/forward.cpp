#include <momentree/dynamics/evaluate.hpp>

#include <algorithm>

#include <momentree/dynamics/forces/body_forces.hpp>
#include <momentree/dynamics/forces/elements.hpp>
#include <momentree/dynamics/forces/evaluation_context.hpp>
#include <momentree/dynamics/forces/joint_spring.hpp>
#include <momentree/dynamics/forces/linear_spring.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/loops/loop_momenta.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

void add_springs(const Tree& tree, const double* q, double* force) noexcept {
  for (int b : tree.joints_with().springs) {
    double spring[6];
    joint_spring(tree, q, b, spring);
    const unsigned locked = tree.joint(b).locked;
    for (int i = 0; i < info(tree.kind(b)).nv; ++i)
      if ((locked >> i & 1u) == 0) force[tree.first_p(b) + i] += spring[i];
  }
}

// All force elements except springs, dampers and constant efforts.
void add_elements(const EvaluationContext& context, const forces::Site& site, const JointFunction* function,
                  bool resisting = true) noexcept {
  forces::add_elements(site, resisting);
  if (function == nullptr) return;
  double effort[6] = {};
  (*function)(context, {effort, static_cast<std::size_t>(site.nv)});
  for (int i = 0; i < site.nv; ++i)
    if (site.on(i)) forces::add_effort(site, i, effort[i]);
}

// `resisting` false: without the resisting forces of resistance.hpp, except on driven DoFs.
Power add_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, double* force,
                 bool resisting = true) noexcept {
  Power power;
  if (tree.tables().has_forces) {
    const double *damping = tree.tables().damping.data(), *effort = tree.tables().effort.data(), *v = workspace.v.get();
    double dissipated = 0, given = 0;
    for (int i = 0; i < tree.nv(); ++i) {
      const double friction = resisting ? damping[i] * v[i] : 0.0;
      force[i] += effort[i] - friction;
      dissipated += friction * v[i];
      given += effort[i] * v[i];
    }
    if (!resisting)
      for (const int b : tree.joints_with().motions)
        dissipated += damping[tree.first_p(b)] * v[tree.first_p(b)] * v[tree.first_p(b)];
    power = {dissipated, given};
  }
  add_springs(tree, q, force);
  if (tree.joints_with().forces.empty()) return power;
  const EvaluationContext context(tree, t, q, workspace);
  for (const int b : tree.joints_with().forces)
    add_elements(context, forces::site_of(tree, t, q, workspace.v.get(), b, force, power), tree.function(b),
                 resisting || tree.link(b).driven != 0);
  return power;
}

// With prescribed motion the accelerations are computed in the same evaluation, for the power of the drives.
void add_forces_and_motions(const Tree& tree, double t, const double* q, Workspace<double>& workspace) noexcept {
  workspace.power = joint_forces(tree, t, q, workspace, workspace.a.get(), workspace.passive.get());
  for (int i = 0; i < tree.nv(); ++i) workspace.pdot[static_cast<std::size_t>(i)] += workspace.a[static_cast<std::size_t>(i)];
  add_body_forces(tree, t, q, workspace);
  clear_other_loads(tree, workspace);
  put_accelerations(tree, t, workspace.pdot.get());
  evaluate_accelerations<double>(tree, q, workspace);
  for (const int b : tree.joints_with().motions)
    workspace.power.work += motion_effort(tree, q, workspace, b) * workspace.v[static_cast<std::size_t>(tree.first_p(b))];
}

}  // namespace

bool stages_take_rates(const Tree& tree) noexcept {
  return tree.loads().bodies.empty() && !has_functions(tree) && !tree.has_constraints();
}

bool stages_take_loop_rates(const Tree& tree, Variables variables) noexcept {
  return tree.has_loops() && variables == Variables::velocities && tree.loads().bodies.empty() && !has_functions(tree);
}

void evaluate_for_forces(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace) noexcept {
  if (tree.loads().bodies.empty() && !has_functions(tree))
    evaluate_rates<double>(tree, q, p, workspace);
  else
    evaluate_motions<double>(tree, q, p, workspace);
}

void evaluate_stage(const Tree& tree, double t, const double* q, const double* p, Workspace<double>& workspace,
                    RatesFunction generated) noexcept {
  if (generated != nullptr && stages_take_rates(tree)) {
    workspace.evaluated = workspace.located = workspace.accelerated = {};
    generated(q, p, workspace.v.get(), workspace.qdot.get(), workspace.pdot.get());
    add_joint_forces(tree, t, q, workspace);
  } else if (!tree.has_constraints()) {
    evaluate_for_forces(tree, q, p, workspace);
    add_joint_forces(tree, t, q, workspace);
    add_body_forces(tree, t, q, workspace);
  } else if (tree.has_loops()) {
    evaluate_with_loops(tree, t, q, p, workspace, LoopRows::kept);
  } else {
    evaluate_motions<double>(tree, q, p, workspace);
    add_forces_and_motions(tree, t, q, workspace);
  }
}

void add_joint_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, bool resisting) noexcept {
  workspace.power = add_forces(tree, t, q, workspace, workspace.pdot.get(), resisting);
  put_accelerations(tree, t, workspace.pdot.get());
}

void joint_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, double* tau) noexcept {
  std::fill_n(tau, tree.nv(), 0.0);
  add_forces(tree, t, q, workspace, tau);
  put_accelerations(tree, t, tau);
}

Power joint_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, double* tau,
                   double* passive) noexcept {
  std::fill_n(tau, tree.nv(), 0.0);
  const Power power = add_forces(tree, t, q, workspace, tau);
  for (const int b : tree.joints_with().motions) passive[b] = tau[tree.first_p(b)];
  put_accelerations(tree, t, tau);
  return power;
}

void unlocked_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, int b, double* force) noexcept {
  const int nv = info(tree.kind(b)).nv;
  std::fill_n(force, nv, 0.0);
  const JointParameters* p = tree.parameters(b);
  if (p != nullptr && p->stiffness.any()) joint_spring(tree, q, b, force);
  Power power;
  forces::Site site = forces::site_of(tree, t, q, workspace.v.get(), b, workspace.impulse.get(), power);
  site.force = force, site.acts = ~0u;
  for (int i = 0; i < nv; ++i) force[i] += site.parameters.effort.of(i);
  add_elements(EvaluationContext(tree, t, q, workspace), site, tree.function(b));
}

double motion_effort(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept {
  const auto at = static_cast<std::size_t>(tree.first_p(b));
  const double through = dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
    const auto E = decltype(tag)::type::template columns<double>(tree.link(b), joint_state(tree, q, workspace, b));
    if constexpr (E.size() > 0) return dot(E[0], transmitted_wrench(tree, workspace, b));
    return 0.0;
  });
  const double coupled = tree.has_loops() ? coupling_effort(tree, workspace, b) : 0.0;
  return through + tree.tables().armature[at] * workspace.a[at] - workspace.passive[static_cast<std::size_t>(b)] - coupled;
}

std::vector<forces::LinearSpring> forces::linear_springs(const Tree& tree) {
  std::vector<LinearSpring> springs;
  for (const int b : tree.joints_with().springs) {
    const JointParameters& p = *tree.parameters(b);
    for (int i = 0; has_linear_springs(tree.kind(b)) && i < info(tree.kind(b)).nv; ++i)
      if ((tree.joint(b).locked >> i & 1u) == 0 && p.stiffness.of(i) != 0)
        springs.push_back({tree.first_q(b) + i, tree.first_p(b) + i, p.stiffness.of(i), p.rest.empty() ? 0.0 : p.rest[i]});
  }
  return springs;
}

double joint_spring(const Tree& tree, const double* q, int b, double* force) noexcept {
  return joint_spring_at(tree, q + tree.first_q(b), b, force);
}

void forward_dynamics(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(state.topology() == tree.revision(), foreign_state);
  MT_REQUIRE(!workspace.in_function, inside_function);
  if (workspace.evaluated == state.stamp()) return;
  if (state.variables() == Variables::velocities) return evaluate_velocity_state(tree, state, workspace);
  if (!tree.has_constraints()) {
    evaluate_motions<double>(tree, state.q().data(), state.p().data(), workspace);
    add_joint_forces(tree, state.time(), state.q().data(), workspace);
    add_body_forces(tree, state.time(), state.q().data(), workspace);
  } else if (tree.has_loops()) {
    return evaluate_state_with_loops(tree, state, workspace);
  } else {
    evaluate_motions<double>(tree, state.q().data(), state.p().data(), workspace);
    add_forces_and_motions(tree, state.time(), state.q().data(), workspace);
    workspace.accelerated = state.stamp();
  }
  workspace.evaluated = state.stamp();
}

namespace {

// Poses and velocities of all bodies; velocity(b, x, outer): that of b, with the transform of its joint and the parent's
// kinematics, which is null for the ground.
template <class Velocity>
void locate(const Tree& tree, const double* q, Workspace<double>& workspace, const Velocity& velocity) noexcept {
  for (int b : tree.order()) {
    const int parent = tree.parent(b);
    const DenseTransform<double> x = joint_transform_of(tree, q, workspace, b);
    Kinematics<double>& own = workspace.bodies[static_cast<std::size_t>(b)];
    const Kinematics<double>* outer = parent < 0 ? nullptr : &workspace.bodies[static_cast<std::size_t>(parent)];
    own.R = outer == nullptr ? x.R : outer->R * x.R;
    own.r = outer == nullptr ? x.r : outer->r + outer->R * x.r;
    own.velocity = velocity(b, x, outer);
  }
}

}  // namespace

void locate_stage(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept {
  locate(tree, q, workspace, [&](int b, const DenseTransform<double>& x, const Kinematics<double>* outer) {
    Motion<double> velocity = outer == nullptr ? Motion<double>{} : outer->velocity;
    x.outboard(velocity);
    return dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
      return decltype(tag)::type::template spatial_velocity<double>(tree.link(b), joint_state(tree, q, workspace, b), velocity,
                                                                    workspace.v.get() + tree.first_p(b));
    });
  });
}

void locate_bodies(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  forward_dynamics(tree, state, workspace);
  if (workspace.located == state.stamp()) return;
  locate(tree, state.q().data(), workspace,
         [&](int b, const auto&, const auto*) { return workspace.motions[static_cast<std::size_t>(b)].velocity; });
  workspace.located = state.stamp();
}

DenseTransform<double> joint_transform_of(const Tree& tree, const double* q, const Workspace<double>& workspace, int b) noexcept {
  return dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) -> DenseTransform<double> {
    using K = typename decltype(tag)::type;
    if constexpr (K::rotates_about_z) {
      return dense_transform<K, double>(tree.link(b), joint_state(tree, q, workspace, b));
    } else {
      return workspace.record<K>(tree, b).x;
    }
  });
}

}  // namespace momentree
