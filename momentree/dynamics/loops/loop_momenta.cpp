#include <momentree/dynamics/loops/loop_momenta.hpp>

#include <algorithm>

#include <momentree/dynamics/forces/body_forces.hpp>
#include <momentree/dynamics/loops/loop_system.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/velocity.hpp>
#include <momentree/dynamics/wrench_inboard.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Calls f(b, its flags, tag of its joint's kernels) for the bodies at stops, outboard before inboard.
template <class F>
void inward(const Tree& tree, const F& f) {
  const std::span<const LoopStop> stops = tree.loops().stops;
  for (std::size_t s = stops.size(); s-- > 0;) {
    const int b = stops[s].body;
    if (s > 0 && stops[s - 1].body == b) continue;  // once per body
    dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) { f(b, tree.tables().node_flags[at(tree.place(b))], tag); });
  }
}

bool has_motions(const Tree& tree) { return !tree.joints_with().motions.empty() || tree.loops().motions > 0; }

void clear(const Tree& tree, std::vector<Force<double>>& by_body) {
  for (const LoopStop& stop : tree.loops().stops) by_body[at(stop.body)] = {};
}

// loops.wrenches: −σ times the inertial derivative of the rows' unit wrenches. F of a closure's row is fixed in the parent.
void add_turning_wrenches(const Tree& tree, const Workspace<double>& workspace, const double* impulses) {
  LoopWorkspace& loops = *workspace.loops;
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const LoopLink& link = tree.loops().links[i];
    const LoopPlace& place = loops.places[i];
    Vec3 F{}, T{}, turned{};
    for (int k = 0; k < link.rows; ++k) {
      const auto row = at(link.first_row + k);
      F += impulses[row] * loops.rows[row].F;
      if (k < link.closure.rows()) {
        turned += impulses[row] * cross(place.wa, loops.rows[row].F);
        T += impulses[row] * loops.rows[row].rate;
      } else if (impulses[row] != 0) {
        const LoopWrenchRate rate =
            loop_dof_rate(tree, workspace, static_cast<int>(i), link.dof_rows[at(k - link.closure.rows())].dof);
        turned += impulses[row] * rate.F;
        T += impulses[row] * rate.T;
      }
    }
    T += cross(place.vb, F);
    F = turned;
    Force<double>& child = loops.wrenches[at(loop.body)];
    child = child - on_body(workspace.bodies[at(loop.body)], F, T, place.xb);
    if (loop.to >= 0) loops.wrenches[at(loop.to)] += on_body(workspace.bodies[at(loop.to)], F, T, place.xb);
  }
}

// The linear momentum that the loops brought to b itself.
Vec3 own_linear_momentum(const Tree& tree, const Workspace<double>& workspace, const double* impulses, int b) {
  Vec3 sum{};
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const LoopLink& link = tree.loops().links[i];
    const double sign = (loop.body == b ? 1.0 : 0.0) - (loop.to == b ? 1.0 : 0.0);
    for (int k = 0; k < link.rows && sign != 0; ++k)
      sum += sign * impulses[link.first_row + k] * workspace.loops->rows[at(link.first_row + k)].F;
  }
  return transpose_times(workspace.bodies[at(b)].R, sum);
}

// Kernels that know Pb = M Ω of a body that carries no other take Ω × Pb for Ω × Pb*: adds −Ω × (Pb* − Pb).
void complete_gyroscopic_wrenches(const Tree& tree, const double* q, Workspace<double>& workspace) {
  inward(tree, [&](int b, unsigned flags, auto tag) {
    using K = typename decltype(tag)::type;
    if constexpr (requires(Vec3 mc, Motion<double> a, Force<double> P) { K::template gyroscopic<double>(mc, a, P); }) {
      if ((flags & (node::grounded | node::leaf)) != (node::grounded | node::leaf)) return;
      const Vec3 l = own_linear_momentum(tree, workspace, workspace.loops->lambda.data(), b);
      double rate[6] = {};
      K::template momentum_rate<double>(tree.link(b), joint_state(tree, q, workspace, b), workspace.v.get() + tree.first_p(b), {},
                                        {{}, cross(workspace.motions[at(b)].velocity.v, l)}, rate);
      for (int i = 0; i < info(tree.kind(b)).nv; ++i) workspace.pdot[at(tree.first_p(b) + i)] += rate[i];
    }
  });
}

// With Wb in loops.momenta: rates += Eᵀ (F + Ω × Wb) − Ėᵀ Wb, where F is the sum of loops.wrenches outboard.
void add_rates(const Tree& tree, const double* q, Workspace<double>& workspace, double* rates) {
  LoopWorkspace& loops = *workspace.loops;
  inward(tree, [&](int b, unsigned flags, auto tag) {
    using K = typename decltype(tag)::type;
    Force<double> F = loops.wrenches[at(b)];
    if constexpr (!K::rigid) {
      const LinkConstants& link = tree.link(b);
      const JointState<double> joint = joint_state(tree, q, workspace, b);
      const Force<double>& W = loops.momenta[at(b)];
      const int first = tree.first_p(b);
      double rate[6] = {};
      K::template momentum_rate<double>(link, joint, workspace.v.get() + first, -1.0 * W,
                                        F + cross(workspace.motions[at(b)].velocity, W), rate);
      for (int i = 0; i < info(tree.kind(b)).nv; ++i) rates[first + i] += rate[i];
      wrench_inboard<K>(link, joint, workspace.record<K>(tree, b), flags, F);
    }
    if (const int outer = tree.parent(b); outer >= 0) loops.wrenches[at(outer)] += F;
  });
}

// −J̇ᵀ σ of the couplings: their rows change with f′.
void add_coupling_rates(const Tree& tree, const double* q, const Workspace<double>& workspace, const double* impulses,
                        double* rates) noexcept {
  for (std::size_t i = tree.loops().size(); i < tree.loops().links.size(); ++i) {
    const LoopLink& link = tree.loops().links[i];
    const int b = link.ends.follows;
    if (b < 0 || (tree.link(b).locked & 1u) != 0) continue;
    const double curvature = detail::coupling_point(tree, link.ends.coupling, q[tree.first_q(b)]).curvature;
    rates[tree.first_p(b)] += curvature * workspace.v[at(tree.first_p(b))] * impulses[link.first_row];
  }
}

}  // namespace

void detail::sum_loop_momenta(const Tree& tree, const double* q, const Workspace<double>& workspace,
                              const double* impulses) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  clear(tree, loops.momenta);
  for (std::size_t i = 0; i < tree.loops().size(); ++i) {
    const Loop& loop = tree.loops()[i];
    const LoopLink& link = tree.loops().links[i];
    Vec3 F{}, T{};
    for (int k = 0; k < link.rows; ++k) {
      const auto row = at(link.first_row + k);
      F += impulses[row] * loops.rows[row].F;
      T += impulses[row] * loops.rows[row].T;
    }
    loops.momenta[at(loop.body)] += on_body(workspace.bodies[at(loop.body)], F, T, loops.places[i].xb);
    if (loop.to < 0) continue;
    Force<double>& parent = loops.momenta[at(loop.to)];
    parent = parent - on_body(workspace.bodies[at(loop.to)], F, T, loops.places[i].xb);
  }
  inward(tree, [&](int b, unsigned flags, auto tag) {
    using K = typename decltype(tag)::type;
    const int outer = tree.parent(b);
    if (outer < 0) return;
    Force<double> W = loops.momenta[at(b)];
    if constexpr (!K::rigid)
      wrench_inboard<K>(tree.link(b), joint_state(tree, q, workspace, b), workspace.record<K>(tree, b), flags, W);
    loops.momenta[at(outer)] += W;
  });
}

void detail::solve_momenta_of_loops(const Tree& tree, const double* q, Workspace<double>& workspace) noexcept {
  for (const LoopStop& stop : tree.loops().stops) {
    workspace.biases[at(stop.body)] = {};
    workspace.reduced_bias_wrenches[at(stop.body)] = {};  // afterwards −(K − G k) σ
  }
  place_loops(tree, q, workspace, false);
  LoopWorkspace& loops = *workspace.loops;
  if (loops.armatures == ArmatureSpeeds::none)
    for (LoopRow& row : loops.rows) row.jump_to = 0;
  loops.in_momenta = true;
  solve_loops(tree, q, workspace, {}, loops.wanted, true);
  loops.in_momenta = loops.impulsive = false;  // impulses of a step, not of a change
}

// Pb = M̂ Ω_in + D̂ of the outward pass lacks what the impulses add to D̂.
void detail::find_motions_with_loops(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace,
                                     LoopRows rows, ArmatureSpeeds armatures) noexcept {
  LoopWorkspace& loops = loop_memory(tree, workspace);
  const bool unknown = loops.rank < 0 && armatures == ArmatureSpeeds::kept;  // no rows were chosen
  loops.wanted = rows, loops.armatures = unknown ? ArmatureSpeeds::taken : armatures;
  reduce_momenta(tree, q, p, workspace);
  solve_momenta_of_loops(tree, q, workspace);
  resolve_momenta(tree, q, p, workspace);
  const std::span<const LoopStop> stops = tree.loops().stops;
  for (std::size_t s = 0; s < stops.size(); ++s) {
    const int b = stops[s].body;
    if (s > 0 && stops[s - 1].body == b) continue;
    const Force<double>& W = workspace.reduced_bias_wrenches[at(b)];
    workspace.motions[at(b)].articulated += W;
    loops.momenta[at(b)] = -1.0 * W;
  }
}

void find_velocities_with_loops(const Tree& tree, const double* q, const double* p, Workspace<double>& workspace,
                                ArmatureSpeeds armatures) noexcept {
  detail::find_motions_with_loops(tree, q, p, workspace, LoopRows::kept, armatures);
}

void evaluate_with_loops(const Tree& tree, double t, const double* q, const double* p, Workspace<double>& workspace,
                         LoopRows rows, bool resistance) noexcept {
  detail::set_loop_motions(tree, t, workspace);
  detail::loop_memory(tree, workspace).heavier = !resistance;
  detail::find_motions_with_loops(tree, q, p, workspace, rows,
                                  rows == LoopRows::choose ? ArmatureSpeeds::taken : ArmatureSpeeds::kept);
  LoopWorkspace& loops = *workspace.loops;
  loops.heavier = false;
  detail::place_loops(tree, q, workspace, true);
  add_joint_forces(tree, t, q, workspace, resistance);
  add_loop_forces(tree, t, q, workspace);
  detail::add_extra_efforts(tree, loops, workspace.pdot.get());
  for (const LoopStop& stop : tree.loops().stops) loops.wrenches[at(stop.body)] = -1.0 * workspace.biases[at(stop.body)].wrench;
  add_turning_wrenches(tree, workspace, loops.lambda.data());
  add_rates(tree, q, workspace, workspace.pdot.get());
  add_coupling_rates(tree, q, workspace, loops.lambda.data(), workspace.pdot.get());
  complete_gyroscopic_wrenches(tree, q, workspace);
  add_body_forces(tree, t, q, workspace);
  if (resistance && has_motions(tree))  // for the power of the drives
    evaluate_velocities_keeping(tree, t, q, workspace.v.get(), workspace, rows);
}

void evaluate_state_with_loops(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  load_turns(tree, state, workspace);
  evaluate_with_loops(tree, state.time(), state.q().data(), state.p().data(), workspace, LoopRows::choose);
  workspace.evaluated = state.stamp();
  if (has_motions(tree)) workspace.accelerated = state.stamp();
}

void accelerate_with_loops(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept {
  const bool located = workspace.located == state.stamp();
  evaluate_velocities_keeping(tree, state.time(), state.q().data(), workspace.v.get(), workspace, LoopRows::choose);
  workspace.evaluated = workspace.accelerated = state.stamp();
  if (located) locate_bodies(tree, state, workspace);
}

void add_gauge_rates(const Tree& tree, const double* q, Workspace<double>& workspace, const double* impulses,
                     double* rates) noexcept {
  detail::sum_loop_momenta(tree, q, workspace, impulses);
  clear(tree, workspace.loops->wrenches);
  add_turning_wrenches(tree, workspace, impulses);
  add_rates(tree, q, workspace, rates);
  add_coupling_rates(tree, q, workspace, impulses, rates);
}

}  // namespace momentree
