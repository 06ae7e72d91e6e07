#pragma once
// Velocities as the state: (q, u) → u̇ by three passes, outward, inward, outward. Included only by instantiate/*.cpp.
//
// The inward pass and the second outward pass are those of the momenta, (22)–(27) and (17), with other quantities in the same
// places: joint forces τ for the momenta p, bias wrenches W for the remainders Db, accelerations for velocities. Between them a
// body adds its own bias, which the first pass found from the velocities:
//
//   outward   Ω = X Ω_parent + E u,  bias a = Ω × E u + Ė u,  gyroscopic wrench Z less the external one          (17), (39)
//   inward    Wb = Z + Σ Xᵀ (Ŵ + M̂ a),  Ŵ = Wb + G (τ − Eᵀ Wb)                                                  (23), (26)
//   outward   a′ = X Ω̇_parent + a,  u̇ = Mj⁻¹ (τ − Eᵀ Wb) − Gᵀ a′,  Ω̇ = a′ + E u̇                                 (27), (17)
//
// The ground accelerates against gravity, which gives every body its weight. Stages call the steps of a StepTable; where others
// read what the passes find of each body, they go over kernel runs, as here.
#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/generic_steps.ipp>
#include <momentree/dynamics/step_stage.ipp>
#include <momentree/dynamics/velocity_in_plane.ipp>

namespace momentree {

template <class T>
struct VelocitySweep {
  UncheckedTree tree;
  const T* q;
  Workspace<T>& workspace;
  SweepBuffers<Inboard<T>, Motion<T>, false> buffers{tree, workspace.child_sums.get(), workspace.parent_accelerations.get()};

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), workspace.cos.get() + tree.first_angle(b), workspace.sin.get() + tree.first_angle(b)};
  }
  /// Calls f with the transform of a joint whose first pass is over.
  template <class K, class F>
  MOMENTREE_INLINE static void with_transform(const LinkConstants& link, unsigned flags, const JointState<T>& joint,
                                              const typename K::template Record<T>& record, F&& f) {
    if (K::rotates_about_z && (flags & node::aligned) != 0)
      f(K::template cached_transform<true, T>(link, joint, record));
    else
      f(K::template cached_transform<false, T>(link, joint, record));
  }

  /// First outward pass, from the velocities in workspace.v.
  template <class K>
  void velocities(const KernelRun& run) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    auto* const records = workspace.template records_of<K>(tree, run);
    Motion<T> a;
    buffers.resume_outward(run, a);
    for (int i = run.begin; i < run.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      const LinkConstants& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      BodyBias<T>& bias = workspace.biases[static_cast<std::size_t>(b)];
      buffers.load_parent(b, flags, {}, a);
      if constexpr (K::rigid) {
        bias.acceleration = {};
        put(gyroscopic_wrench(link.body, a), bias.wrench);
      } else {
        const T* const u = workspace.v.get() + tree.first_p(b);
        if (K::rotates_about_z && (flags & node::aligned) != 0)
          K::template joint_transform<true, T>(link, joint, records[i - run.begin]).outboard(a);
        else
          K::template joint_transform<false, T>(link, joint, records[i - run.begin]).outboard(a);
        a = K::template spatial_velocity<T>(link, joint, a, u);                       // (17)
        put(K::template acceleration_bias<T>(link, joint, a, u), bias.acceleration);  // (39)
        K::template coordinate_rate<T>(joint.q, u, workspace.qdot.get() + tree.first_q(b));
        put(gyroscopic_wrench(link.body, a), bias.wrench);
      }
      workspace.motions[static_cast<std::size_t>(b)].velocity = a;
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }

  /// Inward pass, with the joint forces τ in workspace.a.
  template <class K>
  void inboard(const KernelRun& run) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    auto* const records = workspace.template records_of<K>(tree, run);
    Inboard<T> a;
    buffers.resume_inward(run, a);
    for (int i = run.end - 1; i >= run.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      const LinkConstants& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const BodyBias<T>& bias = workspace.biases[static_cast<std::size_t>(b)];
      auto& record = records[i - run.begin];
      if ((flags & node::leaf) != 0) a = {};
      buffers.gather_children(b, flags, a);
      add_rigid_mass(a.M, link.body);  // (22)
      a.D += bias.wrench;              // (23)
      if constexpr (K::rigid) {
        record.M = a.M, record.D = a.D;
      } else {
        K::template reduce<T>(link, joint, workspace.a.get() + tree.first_p(b), tree.armature() + tree.first_p(b), a.M, a.D,
                              record);  // (24)–(26)
      }
      put(a.D, workspace.reduced_bias_wrenches[static_cast<std::size_t>(b)]);
      if ((flags & node::root) != 0) continue;  // it contributes to no parent
      if constexpr (!K::rigid) {
        K::add_reduced_bias(record, bias.acceleration, a.D);
        with_transform<K>(link, flags, joint, record, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA {
          transform.inboard(a.M);  // (16)
          transform.inboard(a.D);
        });
      }
      buffers.add_to_parent(b, flags, a);
    }
    buffers.suspend_inward(run, a);
  }

  /// Second outward pass: u̇ to workspace.a.
  template <class K>
  void outboard(const KernelRun& run, const Motion<T>& base) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    const auto* const records = workspace.template records_of<K>(tree, run);
    Motion<T> a;
    buffers.resume_outward(run, a);
    for (int i = run.begin; i < run.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      buffers.load_parent(b, flags, base, a);
      if constexpr (!K::rigid) {
        with_transform<K>(tree.link(b), flags, joint_state(b), records[i - run.begin],
                          [&](const auto& transform) MOMENTREE_INLINE_LAMBDA { transform.outboard(a); });
        a = a + workspace.biases[static_cast<std::size_t>(b)].acceleration;
      }
      put(a, workspace.inboard_accelerations[static_cast<std::size_t>(b)]);
      if constexpr (!K::rigid) {
        T* const udot = workspace.a.get() + tree.first_p(b);
        K::joint_velocity(records[i - run.begin], a, udot);                          // (27)
        a = K::template spatial_velocity<T>(tree.link(b), joint_state(b), a, udot);  // (17)
      }
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }

  // The same for kinds with whole steps by the shape of a link that keep what others read.

  template <class K>
  void velocities_by_steps(const KernelRun& run) const {
    const int* order = tree.order().data();
    const unsigned char* node_flags = tree.node_flags().data();
    Motion<T> a;
    buffers.resume_outward(run, a);
    for (std::ptrdiff_t i = run.begin; i < run.end; ++i) {
      const int b = order[i];
      const unsigned flags = node_flags[i];
      const LinkConstants& link = tree.link(b);
      const int angle = tree.first_angle(b);
      const T u = workspace.v[tree.first_p(b)];
      workspace.qdot[tree.first_q(b)] = u;
      buffers.load_parent(b, flags, {}, a);
      BodyBias<T>& bias = workspace.biases[b];
      dispatch_link<K::Steps::has_armature>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
        K::Steps::template velocity_outboard<shape()>(link, workspace.cos[angle], workspace.sin[angle], u, a, bias.acceleration);
      });
      put(gyroscopic_wrench(link.body, a), bias.wrench);
      workspace.motions[b].velocity = a;
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }

  template <class K>
  void inboard_by_steps(const KernelRun& run) const {
    const int* order = tree.order().data();
    const unsigned char* node_flags = tree.node_flags().data();
    [[maybe_unused]] const double* armature = tree.armature();
    auto* record = workspace.template records_of<K>(tree, run) + (run.end - run.begin);
    Inboard<T> a;
    buffers.resume_inward(run, a);
    for (std::ptrdiff_t i = run.end - 1; i >= run.begin; --i) {
      const int b = order[i];
      const unsigned flags = node_flags[i];
      const LinkConstants& link = tree.link(b);
      const int angle = tree.first_angle(b), at = tree.first_p(b);
      --record;
      const auto step = [&](auto shape, auto children, auto destination) MOMENTREE_INLINE_LAMBDA {
        const auto to = [&](Inboard<T>& out) MOMENTREE_INLINE_LAMBDA {
          K::Steps::template inboard<shape(), false, children(), destination() == Destination::none>(
              link, tree.subtree_mass(b), K::Steps::has_armature ? armature[at] : 0.0, workspace.cos[angle], workspace.sin[angle],
              workspace.a[at], a, buffers.child_sums[b], *record, out, workspace.biases[b]);
        };
        if constexpr (destination() == Destination::parent_sum) {
          to(buffers.child_sums[tree.parent(b)]);
        } else {
          to(a);
        }
      };
      dispatch_inboard<K::Steps::has_armature>(link.shape, flags, step);
      T hz = workspace.a[at];
      if constexpr (K::Steps::has_armature) hz = record->hz;
      put({record->l, {record->hx, record->hy, hz}}, workspace.reduced_bias_wrenches[b]);
      buffers.add_sibling(b, flags, a);
    }
    buffers.suspend_inward(run, a);
  }

  template <class K>
  void outboard_by_steps(const KernelRun& run, const Motion<T>& base) const {
    const int* order = tree.order().data();
    const unsigned char* node_flags = tree.node_flags().data();
    const auto* record = workspace.template records_of<K>(tree, run);
    Motion<T> a;
    buffers.resume_outward(run, a);
    for (std::ptrdiff_t i = run.begin; i < run.end; ++i, ++record) {
      const int b = order[i];
      const unsigned flags = node_flags[i];
      const LinkConstants& link = tree.link(b);
      const int angle = tree.first_angle(b);
      buffers.load_parent(b, flags, base, a);
      dispatch_link<K::Steps::has_armature>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
        K::Steps::template acceleration_outboard<shape()>(link, workspace.cos[angle], workspace.sin[angle], *record,
                                                          workspace.biases[b].acceleration, a, workspace.a[tree.first_p(b)],
                                                          workspace.inboard_accelerations[b]);
      });
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }
};

/// Calls in_plane(run) for the kernel runs of plane mechanisms in a stage, and f(run, tag of its kernels) for the others.
template <bool Keep, bool Inward, class F, class P>
MOMENTREE_INLINE void each_velocity_run(const Tree& tree, P&& in_plane, F&& f) {
  const auto runs = tree.kernel_runs();
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const KernelRun& run = Inward ? runs[runs.size() - 1 - k] : runs[k];
    if (!Keep && run.planar)
      in_plane(run);
    else if constexpr (Keep)
      dispatch_kernels(run.kind, run.variant, [&](auto tag) { f(run, tag); });
  }
}

template <class T>
MOMENTREE_INLINE StepArrays velocity_arrays(const Tree& tree, const T* q, Workspace<T>& workspace) {
  StepArrays arrays = step_arrays(tree, q, workspace);
  arrays.a = workspace.a.get();
  arrays.motions = workspace.parent_accelerations.get(), arrays.biases = workspace.biases.get();
  return arrays;
}

template <class T, bool Keep>
void sweep_velocities(const Tree& tree, const T* q, const T* u, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  const bool by_steps = !Keep && takes_steps(tree, workspace.velocity_steps.get(), workspace);
  if constexpr (!Keep && std::is_same_v<T, double>)
    if (!by_steps) return sweep_velocities<T, true>(tree, q, u, workspace);
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const auto in_plane = [](const KernelRun& run) { return !Keep && run.planar; };
  bool any_plane = false;
  for (const KernelRun& run : tree.kernel_runs()) any_plane = any_plane || in_plane(run);
  find_sines(tree, q, workspace, any_plane, in_plane);
  for (int i = 0; i < tree.nv(); ++i) workspace.v[i] = u[i];
  if (by_steps) {
    workspace.steps->velocities(velocity_arrays(tree, q, workspace));
  }
  const InPlaneVelocitySweep<T> planar{tree, workspace};
  each_velocity_run<Keep, false>(
      tree, [&](const KernelRun& run) { planar.velocities(run); },
      [&](const KernelRun& run, auto tag) {
        using K = typename decltype(tag)::type;
        const VelocitySweep<T> sweep{tree, q, workspace};
        if constexpr (requires { typename K::Steps; })
          sweep.template velocities_by_steps<K>(run);
        else
          sweep.template velocities<K>(run);
      });
}

template <class T, bool Keep>
void reduce_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept {
  const bool by_steps = !Keep && takes_steps(tree, workspace.velocity_steps.get(), workspace);
  if constexpr (!Keep && std::is_same_v<T, double>)
    if (!by_steps) return reduce_accelerations<T, true>(tree, q, workspace);
  if (by_steps) {
    workspace.steps->inboard(velocity_arrays(tree, q, workspace));
  }
  const InPlaneVelocitySweep<T> planar{tree, workspace};
  each_velocity_run<Keep, true>(
      tree, [&](const KernelRun& run) { planar.inboard(run); },
      [&](const KernelRun& run, auto tag) {
        using K = typename decltype(tag)::type;
        const VelocitySweep<T> sweep{tree, q, workspace};
        if constexpr (requires { typename K::Steps; })
          sweep.template inboard_by_steps<K>(run);
        else
          sweep.template inboard<K>(run);
      });
}

template <class T, bool Keep>
void resolve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept {
  const bool by_steps = !Keep && takes_steps(tree, workspace.velocity_steps.get(), workspace);
  if constexpr (!Keep && std::is_same_v<T, double>)
    if (!by_steps) return resolve_accelerations<T, true>(tree, q, workspace, base);
  if (by_steps) {
    workspace.steps->outboard(velocity_arrays(tree, q, workspace), &base.v);
  }
  const InPlaneVelocitySweep<T> planar{tree, workspace};
  each_velocity_run<Keep, false>(
      tree, [&](const KernelRun& run) { planar.outboard(run); },
      [&](const KernelRun& run, auto tag) {
        using K = typename decltype(tag)::type;
        const VelocitySweep<T> sweep{tree, q, workspace};
        if constexpr (requires { typename K::Steps; })
          sweep.template outboard_by_steps<K>(run, base);
        else
          sweep.template outboard<K>(run, base);
      });
}

template <class T, bool Keep>
void solve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept {
  reduce_accelerations<T, Keep>(tree, q, workspace);
  resolve_accelerations<T, Keep>(tree, q, workspace, base);
}

}  // namespace momentree
