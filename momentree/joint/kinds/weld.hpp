#pragma once
// Weld: no DoF. E has no columns, M̂ = Mb, D̂ = Db. The kernel frame of a welded body is that of its carrier (Tree::make_frame),
// so its mass is simply added there.
#include <momentree/joint/joint.hpp>

namespace momentree {

struct WeldKernels;

/// Rigid: the child stays at its placement.
struct Weld {
  static constexpr Kind kind = Kind::weld;
  static constexpr KindInfo info{Kind::weld, "weld", 0, 0, false, false, false, "", ""};
  using Kernels = WeldKernels;

  JointStrength strength{};
};

}  // namespace momentree

#ifdef MOMENTREE_KERNELS  // the functions of the recursions: only for the library's own sources
#include <momentree/joint/closure.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/joint/screw_kernels.hpp>

namespace momentree {

template <class T>
struct WeldRecord {
  SpatialMass<T> M;
  Force<T> D;
};

struct WeldKernels : ScrewKernels<WeldKernels, 0, 0> {
  static constexpr bool rigid = true;
  static constexpr std::array<int, 0> angles{};
  static Mat3 frame(const JointSpec&, double*) { return identity3<double>(); }
  template <class T>
  using Record = WeldRecord<T>;
  template <class T>
  MOMENTREE_INLINE static Screw<T> screw(const auto& k, const JointState<T>&) {
    return {T(k.cos_0), T(k.sin_0), T(0)};
  }
  template <class T>
  MOMENTREE_INLINE static Columns<T, 0> columns(const auto&, const JointState<T>&) {
    return {};
  }
  template <class T>
  MOMENTREE_INLINE static void reduce(const auto&, const JointState<T>&, const T*, const auto*, SpatialMass<T>& M, Force<T>& D,
                                      Record<T>& w) {
    w.M = M;
    w.D = D;
  }
  template <class T>
  MOMENTREE_INLINE static void joint_velocity(const Record<T>&, const Motion<T>&, T*) {}
  static bool coordinates(const JointSpec&, const Pose& motion, const Turns&, double*) {
    return coordinates::negligible(motion.position) && coordinates::negligible(motion.rotation);
  }
  static void closure(const JointSpec&, Closure& rows) { rows.add_point(), rows.add_rotation(); }
  template <class T>
  MOMENTREE_INLINE static void joint_acceleration(const Record<T>&, const Motion<T>&, T*) {}
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const auto&, const JointState<T>&, const Record<T>&, const T*, Force<T>&, T*) {}
  template <class T>
  MOMENTREE_INLINE static void add_reduced_bias(const Record<T>&, const Motion<T>&, Force<T>&) {}
};

}  // namespace momentree
#endif
