#include <momentree/dynamics/velocity.hpp>

#include <algorithm>

#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/forces/body_forces.hpp>
#include <momentree/dynamics/forces/motion.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>

namespace momentree {

namespace {

Motion<double> accelerating_ground(const Tree& tree) { return {-tree.gravity(), {}}; }

// Forces that read poses or motions, and the power of prescribed motions, need what a stage does not store.
bool stage_keeps(const Tree& tree) { return tree.has_constraints() || has_functions(tree) || !tree.loads().bodies.empty(); }

[[gnu::noinline]] void take_held_forces(const Tree& tree, Workspace<double>& workspace) noexcept {
  for_held_forces(tree, workspace, [&](int b, const Force<double>& force) {
    Force<double>& wrench = workspace.biases[static_cast<std::size_t>(b)].wrench;
    wrench = wrench - force;
  });
}

// After sweep_velocities: all forces, as joint forces in workspace.a and wrenches in workspace.biases. `contacts`: also the
// forces of contacts, which are in workspace.contacts: those of the tree's contacts, and those that are held.
template <bool Keep>
void apply_forces(const Tree& tree, double t, const double* q, Workspace<double>& workspace, LoopRows rows = LoopRows::kept,
                  bool contacts = false) noexcept {
  double* const tau = workspace.a.get();
  if constexpr (Keep) {
    if (tree.has_loops()) {  // first, because functions may read the coordinates of loop joints
      detail::set_loop_motions(tree, t, workspace);
      detail::place_loops(tree, q, workspace, true, rows);
    }
  }
  workspace.power = joint_forces(tree, t, q, workspace, tau, workspace.passive.get());
  if constexpr (Keep) {
    find_loads(tree, t, q, workspace);
    if (contacts && !tree.contacts().empty()) add_contact_loads(tree, workspace);
    for (const int b : tree.loads().bodies) {
      Force<double>& wrench = workspace.biases[static_cast<std::size_t>(b)].wrench;
      wrench = wrench - workspace.loads[static_cast<std::size_t>(b)];
    }
    if (contacts) take_held_forces(tree, workspace), add_held_stops(tree, workspace, tau);
    if (tree.has_loops()) {
      add_loop_forces(tree, t, q, workspace);
      detail::add_extra_efforts(tree, *workspace.loops, tau);
    }
  }
}

// Calls f(b, its flags, tag of its joint's kernels) for all bodies, outboard before inboard.
template <class F>
void inward(const Tree& tree, F&& f) {
  const auto order = tree.order();
  for (std::size_t k = order.size(); k-- > 0;) {
    const int b = order[k];
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) { f(b, tree.tables().node_flags[k], tag); });
  }
}

}  // namespace

namespace {

void evaluate_keeping(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace, LoopRows rows,
                      bool contacts) noexcept {
  sweep_velocities<double, true>(tree, q, u, workspace);
  apply_forces<true>(tree, t, q, workspace, rows, contacts);
  if (tree.has_loops()) {
    reduce_accelerations<double, true>(tree, q, workspace);
    solve_loops(tree, q, workspace, accelerating_ground(tree), rows);
    resolve_accelerations<double, true>(tree, q, workspace, accelerating_ground(tree));
  } else {
    solve_accelerations<double, true>(tree, q, workspace, accelerating_ground(tree));
  }
  for (const int b : tree.joints_with().motions)
    workspace.power.work += motion_effort(tree, q, workspace, b) * workspace.v[static_cast<std::size_t>(tree.first_p(b))];
  for (std::size_t i = 0; tree.loops().motions > 0 && i < tree.loops().size(); ++i) {
    const LoopMotion motion = loop_motion(tree, workspace, static_cast<int>(i));
    workspace.power.work += (motion.effort + motion.inertial) * motion.rate;
  }
}

}  // namespace

void evaluate_velocities_without_contacts(const Tree& tree, double t, const double* q, const double* u,
                                          Workspace<double>& workspace, LoopRows rows) noexcept {
  evaluate_keeping(tree, t, q, u, workspace, rows, false);
}

// Accelerations are linear in the forces of contacts: these follow from an evaluation without them.
void evaluate_velocities_keeping(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                                 LoopRows rows) noexcept {
  evaluate_keeping(tree, t, q, u, workspace, rows, false);
  const ContactWorkspace* const own = workspace.contacts.get();
  const bool held = rows == LoopRows::choose && own != nullptr && !(own->held.empty() && own->stops.empty());
  if (tree.contacts().empty() && !held) return;
  locate_stage(tree, q, workspace);
  if (!tree.contacts().empty()) find_contact_forces(tree, q, workspace, rows == LoopRows::choose);
  evaluate_keeping(tree, t, q, u, workspace, rows, true);  // at states with all rows, for the least reactions
}

void evaluate_velocity_stage(const Tree& tree, double t, const double* q, const double* u, Workspace<double>& workspace,
                             VelocityRatesFunction generated) noexcept {
  if (stage_keeps(tree)) return evaluate_velocities_keeping(tree, t, q, u, workspace, LoopRows::kept);
  if (generated != nullptr) {
    workspace.evaluated = workspace.located = workspace.accelerated = {};
    std::copy_n(u, tree.nv(), workspace.v.get());
    apply_forces<false>(tree, t, q, workspace);
    std::copy_n(workspace.a.get(), tree.nv(), workspace.pdot.get());
    generated(q, u, workspace.pdot.get(), workspace.qdot.get(), workspace.a.get());
    return;
  }
  sweep_velocities<double, false>(tree, q, u, workspace);
  apply_forces<false>(tree, t, q, workspace);
  solve_accelerations<double, false>(tree, q, workspace, accelerating_ground(tree));
}

void sum_momenta(const Tree& tree, const double* q, Workspace<double>& workspace, double* p) noexcept {
  const UncheckedTree all(tree);
  for (const int b : all.order()) {
    BodySweep<double>& body = workspace.motions[static_cast<std::size_t>(b)];
    body.articulated = momentum(all.link(b).body, body.velocity);  // (4)
  }
  inward(tree, [&](int b, unsigned flags, auto tag) {
    using K = typename decltype(tag)::type;
    Force<double> P = workspace.motions[static_cast<std::size_t>(b)].articulated;
    const LinkConstants& link = all.link(b);
    const JointState<double> joint = joint_state(all, q, workspace, b);
    const auto E = K::template columns<double>(link, joint);
    const int at = all.first_p(b);
    for (std::size_t i = 0; i < E.size(); ++i) {  // (19)
      const auto f = static_cast<std::size_t>(at) + i;
      p[f] = (link.locked >> i & 1u) == 0 ? dot(E[i], P) + all.tables().armature[f] * workspace.v[f] : workspace.v[f];
    }
    const int outer = all.parent(b);
    if (outer < 0) return;
    if constexpr (!K::rigid) wrench_inboard<K>(link, joint, workspace.record<K>(all, b), flags, P);  // (16)
    workspace.motions[static_cast<std::size_t>(outer)].articulated += P;                             // (14)
  });
}

void evaluate_velocity_state(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  const double* const q = state.q().data();
  if (tree.has_loops()) load_turns(tree, state, workspace);
  evaluate_velocities_keeping(tree, state.time(), q, state.u().data(), workspace, LoopRows::choose);
  sum_momenta(tree, q, workspace, workspace.p.get());
  workspace.evaluated = workspace.accelerated = state.stamp();
}

// ṗ = τ + Eᵀ (Tb − Ω × Pb) + Ėᵀ Pb (20), where Tb is the weight of the bodies outboard and the forces on them.
void find_momentum_rates(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  if (tree.has_loops()) accelerate(tree, state, workspace);
  locate_bodies(tree, state, workspace);
  if (workspace.rated == state.stamp()) return;
  const UncheckedTree all(tree);
  const double* const q = state.q().data();
  double* const pdot = (state.variables() == Variables::momenta ? workspace.p : workspace.pdot).get();
  Force<double>* const Tb = workspace.child_wrenches.get();
  joint_forces(tree, state.time(), q, workspace, pdot);
  add_held_stops(tree, workspace, pdot);
  for (const int b : all.order()) {
    const Vec3 g = transpose_times(workspace.bodies[static_cast<std::size_t>(b)].R, tree.gravity());
    Tb[b] = {all.link(b).body.m * g, cross(all.link(b).body.mc, g)};
  }
  for (const int b : tree.loads().bodies) Tb[b] += workspace.loads[static_cast<std::size_t>(b)];
  for_held_forces(tree, workspace, [&](int b, const Force<double>& force) { Tb[b] += force; });
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const Force<double> W = as_force(loop_reaction(tree, state.time(), workspace, static_cast<int>(i)).total);
    Tb[loop.body] += W;
    if (loop.to < 0) continue;
    const Kinematics<double>& child = workspace.bodies[static_cast<std::size_t>(loop.body)];
    Tb[loop.to] =
        Tb[loop.to] - on_body(workspace.bodies[static_cast<std::size_t>(loop.to)], child.R * W.l, child.R * W.h, child.r);
  }
  if (tree.has_loops()) add_coupling_efforts(tree, workspace, workspace.loops->lambda.data(), pdot);
  inward(tree, [&](int b, unsigned flags, auto tag) {
    using K = typename decltype(tag)::type;
    const LinkConstants& link = all.link(b);
    const JointState<double> joint = joint_state(all, q, workspace, b);
    const BodySweep<double>& body = workspace.motions[static_cast<std::size_t>(b)];
    const int at = all.first_p(b), outer = all.parent(b);
    if constexpr (!K::rigid) {
      double rate[6] = {};
      K::template momentum_rate<double>(link, joint, workspace.v.get() + at, body.articulated,
                                        Tb[b] - cross(body.velocity, body.articulated), rate);
      for (int i = 0; i < info(tree.kind(b)).nv; ++i)
        if ((link.locked >> i & 1u) == 0) pdot[at + i] += rate[i];
      if (outer >= 0) wrench_inboard<K>(link, joint, workspace.record<K>(all, b), flags, Tb[b]);
    }
    if (outer >= 0) Tb[outer] += Tb[b];
  });
  workspace.rated = state.stamp();
}

// The passes of accelerations with other quantities in the same places: −M Ω for the bias wrenches, momenta of armatures for the
// joint forces, no bias, a ground at rest.
void project_velocities(const Tree& tree, const double* q, double* u, Workspace<double>& workspace,
                        std::optional<double> time) noexcept {
  sweep_velocities<double, true>(tree, q, u, workspace);  // for the joint transforms
  for (const int b : tree.order()) {
    const auto i = static_cast<std::size_t>(b);
    workspace.biases[i] = {-1.0 * workspace.carried[i], {}};
    const LinkConstants& link = tree.link(b);
    for (int k = 0; k < info(tree.kind(b)).nv; ++k) {
      const auto f = static_cast<std::size_t>(tree.first_p(b) + k);
      if ((link.locked >> k & 1u) == 0)
        workspace.a[f] = tree.tables().armature[f] * u[f];
      else
        workspace.a[f] = (link.driven >> k & 1u) != 0 ? u[f] : 0.0;
    }
  }
  reduce_accelerations<double, true>(tree, q, workspace);
  if (tree.has_loops()) {
    LoopWorkspace& loops = detail::loop_memory(tree, workspace);
    if (time) detail::set_loop_motions(tree, *time, workspace);
    detail::place_loops(tree, q, workspace, true);
    if (time)
      detail::keep_armatures(tree, workspace);
    else
      for (LoopRow& row : loops.rows) row.jump_to = 0;
    solve_loops(tree, q, workspace, {}, LoopRows::choose, true);
  }
  resolve_accelerations<double, true>(tree, q, workspace, {});
  std::copy_n(workspace.a.get(), tree.nv(), u);
}

}  // namespace momentree
