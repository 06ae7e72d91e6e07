#pragma once
// The generic function library (paper, section 4.1): works for any kind from its pose and joint matrix E. A kind overrides a
// piece where its structure saves work; the law suite (laws_test.cpp) holds every override to these.
#include <array>
#include <type_traits>

#include <momentree/joint/joint.hpp>
#include <momentree/joint/link_constants.hpp>
#include <momentree/math/joint_mass.hpp>
#include <momentree/math/spatial.hpp>

namespace momentree {

/// Coordinates and trigonometry of one joint at one state. c, s: of each angle of the kind; where the kind turns about z, θ0 is
/// added to the angle, and its `pose` then includes that part of the placement.
template <class T>
struct JointState {
  const T* q;
  const T* c;
  const T* s;
};

/// The columns of E, (6): spatial velocities per unit rate, in the child's axes about its origin.
template <class T, int N>
using Columns = std::array<Motion<T>, static_cast<std::size_t>(N)>;

/// What the sweeps keep of a body for the way out, and for further right sides.
template <class T, int N>
struct GenericRecord {
  SpatialMass<T> M;                                     ///< reduced mass (25)
  Force<T> D;                                           ///< reduced remainder (26)
  std::array<Force<T>, static_cast<std::size_t>(N)> G;  ///< Mb E Mj⁻¹
  std::array<T, static_cast<std::size_t>(N)> u0;        ///< Mj⁻¹ (p − Eᵀ Db)
  JointMass<T, N> Mj;                                   ///< factors of the joint-space mass (24)
  Vector3<T> mc;                                        ///< first moment of the subtree
  DenseTransform<T> x;
};

/// (24): Mj = Eᵀ Mb E + armature, from ME = Mb E.
template <class T, int N>
MOMENTREE_INLINE JointMass<T, N> joint_space_mass(const Columns<T, N>& E,
                                                  const std::array<Force<T>, static_cast<std::size_t>(N)>& ME,
                                                  const double* armature) {
  JointMass<T, N> Mj;
  for (int i = 0; i < N; ++i)
    for (int j = 0; j <= i; ++j) Mj(i, j) = dot(E[static_cast<std::size_t>(i)], ME[static_cast<std::size_t>(j)]);
  for (int i = 0; i < N; ++i) Mj(i, i) = Mj(i, i) + armature[i];
  return Mj;
}

/// (25): M̂ = Mb − G (Mb E)ᵀ, one freedom at a time; only the symmetric halves are formed.
template <class T>
MOMENTREE_INLINE void subtract_outer(SpatialMass<T>& M, const Force<T>& g, const Force<T>& e) {
  M.A.xx -= g.l.x * e.l.x, M.A.yy -= g.l.y * e.l.y, M.A.zz -= g.l.z * e.l.z;
  M.A.xy -= g.l.x * e.l.y, M.A.xz -= g.l.x * e.l.z, M.A.yz -= g.l.y * e.l.z;
  M.B.xx -= g.l.x * e.h.x, M.B.xy -= g.l.x * e.h.y, M.B.xz -= g.l.x * e.h.z;
  M.B.yx -= g.l.y * e.h.x, M.B.yy -= g.l.y * e.h.y, M.B.yz -= g.l.y * e.h.z;
  M.B.zx -= g.l.z * e.h.x, M.B.zy -= g.l.z * e.h.y, M.B.zz -= g.l.z * e.h.z;
  M.J.xx -= g.h.x * e.h.x, M.J.yy -= g.h.y * e.h.y, M.J.zz -= g.h.z * e.h.z;
  M.J.xy -= g.h.x * e.h.y, M.J.xz -= g.h.x * e.h.z, M.J.yz -= g.h.y * e.h.z;
}

/// (24)–(26) for any kind: in, Mb and Db of the body (22)(23); out, M̂ and D̂. The record gets G, u0, Mj.
template <class T, int N, class Record>
MOMENTREE_INLINE void reduce_generic(const Columns<T, N>& E, const T* p, const double* armature, SpatialMass<T>& M, Force<T>& D,
                                     Record& w) {
  if constexpr (N > 0) {
    constexpr auto n = static_cast<std::size_t>(N);
    std::array<Force<T>, n> ME;
    for (std::size_t i = 0; i < n; ++i) ME[i] = M * E[i];
    w.Mj = joint_space_mass<T, N>(E, ME, armature);
    w.Mj.factorise();
    for (std::size_t i = 0; i < n; ++i) w.u0[i] = p[i] - dot(E[i], D);
    // G = Mb E Mj⁻¹: solve for each of the six rows of ME.
    w.G = ME;
    const auto solve_row = [&w](auto component) {
      std::array<T, n> row;
      for (std::size_t i = 0; i < n; ++i) row[i] = component(w.G[i]);
      w.Mj.solve(row);
      for (std::size_t i = 0; i < n; ++i) component(w.G[i]) = row[i];
    };
    solve_row([](Force<T>& f) -> T& { return f.l.x; });
    solve_row([](Force<T>& f) -> T& { return f.l.y; });
    solve_row([](Force<T>& f) -> T& { return f.l.z; });
    solve_row([](Force<T>& f) -> T& { return f.h.x; });
    solve_row([](Force<T>& f) -> T& { return f.h.y; });
    solve_row([](Force<T>& f) -> T& { return f.h.z; });
    for (std::size_t i = 0; i < n; ++i) {
      subtract_outer(M, w.G[i], ME[i]);  // (25)
      D += w.u0[i] * w.G[i];             // (26)
    }
    w.Mj.solve(w.u0);
  }
  w.M = M;
  w.D = D;
}

/// (51) for any kind: in, the wrench W that outboard motion asks of the body, without Mb Ω̇, and the joint's force τ; out, W + G
/// (τ − Eᵀ W), what it asks of the parent, and Mj⁻¹ (τ − Eᵀ W), u̇ but for what the parent's acceleration adds.
template <class T, int N, class Record>
MOMENTREE_INLINE void reduce_wrench_generic(const Columns<T, N>& E, const Record& w, const T* tau, Force<T>& W, T* udot) {
  if constexpr (N > 0) {
    constexpr auto n = static_cast<std::size_t>(N);
    for (std::size_t i = 0; i < n; ++i) udot[i] = tau[i] - dot(E[i], W);
    for (std::size_t i = 0; i < n; ++i) W += udot[i] * w.G[i];
    w.Mj.solve(udot);
  }
}

/// Where the pose of a kind is all that is known: R, r of the joint, after its placement. (16), (17).
template <class K, class T>
MOMENTREE_INLINE DenseTransform<T> dense_transform(const LinkConstants& k, const JointState<T>& j) {
  Matrix3<T> R;
  Vector3<T> r;
  K::template pose<T>(k, j, R, r);
  const Mat3 R0 = K::turns_about_z ? tilt_rotation(k) : placement_rotation(k);
  return {R0 * R, Vector3<T>{T(k.r.x), T(k.r.y), T(k.r.z)} + R0 * r};
}

/// How a joint is used, which decides its kernels: with a rotor, with freedoms locked, against its declared direction.
enum class Variant : unsigned char { plain, armature, locked, reversed, reversed_locked };

/// The defaults of a kind with N freedoms that turns and moves in any way. Derive, give `pose`, `columns`, `columns_rate`.
template <class K, int NQ, int NV>
struct GenericKernels {
  template <class T>
  using Record = GenericRecord<T, NV>;
  template <class T>
  using Column = Columns<T, NV>;

  /// True where the joint turns about z, so that x may be chosen freely and θ0 is added to the angle.
  static constexpr bool turns_about_z = false;
  /// True where the body is as one with its parent: the frames coincide, and there is nothing to cross.
  static constexpr bool rigid = false;
  /// Axes of the kernels' frame in the joint's frame, and what the kind keeps in Link::geometry.
  static Mat3 frame(const JointSpec&, double*) { return identity3<double>(); }

  /// Both sweeps cross the joint by its dense pose; the way out finds it in the record.
  template <bool Aligned, class T>
  MOMENTREE_INLINE static DenseTransform<T> joint_transform(const LinkConstants& k, const JointState<T>& j, auto& w) {
    return w.x = dense_transform<K, T>(k, j);
  }
  template <bool Aligned, class T>
  MOMENTREE_INLINE static const DenseTransform<T>& cached_transform(const LinkConstants&, const JointState<T>&, const auto& w) {
    return w.x;
  }
  /// (24)–(26)
  template <class T>
  MOMENTREE_INLINE static void reduce(const LinkConstants& k, const JointState<T>& j, const T* p, const double* armature,
                                      SpatialMass<T>& M, Force<T>& D, auto& w) {
    reduce_generic<T, NV>(K::template columns<T>(k, j), p, armature, M, D, w);
  }
  /// (27): u = u0 − Gᵀ Ω_in, where Ω_in = X Ω_parent.
  template <class R, class T>
  MOMENTREE_INLINE static void joint_velocity(const R& w, const Motion<T>& in, T* u) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) u[i] = w.u0[i] - dot(in, w.G[i]);
  }
  /// (21) in its reduced form: Pb = M̂ Ω_in + D̂.
  template <class R, class T>
  MOMENTREE_INLINE static Force<T> articulated_momentum(const R& w, const T*, const Motion<T>& in) {
    return w.M * in + w.D;
  }
  /// (17): Ω = Ω_in + E u.
  template <class T>
  MOMENTREE_INLINE static Motion<T> spatial_velocity(const LinkConstants& k, const JointState<T>& j, const Motion<T>& in,
                                                     const T* u) {
    const Column<T> E = K::template columns<T>(k, j);
    Motion<T> out = in;
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) {
      out.v += u[i] * E[i].v;
      out.w += u[i] * E[i].w;
    }
    return out;
  }
  /// (20) corrected: ṗ = Eᵀ (Tb − Ω × Pb) + Ėᵀ Pb; joint forces are added where there are any.
  template <class T>
  MOMENTREE_INLINE static void momentum_rate(const LinkConstants& k, const JointState<T>& j, const T* u, const Force<T>& Pb,
                                             const Force<T>& wrench, T* pdot) {
    const Column<T> E = K::template columns<T>(k, j);
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) pdot[i] = dot(E[i], wrench);
    if constexpr (requires { K::template columns_rate<T>(k, j, u); }) {
      const Column<T> Edot = K::template columns_rate<T>(k, j, u);
      for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) pdot[i] = pdot[i] + dot(Edot[i], Pb);
    }
  }

  // The second recursion.

  /// What Ω̇ has beyond X Ω̇_parent + E u̇: Ω × E u, because X turns, and Ė u.
  template <class T>
  MOMENTREE_INLINE static Motion<T> acceleration_bias(const LinkConstants& k, const JointState<T>& j, const Motion<T>& velocity,
                                                      const T* u) {
    Motion<T> bias = cross(velocity, K::template spatial_velocity<T>(k, j, {}, u));
    if constexpr (requires { K::template columns_rate<T>(k, j, u); }) {
      const Column<T> Edot = K::template columns_rate<T>(k, j, u);
      for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) {
        bias.v += u[i] * Edot[i].v;
        bias.w += u[i] * Edot[i].w;
      }
    }
    return bias;
  }
  /// (51); `tau` may be `udot` itself.
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const LinkConstants& k, const JointState<T>& j, const auto& w, const T* tau,
                                             Force<T>& W, T* udot) {
    reduce_wrench_generic<T, NV>(K::template columns<T>(k, j), w, tau, W, udot);
  }
  /// (47): the parent's part, u̇ − Gᵀ a′ with a′ = X Ω̇_parent + bias.
  template <class R, class T>
  MOMENTREE_INLINE static void joint_acceleration(const R& w, const Motion<T>& in, T* udot) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) udot[i] = udot[i] - dot(in, w.G[i]);
  }
  /// F + M̂ a.
  template <class R, class T>
  MOMENTREE_INLINE static void add_reduced(const R& w, const Motion<T>& a, Force<T>& F) {
    F += w.M * a;
  }
  /// The same for the bias, which may have zeros.
  template <class R, class T>
  MOMENTREE_INLINE static void add_reduced_bias(const R& w, const Motion<T>& bias, Force<T>& F) {
    K::add_reduced(w, bias, F);
  }
  /// The wrench by which a drive, a spring, a damper acts on the child, W with Eᵀ W = force: a pure torque for a freedom that
  /// turns, a force through the origin for one that slides. Here the columns of E are of length one and across each other.
  static Force<double> drive_wrench(const LinkConstants& k, const JointState<double>& j, const double* force) {
    const Column<double> E = K::template columns<double>(k, j);
    Force<double> W{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) {
      W.l += force[i] * E[i].v;
      W.h += force[i] * E[i].w;
    }
    return W;
  }

  /// q̇ = N(q) u; here u are the coordinates' own rates.
  template <class T>
  MOMENTREE_INLINE static void coordinate_rate(const T*, const T* u, T* qdot) {
    for (int i = 0; i < NQ; ++i) qdot[i] = u[i];
  }
  /// Back onto the manifold after a step (unit quaternions).
  static void normalise(double*) {}
  /// Coordinates of no motion.
  static void zero(double* q) {
    for (int i = 0; i < NQ; ++i) q[i] = 0;
  }
  /// Spring: generalised force per unit stiffness of each freedom, and energy, for coordinates q about rest q0.
  static double spring(const double* q, const double* q0, const double* stiffness, double* force) {
    double energy = 0;
    for (int i = 0; i < NV; ++i) {
      const double x = q[i] - q0[i];
      force[i] = -stiffness[i] * x;
      energy += 0.5 * stiffness[i] * x * x;
    }
    return energy;
  }
};

}  // namespace momentree
