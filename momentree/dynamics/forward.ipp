#pragma once
// Definitions of the two recursions; included only by instantiate/*.cpp, each for one scalar, which also include
// derived_sweep.ipp or are compiled beside an instantiation of it.
//
// The passes run along the tree's order with their sums in local variables. The first child of a body follows it directly, so
// sums pass through memory only for later children. Kernel runs, consecutive bodies with the same kernels, are one loop.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/in_plane.ipp>
#include <momentree/dynamics/pair_sweep.hpp>
#include <momentree/dynamics/revolute_dispatch.hpp>
#include <momentree/dynamics/sweep_buffers.hpp>
#include <momentree/joint/derived_list.hpp>  // generated: the kinds with derived steps
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/pack.hpp>

namespace momentree {

/// True for kernels with derived steps: whether there are any can be known without their text.
#define MOMENTREE_IS_DERIVED(name, Type) std::is_same_v<K, typename Type::Kernels> ||
template <class K>
inline constexpr bool is_derived = MOMENTREE_DERIVED(MOMENTREE_IS_DERIVED) false;
#undef MOMENTREE_IS_DERIVED

template <class T>
struct Sweep {
  UncheckedTree tree;
  const T* q;
  const T* p;
  Workspace<T>& workspace;
  bool has_gravity;  // if false, first moments are not summed
  unsigned roots;    // the flag of the bodies that contribute to no parent: node::grounded in a stage
  SweepBuffers<Inboard<T>, Outboard<T>> buffers{tree, workspace.child_sums.get(), workspace.parent_states.get()};

  MOMENTREE_INLINE JointState<T> joint_state(int b) const {
    return {q + tree.first_q(b), workspace.cos.get() + tree.first_angle(b), workspace.sin.get() + tree.first_angle(b)};
  }

  /// Backward recursion over a kernel run. `Keep` as below.
  template <class K, bool Keep>
  void inboard(const KernelRun& run) const {
    const auto order = tree.order();
    const auto node_flags = tree.node_flags();
    auto* const records = workspace.template records_of<K>(tree, run);
    Inboard<T> a;
    if constexpr (K::rigid && !Keep)
      if (run.end == run.begin + 1 && (node_flags[static_cast<std::size_t>(run.begin)] & node::grounded) != 0) return;
    buffers.resume_inward(run, a);
    for (int i = run.end - 1; i >= run.begin; --i) {
      const int b = order[static_cast<std::size_t>(i)];
      const unsigned flags = node_flags[static_cast<std::size_t>(i)];
      if constexpr (K::rigid && !Keep)
        if ((flags & node::grounded) != 0) continue;  // it rests, and its children contribute nothing
      const LinkConstants& link = tree.link(b);
      const JointState<T> joint = joint_state(b);
      auto& record = records[i - run.begin];
      if ((flags & node::leaf) != 0) a = {};  // Mb = M, Db = 0
      buffers.gather_children(b, flags, a);
      SpatialMass<T>& M = articulated_mass(link.body, a.M);  // (22)
      Force<T>& D = remainder_momentum(a.D);                 // (23)
      a.mc.x += link.body.mc.x, a.mc.y += link.body.mc.y, a.mc.z += link.body.mc.z;
      if constexpr (K::rigid) {
        if constexpr (Keep) record.M = M, record.D = D;
      } else {
        record.mc = has_gravity ? a.mc : Vector3<T>{T(0), T(0), T(0)};
        K::template reduce<T>(link, joint, p + tree.first_p(b), tree.armature() + tree.first_p(b), M, D, record);  // (24)–(26)
        const auto over = [&](const auto& transform) MOMENTREE_INLINE_LAMBDA {
          if ((flags & roots) != 0) return;  // the ground needs no output
          transform.inboard(M);              // (16)
          transform.inboard(D);
          transform.inboard(a.mc, tree.subtree_mass(b));
        };
        if (K::rotates_about_z && (flags & node::aligned) != 0)
          over(K::template joint_transform<true, T>(link, joint, record));
        else
          over(K::template joint_transform<false, T>(link, joint, record));
      }
      if ((flags & roots) == 0) buffers.add_to_parent(b, flags, a);
    }
    buffers.suspend_inward(run, a);
  }

  /// Forward recursion over a kernel run. `Keep`: also stores Ω and Pb, which changes and accelerations read; stages do not.
  template <class K, bool Keep>
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
        if constexpr (Keep)
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
        if constexpr (Keep) workspace.motions[static_cast<std::size_t>(b)] = {a.velocity, Pb};
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

  // The same for kinds with derived steps, in a stage: derived_sweep.ipp.

  template <class K>
  void inboard_derived(const KernelRun& run) const;
  template <class K>
  void outboard_derived(const KernelRun& run, const Outboard<T>& base) const;

  // The same for kinds with whole steps by the shape of a link.

  template <class K, bool Gravity, bool Keep>
  void inboard_steps(const KernelRun& run) const {
    constexpr unsigned ends = Keep ? node::root : node::grounded;
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
          K::Steps::template inboard<shape(), Gravity, Keep, children(), destination() == Destination::none>(
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
      dispatch_inboard<K::Steps::has_armature, ends>(link.shape, flags, step);
      if ((flags & ends) == 0) buffers.add_sibling(b, flags, a);
    }
    buffers.suspend_inward(run, a);
  }

  template <class K, bool Gravity, bool Keep>
  void outboard_steps(const KernelRun& run, const Outboard<T>& base) const {
    constexpr unsigned ends = Keep ? node::root : node::grounded;
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
      auto* const kept = Keep ? &workspace.motions[static_cast<std::size_t>(b)] : nullptr;
      if ((flags & ends) != 0) {
        a = base;
        K::Steps::template outboard_root<Gravity, Keep>(link, workspace.cos[angle], workspace.sin[angle], *record, p[at], a,
                                                        workspace.v[at], workspace.pdot[at], kept);
      } else {
        buffers.load_parent(b, flags, base, a);
        dispatch_link<K::Steps::has_armature>(link.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
          K::Steps::template outboard<shape(), Gravity, Keep>(link, workspace.cos[angle], workspace.sin[angle], *record, p[at],
                                                              (flags & node::leaf) != 0, a, workspace.v[at], workspace.pdot[at],
                                                              kept);
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

/// Calls f(std::integral_constant<PlaneRoot, …>) with the root of a plane mechanism, if the scalar has kernels for it. The state
/// of a free root decides whether it is in the plane, so only numbers have them.
template <class T, class F>
MOMENTREE_INLINE void dispatch_plane(const KernelRun& run, const F& f) {
  if (run.plane < 0) return f(std::integral_constant<PlaneRoot, PlaneRoot::revolute>{});
  if (run.kind != Kind::free) return f(std::integral_constant<PlaneRoot, PlaneRoot::planar>{});
  if constexpr (std::is_same_v<T, double>) f(std::integral_constant<PlaneRoot, PlaneRoot::free>{});
}

/// Decides which floating mechanisms are evaluated in their planes. Returns whether any mechanism is, grounded ones included.
template <class T>
MOMENTREE_INLINE bool enter_planes(const InPlaneSweep<T>& planar) {
  bool any = false;
  for (const KernelRun& run : planar.tree.kernel_runs()) {
    any = any || run.planar;
    if (run.plane < 0 || run.plane != run.begin) continue;
    bool& in_plane = planar.workspace.in_plane[run.plane];
    in_plane = false;
    dispatch_plane<T>(run, [&](auto root) { in_plane = planar.floating.template enter<root()>(run); });
    any = any || in_plane;
  }
  return any;
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
    if (in_plane(run) && (run.plane < 0 || run.plane == run.begin))
      dispatch_plane<T>(run, [&](auto root) { add_up_angles<root()>(tree, run, s); });
  sincos_in_blocks(
      n, [s](int i) MOMENTREE_INLINE_LAMBDA { return s[i]; }, s, c);
}

/// Between the passes of a tree nothing happens.
struct NothingBetween {
  static constexpr bool in_pairs = true;  // paired branches, whose records are elsewhere until the outward pass
  template <class T>
  MOMENTREE_INLINE static void act(const Tree&, const T*, Workspace<T>&) {}
};

/// Between::act, called after the inward pass, may change u0 of the records. (As a type, not an argument: this leaves the code
/// without it as it is.)
template <class T, bool Keep, class Between = NothingBetween>
void sweep_rates(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  MT_REQUIRE(workspace.capacity() >= tree.bodies(), "the workspace has room for the tree's bodies: construct it for this tree");
  workspace.evaluated = {};
  workspace.located = {};
  workspace.accelerated = {};
  constexpr bool in_pairs = has_pair_lanes && std::is_same_v<T, double> && Between::in_pairs;
  const auto kernel_runs = in_pairs ? tree.paired_runs() : tree.kernel_runs();
  const Vec3& g = tree.gravity();
  const bool has_gravity = g.x != 0 || g.y != 0 || g.z != 0;
  const InPlaneSweep<T> planar{tree, q, p, workspace};
  const bool any_plane = !Keep && tree.has_planes() && enter_planes(planar);
  const auto in_plane = [&](const KernelRun& run) MOMENTREE_INLINE_LAMBDA {
    return any_plane && (run.planar || (run.plane >= 0 && workspace.in_plane[run.plane]));
  };
  find_sines(tree, q, workspace, any_plane, in_plane);

  const Sweep<T> sweep{tree, q, p, workspace, has_gravity, Keep ? node::root : node::grounded};
  T o(0);  // not constexpr, and written out: clearing structs has a cost that shows for small mechanisms
  const Outboard<T> base{{{o, o, o}, {o, o, o}}, {T(g.x), T(g.y), T(g.z)}};
  for (std::size_t i = kernel_runs.size(); i-- > 0;) {
    const KernelRun& s = kernel_runs[i];
    if constexpr (!Keep) {
      if (in_plane(s)) {  // a floating mechanism as a whole, with its root's run
        if (s.plane < 0 || s.plane == s.begin)
          dispatch_plane<T>(s, [&](auto root) {
            has_gravity ? planar.template inboard<true, root()>(s) : planar.template inboard<false, root()>(s);
          });
        continue;
      }
    }
    if constexpr (in_pairs) {
      if (s.pair >= 0) {
        if (s.begin > s.pair) pairs_inboard<Keep>(tree, s, has_gravity, p, workspace);
        continue;
      }
    }
    dispatch_kernels(s.kind, s.variant, [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (requires { typename K::Steps; }) {
        if (has_gravity)
          sweep.template inboard_steps<K, true, Keep>(s);
        else
          sweep.template inboard_steps<K, false, Keep>(s);
      } else {
        if constexpr (!Keep && is_derived<K>)
          if (s.variant == Variant::plain) return sweep.template inboard_derived<K>(s);
        sweep.template inboard<K, Keep && K::rigid>(s);  // only rigid kernels store anything in the inward pass
      }
    });
  }
  Between::act(tree, q, workspace);
  for (const KernelRun& s : kernel_runs) {
    if constexpr (!Keep) {
      if (in_plane(s)) {  // a floating mechanism as a whole, with its root's run
        if (s.plane < 0 || s.plane == s.begin)
          dispatch_plane<T>(s, [&](auto root) {
            has_gravity ? planar.template outboard<true, root()>(s) : planar.template outboard<false, root()>(s);
          });
        continue;
      }
    }
    if constexpr (in_pairs) {
      if (s.pair >= 0) {
        if (s.begin < s.pair) pairs_outboard<Keep>(tree, s, has_gravity, base, p, workspace);
        continue;
      }
    }
    dispatch_kernels(s.kind, s.variant, [&](auto tag) {
      using K = typename decltype(tag)::type;
      if constexpr (requires { typename K::Steps; }) {
        if (has_gravity)
          sweep.template outboard_steps<K, true, Keep>(s, base);
        else
          sweep.template outboard_steps<K, false, Keep>(s, base);
      } else {
        if constexpr (!Keep && is_derived<K>)
          if (s.variant == Variant::plain) return sweep.template outboard_derived<K>(s, base);
        sweep.template outboard<K, Keep>(s, base);
      }
    });
  }
  if constexpr (Keep && std::is_same_v<T, double>) {
    if (!tree.has_planes()) return;
    for (const KernelRun& s : tree.kernel_runs())
      if (s.plane >= 0 && s.plane == s.begin && s.kind == Kind::free) planar.floating.stay(s);
  }
}

template <class T>
void evaluate_rates(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  sweep_rates<T, false>(tree, q, p, workspace);
}
template <class T>
void evaluate_motions(const Tree& tree, const T* q, const T* p, Workspace<T>& workspace) noexcept {
  sweep_rates<T, true>(tree, q, p, workspace);
}

}  // namespace momentree
