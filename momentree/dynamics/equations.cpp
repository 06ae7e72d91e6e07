#include <momentree/dynamics/contacts/contacts.hpp>
#include <momentree/dynamics/equations.hpp>

#include <algorithm>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

// DoFs of b's joint that are locked, a bit each; not those with a prescribed motion.
unsigned frozen_dofs(UncheckedTree tree, int b) { return tree.link(b).locked & ~unsigned{tree.link(b).driven}; }

// Calls f(i, E), with the index i in packed arrays and the column E, for the unlocked DoFs of b's joint.
template <class F>
void each_column(UncheckedTree tree, const double* q, const Workspace<double>& workspace, int b, F&& f) {
  const unsigned frozen = frozen_dofs(tree, b);
  dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) {
    const auto E = decltype(tag)::type::template columns<double>(tree.link(b), joint_state(tree, q, workspace, b));
    for (std::size_t i = 0; i < E.size(); ++i)
      if ((frozen >> i & 1u) == 0) f(static_cast<std::size_t>(tree.first_p(b)) + i, E[i]);
  });
}

// A weld's kernel frame is that of its parent.
bool moves(UncheckedTree tree, int b) { return tree.kind(b) != Kind::weld; }

// Acceleration of b less gravity, from that of its parent in the parent's frame (39); `a`: accelerations of all joints, or null.
Motion<double> accelerated(UncheckedTree tree, const double* q, const Workspace<double>& workspace, int b, Motion<double> from,
                           const double* a) {
  if (!moves(tree, b)) return from;
  joint_transform_of(tree, q, workspace, b).outboard(from);
  const auto at = static_cast<std::size_t>(tree.first_p(b));
  const unsigned frozen = frozen_dofs(tree, b);
  return dispatch_kernels(tree.kind(b), tree.variant(b), [&](auto tag) -> Motion<double> {
    using K = typename decltype(tag)::type;
    if constexpr (K::rigid) {
      return from;
    } else {
      const JointState<double> joint = joint_state(tree, q, workspace, b);
      const LinkConstants& link = tree.link(b);
      const Motion<double> bias = K::template acceleration_bias<double>(
          link, joint, workspace.motions[static_cast<std::size_t>(b)].velocity, workspace.v.get() + at);
      double own[6] = {};
      for (std::size_t i = 0; a != nullptr && i < static_cast<std::size_t>(info(tree.kind(b)).nv); ++i)
        if ((frozen >> i & 1u) == 0) own[i] = a[at + i];
      return K::template spatial_velocity<double>(link, joint, from + bias, own);
    }
  });
}

// Recursive Newton–Euler: outward the accelerations, inward the wrenches of the joints. `a` null: zeros.
void newton_euler(const Tree& tree, const State& state, Workspace<double>& workspace, const double* a, double* effort) {
  const double* const q = state.q().data();
  Motion<double>* const accelerations = workspace.parent_accelerations.get();
  Force<double>* const wrenches = workspace.child_wrenches.get();
  const UncheckedTree all(tree);
  const Motion<double> base{-tree.gravity(), {}};  // gives every body its weight
  for (const int b : all.order()) {
    const auto i = static_cast<std::size_t>(b);
    const int outer = all.parent(b);
    accelerations[i] = accelerated(all, q, workspace, b, outer < 0 ? base : accelerations[outer], a);
    wrenches[i] =
        momentum(all.link(b).body, accelerations[i]) + gyroscopic_wrench(all.link(b).body, workspace.motions[i].velocity);
  }
  for (const int b : all.loads().bodies) wrenches[b] = wrenches[b] - workspace.loads[static_cast<std::size_t>(b)];
  for_held_forces(tree, workspace, [&](int b, const Force<double>& force) { wrenches[b] = wrenches[b] - force; });
  std::fill_n(workspace.impulse.get(), tree.nv(), 0.0);  // the result, because `a` and `effort` may be the same
  const auto order = all.order();
  for (std::size_t k = order.size(); k-- > 0;) {
    const int b = order[k], outer = all.parent(b);
    Force<double> W = wrenches[b];
    each_column(all, q, workspace, b, [&](std::size_t i, const Motion<double>& E) {
      workspace.impulse[i] = dot(E, W) + (a != nullptr ? all.tables().armature[i] * a[i] : 0.0);
    });
    if (outer < 0) continue;
    if (moves(all, b)) joint_transform_of(tree, q, workspace, b).inboard(W);  // (45)
    wrenches[outer] += W;
  }
  std::copy_n(workspace.impulse.get(), tree.nv(), effort);
}

}  // namespace

// Composite bodies: column i of M is the momentum that unit velocity of DoF i gives to the bodies outboard of it, projected onto
// the DoFs between them and the root.
void mass_matrix(const Tree& tree, const State& state, Workspace<double>& workspace, double* M) noexcept {
  forward_dynamics(tree, state, workspace);
  const double* const q = state.q().data();
  const auto n = static_cast<std::size_t>(tree.nv());
  std::fill_n(M, n * n, 0.0);
  const UncheckedTree all(tree);
  Inboard<double>* const composite = workspace.child_sums.get();
  for (const int b : all.order()) composite[b].M = rigid_mass<double>(all.link(b).body);
  const auto order = all.order();
  for (std::size_t k = order.size(); k-- > 0;) {
    const int b = order[k];
    if (moves(all, b)) {
      Force<double> momenta[6];
      std::size_t columns[6], count = 0;
      each_column(all, q, workspace, b, [&](std::size_t i, const Motion<double>& E) {
        columns[count] = i;
        momenta[count++] = composite[b].M * E;
      });
      for (int inner = b; inner >= 0 && count > 0; inner = all.parent(inner)) {
        each_column(all, q, workspace, inner, [&](std::size_t i, const Motion<double>& E) {
          for (std::size_t c = 0; c < count; ++c) M[i * n + columns[c]] = M[columns[c] * n + i] = dot(E, momenta[c]);
        });
        if (all.parent(inner) < 0 || !moves(all, inner)) continue;
        const DenseTransform<double> x = joint_transform_of(tree, q, workspace, inner);
        for (std::size_t c = 0; c < count; ++c) x.inboard(momenta[c]);
      }
    }
    if (all.parent(b) >= 0) {
      SpatialMass<double> own = composite[b].M;
      if (moves(all, b)) joint_transform_of(tree, q, workspace, b).inboard(own);  // (16)
      composite[all.parent(b)].M += own;
    }
    const unsigned frozen = frozen_dofs(all, b);
    const auto at = static_cast<std::size_t>(all.first_p(b));
    for (std::size_t i = 0; i < static_cast<std::size_t>(info(all.kind(b)).nv); ++i)
      if ((frozen >> i & 1u) != 0)
        M[(at + i) * (n + 1)] = 1;
      else
        M[(at + i) * (n + 1)] += all.tables().armature[at + i];
  }
}

void solve_mass(const Tree& tree, const State& state, Workspace<double>& workspace, const double* r, double* u) noexcept {
  forward_dynamics(tree, state, workspace);
  if (u != r) std::copy_n(r, tree.nv(), u);
  solve_with_factors<double>(tree, state.q().data(), workspace, u);
}

void inverse_mass_matrix(const Tree& tree, const State& state, Workspace<double>& workspace, double* inverse) noexcept {
  forward_dynamics(tree, state, workspace);
  const auto n = static_cast<std::size_t>(tree.nv());
  std::fill_n(inverse, n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    inverse[i * (n + 1)] = 1;
    solve_with_factors<double>(tree, state.q().data(), workspace, inverse + i * n);
    for (std::size_t k = 0; k < i; ++k) inverse[i * n + k] = inverse[k * n + i];  // equal to round-off
  }
}

void bias(const Tree& tree, const State& state, Workspace<double>& workspace, double* c) noexcept {
  forward_dynamics(tree, state, workspace);
  newton_euler(tree, state, workspace, nullptr, c);
}

void inverse_dynamics(const Tree& tree, const State& state, Workspace<double>& workspace, const double* a,
                      double* effort) noexcept {
  forward_dynamics(tree, state, workspace);
  newton_euler(tree, state, workspace, a, effort);
}

void efforts(const Tree& tree, const State& state, Workspace<double>& workspace, double* tau) noexcept {
  forward_dynamics(tree, state, workspace);
  const double* const q = state.q().data();
  joint_forces(tree, state.time(), q, workspace, tau);
  for (const int b : tree.joints_with().motions)  // whose accelerations were part of the evaluation
    tau[tree.first_p(b)] = workspace.passive[static_cast<std::size_t>(b)] + motion_effort(tree, q, workspace, b);
}

void point_jacobian(const Tree& tree, const State& state, Workspace<double>& workspace, BodyId body, Vec3 point,
                    double* J) noexcept {
  locate_bodies(tree, state, workspace);
  const double* const q = state.q().data();
  const auto n = static_cast<std::size_t>(tree.nv());
  std::fill_n(J, 6 * n, 0.0);
  if (body == ground) return;
  const UncheckedTree all(tree);
  const KernelFrame& frame = tree.frame(body.index);
  Vec3 at = transpose_times(frame.R, point - frame.r);  // in the kernel frame of b
  for (int b = body.index; b >= 0; b = all.parent(b)) {
    if (!moves(all, b)) continue;
    const Mat3& axes = workspace.bodies[static_cast<std::size_t>(b)].R;
    each_column(all, q, workspace, b, [&](std::size_t i, const Motion<double>& E) {
      const Vec3 linear = axes * (E.v + cross(E.w, at)), angular = axes * E.w;
      const double column[6] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
      for (std::size_t row = 0; row < 6; ++row) J[row * n + i] = column[row];
    });
    const DenseTransform<double> x = joint_transform_of(tree, q, workspace, b);
    at = x.r + x.R * at;
  }
}

}  // namespace momentree
