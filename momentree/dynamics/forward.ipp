#pragma once
// Definitions of the two recursions in momenta; included only by instantiate/*.cpp, each for one scalar.
//
// Stages call the steps of a StepTable. Where others read what the passes find of each body, they go over kernel runs, as here:
// along the tree's order with their sums in local variables. The first child of a body follows it directly, so sums pass through
// memory only for later children. Kernel runs, consecutive bodies with the same kernels, are one loop.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/generic_steps.ipp>
#include <momentree/dynamics/in_plane.ipp>
#include <momentree/dynamics/revolute_dispatch.hpp>
#include <momentree/dynamics/step_stage.ipp>
#include <momentree/dynamics/sweep_buffers.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/pack.hpp>

namespace momentree {

template <class T>
struct Sweep {
  UncheckedTree tree;
  const T* q;
  const T* p;
  Workspace<T>& workspace;
  bool has_gravity;  // if false, first moments are not summed
  SweepBuffers<Inboard<T>, Outboard<T>> buffers{tree, workspace.child_sums.get(), workspace.parent_states.get()};

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), workspace.cos.get() + tree.first_angle(b), workspace.sin.get() + tree.first_angle(b)};
  }

  /// Backward recursion over a kernel run.
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
      auto& record = records[i - run.begin];
      if ((flags & node::leaf) != 0) a = {};  // Mb = M, Db = 0
      buffers.gather_children(b, flags, a);
      SpatialMass<T>& M = articulated_mass(link.body, a.M);  // (22)
      Force<T>& D = remainder_momentum(a.D);                 // (23)
      a.mc.x += link.body.mc.x, a.mc.y += link.body.mc.y, a.mc.z += link.body.mc.z;
      if constexpr (K::rigid) {
        record.M = M, record.D = D;
      } else {
        record.mc = has_gravity ? a.mc : Vector3<T>{T(0), T(0), T(0)};
        K::template reduce<T>(link, joint, p + tree.first_p(b), tree.armature() + tree.first_p(b), M, D, record);  // (24)–(26)
        const auto over = [&](const auto& transform) MOMENTREE_INLINE_LAMBDA {
          if ((flags & node::root) != 0) return;  // the ground needs no output
          transform.inboard(M);                   // (16)
          transform.inboard(D);
          transform.inboard(a.mc, tree.subtree_mass(b));
        };
        if (K::rotates_about_z && (flags & node::aligned) != 0)
          over(K::template joint_transform<true, T>(link, joint, record));
        else
          over(K::template joint_transform<false, T>(link, joint, record));
      }
      if ((flags & node::root) == 0) buffers.add_to_parent(b, flags, a);
    }
    buffers.suspend_inward(run, a);
  }

  /// Forward recursion over a kernel run. Also stores Ω and Pb, which changes and accelerations read.
  template <class K>
  void outboard(const KernelRun& run, const Outboard<T>& base) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    const auto* const records = workspace.template records_of<K>(tree, run);
    Outboard<T> a;
    buffers.resume_outward(run, a);
    for (int i = run.begin; i < run.end; ++i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      const LinkConstants& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      const auto& record = records[i - run.begin];
      const int at = tree.first_p(b);
      T* u = workspace.v.get() + at;
      buffers.load_parent(b, flags, base, a);
      if constexpr (K::rigid) {
        workspace.motions[static_cast<std::size_t>(b)] = {a.velocity, record.M * a.velocity + record.D};  // (21)
      } else {
        const auto over = [&](const auto& transform) MOMENTREE_INLINE_LAMBDA {
          transform.outboard(a.velocity);
          transform.outboard(a.gravity);
        };
        if (K::rotates_about_z && (flags & node::aligned) != 0)
          over(K::template cached_transform<true, T>(link, joint, record));
        else
          over(K::template cached_transform<false, T>(link, joint, record));
        K::joint_velocity(record, a.velocity, u);                                  // (27)
        const Force<T> Pb = K::articulated_momentum(record, p + at, a.velocity);   // (21)
        a.velocity = K::template spatial_velocity<T>(link, joint, a.velocity, u);  // (17)
        workspace.motions[static_cast<std::size_t>(b)] = {a.velocity, Pb};
        const Force<T> weight = accumulated_force(tree.subtree_mass(b), record.mc, a.gravity);  // (15)
        const auto gyroscopic = [&]() MOMENTREE_INLINE_LAMBDA {
          if constexpr (requires { K::template gyroscopic<T>(link.body.mc, a.velocity, Pb); })
            if ((flags & (node::grounded | node::leaf)) == (node::grounded | node::leaf))
              return K::template gyroscopic<T>(link.body.mc, a.velocity, Pb);
          return cross(a.velocity, Pb);
        };
        const Force<T> wrench = weight - gyroscopic();                                        // (9), (20)
        K::template momentum_rate<T>(link, joint, u, Pb, wrench, workspace.pdot.get() + at);  // (20)
        K::template coordinate_rate<T>(joint.q, u, workspace.qdot.get() + tree.first_q(b));
      }
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }

  // The same for kinds with whole steps by the shape of a link.

  template <class K, bool Gravity>
  void inboard_steps(const KernelRun& run) const {
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
          K::Steps::template inboard<shape(), Gravity, children(), destination() == Destination::none>(
              link, tree.subtree_mass(b), K::Steps::has_armature ? armature[at] : 0.0, workspace.cos[angle], workspace.sin[angle],
              p[at], a, buffers.child_sums[b], *record, out);
        };
        if constexpr (destination() == Destination::parent_sum) {
          Inboard<T>& parent_sum = buffers.child_sums[tree.parent(b)];
          to(parent_sum);
          begin_moments<Gravity>(parent_sum);
        } else {
          to(a);
        }
      };
      dispatch_inboard<K::Steps::has_armature, node::root>(link.shape, flags, step);
      if ((flags & node::root) == 0) buffers.add_sibling(b, flags, a);
    }
    buffers.suspend_inward(run, a);
  }

  template <class K, bool Gravity>
  void outboard_steps(const KernelRun& run, const Outboard<T>& base) const {
    const int* order = tree.order().data();
    const unsigned char* node_flags = tree.node_flags().data();
    const auto* record = workspace.template records_of<K>(tree, run);
    Outboard<T> a;
    buffers.resume_outward(run, a);
    for (std::ptrdiff_t i = run.begin; i < run.end; ++i, ++record) {
      const int b = order[i];
      const unsigned flags = node_flags[i];
      const LinkConstants& link = tree.link(b);
      const int angle = tree.first_angle(b), at = tree.first_p(b);
      BodySweep<T>& kept = workspace.motions[static_cast<std::size_t>(b)];
      if ((flags & node::root) != 0) {
        a = base;
        K::Steps::template outboard_root<Gravity>(link, workspace.cos[angle], workspace.sin[angle], *record, p[at], a,
                                                  workspace.v[at], workspace.pdot[at], kept);
      } else {
        buffers.load_parent(b, flags, base, a);
        dispatch_link<K::Steps::has_armature>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
          K::Steps::template outboard<shape(), Gravity>(link, workspace.cos[angle], workspace.sin[angle], *record, p[at], a,
                                                        workspace.v[at], workspace.pdot[at], kept);
        });
      }
      workspace.qdot[tree.first_q(b)] = workspace.v[at];
      buffers.store_for_children(b, flags, a);
    }
    buffers.suspend_outward(run, a);
  }
};

/// Sines and cosines of angle(0), angle(1) …, in small blocks.
template <class T, class Angle>
MOMENTREE_INLINE void sincos_in_blocks(int n, const Angle& angle, T* s, T* c) {
  if constexpr (std::is_same_v<T, double>) {
    sincos_by_fours(n, angle, s, c);
  } else {
    constexpr int block = 64;
    T some[block];
    for (int first = 0; first < n; first += block) {
      const int count = n - first < block ? n - first : block;
      for (int i = 0; i < count; ++i) some[i] = angle(first + i);
      sincos(count, some, s + first, c + first);
    }
  }
}

/// Sines and cosines of the joint angles including θ0; for mechanisms that are evaluated in a plane, of the bodies' absolute
/// angles instead.
template <class T, class InPlane>
MOMENTREE_INLINE void find_sines(const Tree& tree, const T* q, Workspace<T>& workspace, bool any_plane, const InPlane& in_plane) {
  const int* const coordinates = tree.angle_coordinates().data();
  const double* const offsets = tree.angle_offsets().data();
  const int n = static_cast<int>(tree.angle_coordinates().size());
  T *const s = workspace.sin.get(), *const c = workspace.cos.get();
  const auto angle = [&](int i) MOMENTREE_INLINE_LAMBDA { return q[coordinates[i]] + offsets[i]; };
  if (!any_plane) return sincos_in_blocks(n, angle, s, c);
  for (int i = 0; i < n; ++i) s[i] = angle(i);
  for (const KernelRun& run : tree.kernel_runs())
    if (in_plane(run)) add_up_angles(tree, run, s);
  sincos_in_blocks(
      n, [s](int i) MOMENTREE_INLINE_LAMBDA { return s[i]; }, s, c);
}

/// Between the passes of a tree nothing happens.
struct NothingBetween {
  template <class T>
  MOMENTREE_INLINE static void act(const Tree&, const T*, Workspace<T>&) {}
};

/// Between::act, called after the inward pass, may change u0 of the records. (As a type, not an argument: this leaves the code
/// without it as it is.)
template <class T, class Between = NothingBetween>
void sweep_motions(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const auto kernel_runs = tree.kernel_runs();
  const Vec3& g = tree.gravity();
  const bool has_gravity = g.x != 0 || g.y != 0 || g.z != 0;
  find_sines(tree, q, workspace, false, [](const KernelRun&) { return false; });

  const Sweep<T> sweep{tree, q, p, workspace, has_gravity};
  T o(0);  // not constexpr, and written out: clearing structs has a cost that shows for small mechanisms
  const Outboard<T> base{{{o, o, o}, {o, o, o}}, {T(g.x), T(g.y), T(g.z)}};
  for (std::size_t i = kernel_runs.size(); i-- > 0;) {
    const KernelRun& s = kernel_runs[i];
    dispatch_kernels(s.kind, s.variant, [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (!requires { typename K::Steps; })
        sweep.template inboard<K>(s);
      else if (has_gravity)
        sweep.template inboard_steps<K, true>(s);
      else
        sweep.template inboard_steps<K, false>(s);
    });
  }
  Between::act(tree, q, workspace);
  for (const KernelRun& s : kernel_runs) {
    dispatch_kernels(s.kind, s.variant, [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (!requires { typename K::Steps; })
        sweep.template outboard<K>(s, base);
      else if (has_gravity)
        sweep.template outboard_steps<K, true>(s, base);
      else
        sweep.template outboard_steps<K, false>(s, base);
    });
  }
}

template <class T>
void evaluate_rates(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  const bool by_steps = takes_steps(tree, workspace.momentum_steps.get(), workspace);
  if constexpr (std::is_same_v<T, double>)
    if (!by_steps) return evaluate_motions<T>(tree, q, p, workspace);
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  const auto in_plane = [](const KernelRun& run) { return run.planar; };
  bool any_plane = false;
  for (const KernelRun& run : tree.kernel_runs()) any_plane = any_plane || run.planar;
  find_sines(tree, q, workspace, any_plane, in_plane);
  const Vec3& g = tree.gravity();
  const bool has_gravity = g.x != 0 || g.y != 0 || g.z != 0;
  const InPlaneSweep<T> planar{tree, p, workspace};
  StepArrays arrays = step_arrays(tree, q, workspace);
  arrays.p = p, arrays.pdot = workspace.pdot.get(), arrays.motions = workspace.parent_states.get();
  workspace.steps->inboard(arrays);
  for (const KernelRun& run : tree.kernel_runs())
    if (run.planar) has_gravity ? planar.template inboard<true>(run) : planar.template inboard<false>(run);
  const Vector3<T> gravity{T(g.x), T(g.y), T(g.z)};
  workspace.steps->outboard(arrays, &gravity);
  for (const KernelRun& run : tree.kernel_runs())
    if (run.planar) has_gravity ? planar.template outboard<true>(run) : planar.template outboard<false>(run);
}
template <class T>
void evaluate_motions(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  sweep_motions<T>(tree, q, p, workspace);
}

}  // namespace momentree
