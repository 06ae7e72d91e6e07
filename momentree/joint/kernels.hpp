#pragma once
// Kernels of any joint kind, from its pose and its joint matrix E (paper, section 4.1). A kind overrides a function where its
// structure saves operations; the law suite (laws_test.cpp) checks every override against these.
//
// Glossary: names in the kernels, the paper's symbols and its equations. Spatial vectors have the linear part first, in the axes
// of the body's kernel frame (link_constants.hpp), about its origin. A hat marks a quantity that is reduced about the joint, b an
// articulated one (of the body and all bodies outboard).
//
//   in the code                    symbol              quantity                                              equation
//   -----------------------------  ------------------  ----------------------------------------------------  ----------
//   body (RigidMass)               M                   mass matrix of the rigid body                         (4)
//   M, D (arguments of `reduce`)   Mb, Db              articulated mass M + Σ Xᵀ M̂ X, remainder Σ Xᵀ D̂       (22), (23)
//   w.M, w.D; Inboard::M, D        M̂, D̂                reduced mass, reduced remainder momentum              (25), (26)
//   E, columns; columns_rate       E; Ė                joint matrix, one column per DoF; its rate            (6)
//   ME; e                          Mb E                                                                      (24)
//   Mj, w.Mj; w.inverse_mass       Mj; 1/Mj            joint-space mass Eᵀ Mb E + armature                   (24)
//   w.G, g; gl, gh                 G = Mb E Mj⁻¹       its linear and angular parts                          (24), (25)
//   w.u0                           Mj⁻¹ (p − Eᵀ Db)    joint velocity u if the parent is at rest             (27)
//   joint_transform, x             X, Xᵀ               outboard: velocities X Ω; inboard: Xᵀ P, Xᵀ M X       (16), (17)
//   in                             X Ω_parent          parent's velocity in the body's frame                 (17)
//   velocity                       Ω = (v; ω)          spatial velocity of the body                          (17)
//   u, workspace.v                 u                   joint velocities                                      (27)
//   articulated, Pb                Pb                  articulated momentum, Mb Ω + Db = M̂ X Ω_parent + D̂    (14), (21)
//   p, momentum                    p = Eᵀ Pb + …       canonical momenta of the joint (armature · u added)   (19)
//   mc, gravity                    Tb                  first moment of the subtree; weight Tb                (15)
//   wrench                         Tb − Ω × Pb                                                               (9), (20)
//   pdot, rate                     ṗ                   rate of the canonical momenta                         (20)
//   bias                           Ω × E u + Ė u       acceleration that no u̇ causes                         (39)
//   W                              W; Ŵ                bias wrench; reduced by `reduce_wrench`               (45), (51)
//   tau, udot, workspace.a         τ, u̇                joint force, joint acceleration                       (51), (47)
//   a, approach                    a′ = X Ω̇_p + bias   acceleration of the body without E u̇                  (39)
#include <array>
#include <type_traits>

#include <momentree/joint/joint.hpp>
#include <momentree/joint/joint_transforms.hpp>
#include <momentree/joint/link_constants.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/math/joint_mass.hpp>
#include <momentree/math/spatial.hpp>

namespace momentree {

/// Coordinates and trigonometry of one joint in one state. c, s: cosine and sine of each angle of the kind. For kinds that rotate
/// about z, θ0 is included in the angle, and `pose` then includes that part of the placement.
template <class T>
struct JointState {
  const T* q;
  const T* c;
  const T* s;
};

/// The columns of E, (6): spatial velocities per unit rate, in the child's axes about its origin.
template <class T, int N>
using Columns = std::array<Motion<T>, static_cast<std::size_t>(N)>;

/// Quantities of a body that the inward pass stores for the outward pass, and for further right-hand sides.
template <class T, int N>
struct GenericRecord {
  SpatialMass<T> M;                                     ///< reduced mass (25)
  Force<T> D;                                           ///< reduced remainder (26)
  std::array<Force<T>, static_cast<std::size_t>(N)> G;  ///< Mb E Mj⁻¹
  std::array<T, static_cast<std::size_t>(N)> u0;        ///< Mj⁻¹ (p − Eᵀ Db)
  JointMass<T, N> Mj;                                   ///< factors of the joint-space mass (24)
  Vector3<T> mc;                                        ///< first moment of the subtree (kg m)
  DenseTransform<T> x;
};

// The equations of both passes. Those of the inward pass work in place: `M` and `D` hold the sums of the children's
// contributions, then the articulated, then the reduced quantities.

/// (22): Mb = M + Σ Xᵀ M̂ X, from the sum.
template <class T, class Body>
MOMENTREE_INLINE SpatialMass<T>& articulated_mass(const Body& body, SpatialMass<T>& children) {
  add_rigid_mass(children, body);
  return children;
}
/// (23): Db = Σ Xᵀ D̂, the sum itself, because the body's own momentum is contained in Mb Ω.
template <class T>
MOMENTREE_INLINE Force<T>& remainder_momentum(Force<T>& children) {
  return children;
}
/// (24): Mj = Eᵀ Mb E + armature, from ME = Mb E.
template <class T, int N>
MOMENTREE_INLINE JointMass<T, N> joint_space_mass(const Columns<T, N>& E,
                                                  const std::array<Force<T>, static_cast<std::size_t>(N)>& ME,
                                                  const auto* armature) {
  JointMass<T, N> Mj;
  for (int i = 0; i < N; ++i)
    for (int j = 0; j <= i; ++j) Mj(i, j) = dot(E[static_cast<std::size_t>(i)], ME[static_cast<std::size_t>(j)]);
  for (int i = 0; i < N; ++i) Mj(i, i) = Mj(i, i) + armature[i];
  return Mj;
}

/// M − g eᵀ, symmetric; only one triangle of A and J is formed.
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

/// (25): M̂ = Mb − G (Mb E)ᵀ.
template <class T, std::size_t N>
MOMENTREE_INLINE void reduced_mass(const std::array<Force<T>, N>& G, const std::array<Force<T>, N>& ME, SpatialMass<T>& M) {
  for (std::size_t i = 0; i < N; ++i) subtract_outer(M, G[i], ME[i]);
}
/// (26): D̂ = Db + G (p − Eᵀ Db); `r` is the difference.
template <class T, std::size_t N>
MOMENTREE_INLINE void reduced_remainder(const std::array<Force<T>, N>& G, const std::array<T, N>& r, Force<T>& D) {
  for (std::size_t i = 0; i < N; ++i) D += r[i] * G[i];
}
/// (15): Tb of the weight: the mass of the subtree and its first moment, with gravity in the body's axes.
template <class T>
MOMENTREE_INLINE Force<T> accumulated_force(const auto& mass, const Vector3<T>& mc, const Vector3<T>& gravity) {
  return {mass * gravity, cross(mc, gravity)};
}

/// (24)–(26) for any kind. In: Mb and Db of the body (22), (23). Out: M̂ and D̂ in their place. Writes G, u0 and Mj to the
/// record.
template <class T, int N, class Record>
MOMENTREE_INLINE void reduce_generic(const Columns<T, N>& E, const T* p, const auto* armature, SpatialMass<T>& M, Force<T>& D,
                                     Record& w) {
  if constexpr (N > 0) {
    constexpr auto n = static_cast<std::size_t>(N);
    std::array<Force<T>, n> ME;
    for (std::size_t i = 0; i < n; ++i) ME[i] = M * E[i];
    w.Mj = joint_space_mass<T, N>(E, ME, armature);  // (24)
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
    reduced_mass(w.G, ME, M);         // (25)
    reduced_remainder(w.G, w.u0, D);  // (26)
    w.Mj.solve(w.u0);
  }
  w.M = M;
  w.D = D;
}

/// (51) for any kind. In: bias wrench W (without Mb Ω̇) and joint force τ. Out: reduced bias wrench Ŵ = W + G (τ − Eᵀ W) in `W`,
/// and Mj⁻¹ (τ − Eᵀ W) in `udot`, which is u̇ except for the part caused by the parent's acceleration.
template <class T, int N, class Record>
MOMENTREE_INLINE void reduce_wrench_generic(const Columns<T, N>& E, const Record& w, const T* tau, Force<T>& W, T* udot) {
  if constexpr (N > 0) {
    constexpr auto n = static_cast<std::size_t>(N);
    for (std::size_t i = 0; i < n; ++i) udot[i] = tau[i] - dot(E[i], W);
    for (std::size_t i = 0; i < n; ++i) W += udot[i] * w.G[i];
    w.Mj.solve(udot);
  }
}

/// The joint transform of a kind from its pose (R, r of the joint), including its placement. (16), (17).
template <class K, class T>
MOMENTREE_INLINE DenseTransform<T> dense_transform(const auto& k, const JointState<T>& j) {
  Matrix3<T> R;
  Vector3<T> r;
  K::template pose<T>(k, j, R, r);
  const auto R0 = [&k]() MOMENTREE_INLINE_LAMBDA {
    if constexpr (K::rotates_about_z)
      return tilt_rotation(k);
    else
      return placement_rotation(k);
  }();
  return {R0 * R, Vector3<T>{T(k.r.x), T(k.r.y), T(k.r.z)} + R0 * r};
}

/// Defaults for a kind with NQ coordinates and NV DoFs that moves in any way. A derived class provides `pose`, `columns` and, if
/// E changes, `columns_rate`.
template <class K, int NQ, int NV>
struct GenericKernels {
  template <class T>
  using Record = GenericRecord<T, NV>;
  template <class T>
  using Column = Columns<T, NV>;

  static constexpr int nq = NQ, nv = NV;
  /// True if the joint rotates about z, so that the x axis may be chosen freely and θ0 is added to the joint angle.
  static constexpr bool rotates_about_z = false;
  /// True if the offset along the joint's axis is known apart from that along the parent's x: see PlacementShape.
  static constexpr bool placed_by_shape = false;
  /// True if the body is rigidly attached to its parent: the frames coincide and X = I.
  static constexpr bool rigid = false;
  /// Axes of the kernel frame in the joint's frame; stores constants of the kind in LinkConstants::geometry.
  static Mat3 frame(const JointSpec&, double*) { return identity3<double>(); }

  /// Both passes use the dense transform; the outward pass reads it from the record.
  template <bool Aligned, class T>
  MOMENTREE_INLINE static DenseTransform<T> joint_transform(const auto& k, const JointState<T>& j, auto& w) {
    return w.x = dense_transform<K, T>(k, j);
  }
  template <bool Aligned, class T>
  MOMENTREE_INLINE static const DenseTransform<T>& cached_transform(const auto&, const JointState<T>&, const auto& w) {
    return w.x;
  }
  /// (24)–(26)
  template <class T>
  MOMENTREE_INLINE static void reduce(const auto& k, const JointState<T>& j, const T* p, const auto* armature, SpatialMass<T>& M,
                                      Force<T>& D, auto& w) {
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
  MOMENTREE_INLINE static Motion<T> spatial_velocity(const auto& k, const JointState<T>& j, const Motion<T>& in, const T* u) {
    const Column<T> E = K::template columns<T>(k, j);
    Motion<T> out = in;
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) {
      out.v += u[i] * E[i].v;
      out.w += u[i] * E[i].w;
    }
    return out;
  }
  /// (27) and (17), one after the other: writes u and returns Ω.
  template <class T>
  MOMENTREE_INLINE static Motion<T> move(const auto& k, const JointState<T>& j, const auto& w, const Motion<T>& in, T* u) {
    K::joint_velocity(w, in, u);
    return K::template spatial_velocity<T>(k, j, in, u);
  }
  /// (20), corrected: ṗ = Eᵀ (Tb − Ω × Pb) + Ėᵀ Pb; `wrench` is Tb − Ω × Pb. Joint forces are added by the caller.
  template <class T>
  MOMENTREE_INLINE static void momentum_rate(const auto& k, const JointState<T>& j, const T* u, const Force<T>& Pb,
                                             const Force<T>& wrench, T* pdot) {
    const Column<T> E = K::template columns<T>(k, j);
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) pdot[i] = dot(E[i], wrench);
    if constexpr (requires { K::template columns_rate<T>(k, j, u); }) {
      const Column<T> Edot = K::template columns_rate<T>(k, j, u);
      for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) pdot[i] = pdot[i] + dot(Edot[i], Pb);
    }
  }

  // Second recursion.

  /// (39): the part of Ω̇ other than X Ω̇_parent + E u̇: Ω × E u, because X changes, and Ė u.
  template <class T>
  MOMENTREE_INLINE static Motion<T> acceleration_bias(const auto& k, const JointState<T>& j, const Motion<T>& velocity,
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
  /// (51); `tau` may alias `udot`.
  template <class T>
  MOMENTREE_INLINE static void reduce_wrench(const auto& k, const JointState<T>& j, const auto& w, const T* tau, Force<T>& W,
                                             T* udot) {
    reduce_wrench_generic<T, NV>(K::template columns<T>(k, j), w, tau, W, udot);
  }
  /// (47): subtracts the parent's part, u̇ − Gᵀ a′ with a′ = X Ω̇_parent + bias.
  template <class R, class T>
  MOMENTREE_INLINE static void joint_acceleration(const R& w, const Motion<T>& in, T* udot) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) udot[i] = udot[i] - dot(in, w.G[i]);
  }
  /// (47) and (39), one after the other: completes u̇ and returns Ω̇.
  template <class T>
  MOMENTREE_INLINE static Motion<T> accelerate(const auto& k, const JointState<T>& j, const auto& w, const Motion<T>& in,
                                               T* udot) {
    K::joint_acceleration(w, in, udot);
    return K::template spatial_velocity<T>(k, j, in, udot);
  }
  /// F += M̂ a.
  template <class R, class T>
  MOMENTREE_INLINE static void add_reduced(const R& w, const Motion<T>& a, Force<T>& F) {
    F += w.M * a;
  }
  /// The same for the bias, whose structural zeros may be exploited.
  template <class R, class T>
  MOMENTREE_INLINE static void add_reduced_bias(const R& w, const Motion<T>& bias, Force<T>& F) {
    K::add_reduced(w, bias, F);
  }
  /// The wrench W on the child by which a drive, spring or damper acts, Eᵀ W = force: a pure torque for a rotational DoF, a force
  /// through the origin for a translational one. This default requires orthonormal columns of E.
  static Force<double> drive_wrench(const LinkConstants& k, const JointState<double>& j, const double* force) {
    const Column<double> E = K::template columns<double>(k, j);
    Force<double> W{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(NV); ++i) {
      W.l += force[i] * E[i].v;
      W.h += force[i] * E[i].w;
    }
    return W;
  }

  /// q̇ = N(q) u; by default u are the rates of the coordinates.
  template <class T>
  MOMENTREE_INLINE static void coordinate_rate(const T*, const T* u, T* qdot) {
    for (int i = 0; i < NQ; ++i) qdot[i] = u[i];
  }
  /// Projects the coordinates back onto their manifold after a step (unit quaternions).
  static void normalise(double*) {}
  /// Coordinates of zero displacement.
  static void zero(double* q) {
    for (int i = 0; i < NQ; ++i) q[i] = 0;
  }
  /// Spring about q0: writes the generalised force −stiffness·(q − q0) of each DoF (N m, N) and returns the energy (J).
  template <class T>
  static T spring(const T* q, const double* q0, const double* stiffness, T* force) {
    T energy(0);
    for (int i = 0; i < NV; ++i) {
      const T x = q[i] - q0[i];
      force[i] = -stiffness[i] * x;
      energy += 0.5 * stiffness[i] * x * x;
    }
    return energy;
  }
};

}  // namespace momentree
