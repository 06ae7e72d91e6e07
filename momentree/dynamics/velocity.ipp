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
// The ground accelerates against gravity, which gives every body its weight.
//
// In a stage the accelerations are those of points, v̇ + ω × v at the body's origin. Then velocities may be relative to a frame
// that moves with the parent's origin: linear ones, which would only cancel, are not handed on.
#include <momentree/dynamics/forward.ipp>
#include <momentree/dynamics/step_table.hpp>
#include <momentree/dynamics/velocity_in_plane.ipp>
#include <momentree/joint/velocity_derived_list.hpp>  // generated: the kinds with derived steps in velocities

namespace momentree {

namespace detail {
template <class K, class Type>
constexpr bool is_kernels_of() {
  if constexpr (requires { typename Type::ArmatureKernels; })
    if (std::is_same_v<K, typename Type::ArmatureKernels>) return true;
  return std::is_same_v<K, typename Type::Kernels>;
}
}  // namespace detail
/// True for kernels with derived steps in velocities.
#define MOMENTREE_IS_DERIVED(name, Type) detail::is_kernels_of<K, Type>() ||
template <class K>
inline constexpr bool is_velocity_derived = MOMENTREE_VELOCITY_DERIVED(MOMENTREE_IS_DERIVED) false;
#undef MOMENTREE_IS_DERIVED

/// `Keep`: for a state; also stores what changes and readers of accelerations use. Stages do not.
template <class T, bool Keep>
struct VelocitySweep {
  UncheckedTree tree;
  const T* q;
  Workspace<T>& workspace;
  SweepBuffers<Inboard<T>, Motion<T>, false> buffers{tree, workspace.child_sums.get(), workspace.parent_accelerations.get()};

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), workspace.cos.get() + tree.first_angle(b), workspace.sin.get() + tree.first_angle(b)};
  }

  // The passes over one body that is not welded.

  /// From its parent's motion to its own, with its bias.
  template <class K>
  MOMENTREE_INLINE static void body_velocities(const LinkConstants& link, bool aligned, const JointState<T>& joint, const T* u,
                                               typename K::template Record<T>& record, BodyBias<T>& bias, Motion<T>& a, T* qdot) {
    if constexpr (!Keep) a.v = {T(0), T(0), T(0)};
    if (K::rotates_about_z && aligned)
      K::template joint_transform<true, T>(link, joint, record).outboard(a);
    else
      K::template joint_transform<false, T>(link, joint, record).outboard(a);
    a = K::template spatial_velocity<T>(link, joint, a, u);                       // (17)
    put(K::template acceleration_bias<T>(link, joint, a, u), bias.acceleration);  // (39)
    K::template coordinate_rate<T>(joint.q, u, qdot);
    if constexpr (!Keep) {
      bias.acceleration.v += cross(a.w, a.v);
      a.v = {T(0), T(0), T(0)};
    }
    put(gyroscopic_wrench(link.body, a), bias.wrench);
  }
  /// From the contributions of its children to its own, unless it is a root.
  template <class K>
  MOMENTREE_INLINE static void body_contribution(const LinkConstants& link, bool aligned, bool root, const JointState<T>& joint,
                                                 const typename K::template Record<T>& record, const BodyBias<T>& bias,
                                                 Inboard<T>& a) {
    const auto over = [&](const auto& transform) MOMENTREE_INLINE_LAMBDA {
      if (root) return;
      K::add_reduced_bias(record, bias.acceleration, a.D);
      transform.inboard(a.M);  // (16)
      transform.inboard(a.D);
    };
    if (K::rotates_about_z && aligned)
      over(K::template cached_transform<true, T>(link, joint, record));
    else
      over(K::template cached_transform<false, T>(link, joint, record));
  }
  /// From its parent's acceleration to a′.
  template <class K>
  MOMENTREE_INLINE static void body_acceleration(const LinkConstants& link, bool aligned, const JointState<T>& joint,
                                                 const typename K::template Record<T>& record, const BodyBias<T>& bias,
                                                 Motion<T>& a) {
    if (K::rotates_about_z && aligned)
      K::template cached_transform<true, T>(link, joint, record).outboard(a);
    else
      K::template cached_transform<false, T>(link, joint, record).outboard(a);
    a = a + bias.acceleration;
  }

  /// First outward pass, from the velocities in workspace.v.
  template <class K>
  void velocities(const KernelRun& run) const {
    if constexpr (K::rigid && !Keep) return rigid_velocities(run);
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
        body_velocities<K>(link, (flags & node::aligned) != 0, joint, workspace.v.get() + tree.first_p(b), records[i - run.begin],
                           bias, a, workspace.qdot.get() + tree.first_q(b));
      }
      if constexpr (Keep) workspace.motions[static_cast<std::size_t>(b)].velocity = a;
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }

  /// Inward pass, with the joint forces τ in workspace.a.
  template <class K>
  void inboard(const KernelRun& run) const {
    if constexpr (K::rigid && !Keep) return rigid_inboard(run);
    constexpr unsigned roots = Keep ? node::root : node::grounded;  // they contribute to no parent
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
        if constexpr (Keep) record.M = a.M, record.D = a.D;
      } else {
        K::template reduce<T>(link, joint, workspace.a.get() + tree.first_p(b), tree.armature() + tree.first_p(b), a.M, a.D,
                              record);  // (24)–(26)
      }
      if constexpr (Keep) put(a.D, workspace.reduced_bias_wrenches[static_cast<std::size_t>(b)]);
      if constexpr (!K::rigid) {
        body_contribution<K>(link, (flags & node::aligned) != 0, (flags & roots) != 0, joint, record, bias, a);
      }
      if ((flags & roots) == 0) buffers.add_to_parent(b, flags, a);
    }
    buffers.suspend_inward(run, a);
  }

  /// Second outward pass: u̇ to workspace.a.
  template <class K>
  void outboard(const KernelRun& run, const Motion<T>& base) const {
    if constexpr (K::rigid && !Keep) return rigid_outboard(run, base);
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
        body_acceleration<K>(tree.link(b), (flags & node::aligned) != 0, joint_state(b), records[i - run.begin],
                             workspace.biases[static_cast<std::size_t>(b)], a);
      }
      if constexpr (Keep) put(a, workspace.inboard_accelerations[static_cast<std::size_t>(b)]);
      if constexpr (!K::rigid) {
        T* const udot = workspace.a.get() + tree.first_p(b);
        K::joint_velocity(records[i - run.begin], a, udot);                          // (27)
        a = K::template spatial_velocity<T>(tree.link(b), joint_state(b), a, udot);  // (17)
      }
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }

  // The same for welds, in a stage: the frames of a body and its parent coincide, so that only its mass and the wrench of its
  // motion are added.

  void rigid_velocities(const KernelRun& run) const {
    Motion<T> a;
    buffers.resume_outward(run, a);
    for (int i = run.begin; i < run.end; ++i) {
      const int b = tree.order()[static_cast<std::size_t>(i)];
      const unsigned flags = tree.node_flags()[static_cast<std::size_t>(i)];
      buffers.load_parent(b, flags, {}, a);
      Vector3<T>& angular = workspace.biases[static_cast<std::size_t>(b)].acceleration.w;
      angular.x = a.w.x, angular.y = a.w.y, angular.z = a.w.z;
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }
  void rigid_inboard(const KernelRun& run) const {
    const auto node_flags = tree.node_flags();
    if (run.end == run.begin + 1 && (node_flags[static_cast<std::size_t>(run.begin)] & node::grounded) != 0) return;
    Inboard<T> a;
    buffers.resume_inward(run, a);
    for (int i = run.end - 1; i >= run.begin; --i) {
      const int b = tree.order()[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      if ((flags & node::grounded) != 0) continue;  // it rests, and its children contribute nothing
      const RigidMass& body = tree.link(b).body;
      const Vector3<T> w = workspace.biases[static_cast<std::size_t>(b)].acceleration.w;
      const Force<T> own{cross(w, cross(w, body.mc)), cross(w, body.J * w)};  // (9)
      if ((flags & node::leaf) != 0) {
        a.M = rigid_mass<T>(body), a.D = own;
      } else {
        buffers.gather_children(b, flags, a);
        add_rigid_mass(a.M, body);  // (22)
        a.D += own;                 // (23)
      }
      buffers.add_to_parent(b, flags, a);
    }
    buffers.suspend_inward(run, a);
  }
  void rigid_outboard(const KernelRun& run, const Motion<T>& base) const {
    Motion<T> a;
    buffers.resume_outward(run, a);
    for (int i = run.begin; i < run.end; ++i) {
      const int b = tree.order()[static_cast<std::size_t>(i)];
      const unsigned flags = tree.node_flags()[static_cast<std::size_t>(i)];
      buffers.load_parent(b, flags, base, a);
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }

  // The same for kinds with derived steps, in a stage: derived_velocity.ipp.

  template <class K>
  void velocities_derived(const KernelRun& run) const;
  template <class K>
  void inboard_derived(const KernelRun& run) const;
  template <class K>
  void outboard_derived(const KernelRun& run, const Motion<T>& base) const;

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
          K::Steps::template inboard<shape(), false, true, children(), destination() == Destination::none>(
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

/// True if kernels with derived steps serve a joint: those of most kinds are also used with armature, by the generic functions.
template <class K>
MOMENTREE_INLINE bool is_as_declared(Variant variant) {
  if constexpr (requires { typename K::Steps; })
    return true;
  else
    return variant == Variant::plain;
}

/// Calls f(run, tag of its kernels), or in_plane(run), for all kernel runs.
template <bool Keep, bool Inward, class F, class P>
MOMENTREE_INLINE void each_velocity_run(const Tree& tree, P&& in_plane, F&& f) {
  const auto runs = tree.kernel_runs();
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const KernelRun& run = Inward ? runs[runs.size() - 1 - k] : runs[k];
    if (!Keep && run.planar)
      in_plane(run);
    else
      dispatch_kernels(run.kind, run.variant, [&](auto tag) { f(run, tag); });
  }
}

/// The steps of the tree as machine code, and the arrays of a workspace for them; without steps the passes below run.
template <class T, bool Keep>
struct MachineSteps {
  const StepTable* steps = nullptr;
  StepArrays arrays;

  MOMENTREE_INLINE MachineSteps(const Tree& tree, const T* q, Workspace<T>& workspace) {
    if constexpr (std::is_same_v<T, double> && !Keep) {
      if (workspace.steps == nullptr || !workspace.steps->follow(tree)) return;
      steps = workspace.steps.get();
      arrays = {q,
                workspace.cos.get(),
                workspace.sin.get(),
                workspace.v.get(),
                workspace.qdot.get(),
                workspace.a.get(),
                workspace.records.get(),
                reinterpret_cast<double*>(workspace.child_sums.get()),
                reinterpret_cast<double*>(workspace.parent_accelerations.get()),
                reinterpret_cast<double*>(workspace.biases.get()),
                tree.armature()};
    }
  }
};

template <class T, bool Keep>
void sweep_velocities(const Tree& tree, const T* q, const T* u, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const auto in_plane = [](const KernelRun& run) { return !Keep && run.planar; };
  bool any_plane = false;
  for (const KernelRun& run : tree.kernel_runs()) any_plane = any_plane || in_plane(run);
  find_sines(tree, q, workspace, any_plane, in_plane);
  for (int i = 0; i < tree.nv(); ++i) workspace.v[i] = u[i];
  const VelocitySweep<T, Keep> sweep{tree, q, workspace};
  const InPlaneVelocitySweep<T> planar{tree, workspace};
  const MachineSteps<T, Keep> machine(tree, q, workspace);
  if (machine.steps != nullptr) machine.steps->velocities(machine.arrays);
  each_velocity_run<Keep, false>(
      tree, [&](const KernelRun& run) { planar.velocities(run); },
      [&](const KernelRun& run, auto tag) {
        if (machine.steps != nullptr) return;
        using K = typename decltype(tag)::type;
        if constexpr (!Keep && is_velocity_derived<K>)
          if (is_as_declared<K>(run.variant)) return sweep.template velocities_derived<K>(run);
        if constexpr (!requires { typename K::Steps; })
          sweep.template velocities<K>(run);
        else if constexpr (Keep)
          sweep.template velocities_by_steps<K>(run);
      });
}

/// The sweeps over a tree, set up once for both passes.
template <class T, bool Keep>
struct AccelerationSweeps {
  const Tree& tree;
  const VelocitySweep<T, Keep> general;
  const InPlaneVelocitySweep<T> planar;
  const MachineSteps<T, Keep> machine;
  MOMENTREE_INLINE AccelerationSweeps(const Tree& of, const T* q, Workspace<T>& workspace)
      : tree(of), general{of, q, workspace}, planar{of, workspace}, machine(of, q, workspace) {}

  MOMENTREE_INLINE void reduce() const {
    if (machine.steps != nullptr) machine.steps->inboard(machine.arrays);
    each_velocity_run<Keep, true>(
        tree, [&](const KernelRun& run) { planar.inboard(run); },
        [&](const KernelRun& run, auto tag) {
          using K = typename decltype(tag)::type;
          if (machine.steps != nullptr) return;
          if constexpr (!Keep && is_velocity_derived<K>)
            if (is_as_declared<K>(run.variant)) return general.template inboard_derived<K>(run);
          if constexpr (!requires { typename K::Steps; })
            general.template inboard<K>(run);
          else if constexpr (Keep)
            general.template inboard_by_steps<K>(run);
        });
  }
  MOMENTREE_INLINE void resolve(const Motion<T>& base) const {
    if constexpr (std::is_same_v<T, double>)
      if (machine.steps != nullptr) machine.steps->outboard(machine.arrays, base.v);
    each_velocity_run<Keep, false>(
        tree, [&](const KernelRun& run) { planar.outboard(run); },
        [&](const KernelRun& run, auto tag) {
          using K = typename decltype(tag)::type;
          if (machine.steps != nullptr) return;
          if constexpr (!Keep && is_velocity_derived<K>)
            if (is_as_declared<K>(run.variant)) return general.template outboard_derived<K>(run, base);
          if constexpr (!requires { typename K::Steps; })
            general.template outboard<K>(run, base);
          else if constexpr (Keep)
            general.template outboard_by_steps<K>(run, base);
        });
  }
};

template <class T, bool Keep>
void reduce_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace) noexcept {
  AccelerationSweeps<T, Keep>(tree, q, workspace).reduce();
}

template <class T, bool Keep>
void resolve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept {
  AccelerationSweeps<T, Keep>(tree, q, workspace).resolve(base);
}

template <class T, bool Keep>
void solve_accelerations(const Tree& tree, const T* q, Workspace<T>& workspace, const Motion<T>& base) noexcept {
  const AccelerationSweeps<T, Keep> sweeps(tree, q, workspace);
  sweeps.reduce();
  sweeps.resolve(base);
}

}  // namespace momentree
