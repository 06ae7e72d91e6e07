#pragma once
// Steps of both passes across a revolute joint: (22)–(26) and (16) inboard, (17), (27), (21), (20) outboard, each fused into one
// function. They exploit the zeros that reduction about z leaves (without armature) and those of the placement of most links.
//
// Written by hand, for evaluations whose records are kept (ADR 20). Stages of integrators go through the StepTable.
#include <momentree/joint/placement_shapes.hpp>
#include <momentree/joint/revolute_blocks.hpp>
#include <momentree/joint/revolute_record.hpp>

namespace momentree {

/// True if a scalar represents a single world, whose evaluation is limited by the latency of the divisions.
template <class T>
inline constexpr bool one_world_at_a_time = std::is_same_v<T, double>;

/// Contributions of its children that a body collects: none (leaf), one, or at a branching body the first child's and the sum of
/// the others'.
enum class Children : unsigned char { none, one, several };

template <bool Armature>
struct RevoluteStepsOf {
  static constexpr bool has_armature = Armature;
  template <class T>
  using Record = std::conditional_t<Armature, ArmatureRecord<T>, RevoluteRecord<T>>;

  template <PlacementShape S>
  using Has = PlacementTerms<S>;

  /// Inward step of one body. In: the contributions of its children, in the body's frame, `in` of the first and `others` the sum
  /// of the rest. Out: its own contribution, in the parent's frame; `out` may alias `in`. `Root`: the parent is the ground, so no
  /// output is produced. `mass`: of the subtree (kg). `armature`: of the joint (kg m²), if it has any. With a `bias`, this is the
  /// step of the equations of accelerations: joint forces in place of momenta, wrenches in place of remainders.
  template <PlacementShape S, bool Gravity, Children N, bool Root, class L, class T, class B = NoBias>
  MOMENTREE_INLINE static void inboard(const L& k, const detail::ConstantOf<L>& mass,
                                       [[maybe_unused]] const detail::ConstantOf<L>& armature, const T& cosine, const T& sine,
                                       const T& momentum, const Inboard<T>& in, const Inboard<T>& others, Record<T>& w,
                                       Inboard<T>& out, const B& bias = {}) {
    constexpr bool shifts = Has<S>::d;
    constexpr bool biased = !std::is_same_v<B, NoBias>;
    const T c = cosine, s = sine, p = momentum;
    const auto& b = k.body;
    const T Jzz = with<N>(in.M.J.zz, others.M.J.zz, b.J.zz);
    T Mj = Jzz;  // (24)
    if constexpr (Armature) Mj = Mj + armature;
    const T inverse = T(1) / Mj;
    detail::RevoluteColumn<T> e{with<N>(in.M.B.xz, others.M.B.xz, -b.mc.y), with<N>(in.M.B.yz, others.M.B.yz, b.mc.x),
                                alone<N>(in.M.B.zz, others.M.B.zz), with<N>(in.M.J.xz, others.M.J.xz, b.J.xz),
                                with<N>(in.M.J.yz, others.M.J.yz, b.J.yz)};
    constexpr bool leaf = N == Children::none;  // known zeros are not computed
    constexpr bool nothing_outboard = leaf && !biased;
    const detail::RevoluteColumn<T> g{inverse * e.lx, inverse * e.ly, leaf ? T(0) : inverse * e.lz, inverse * e.hx,
                                      inverse * e.hy};
    w.gl.x = g.lx, w.gl.y = g.ly, w.gl.z = g.lz, w.ghx = g.hx, w.ghy = g.hy;
    w.inverse_mass = inverse;
    if constexpr (Armature) w.armature = T(armature), w.ghz = inverse * Jzz;
    T u = p;
    if constexpr (!nothing_outboard) u = p - remainder<N>(in.D.h.z, others.D.h.z, bias.wrench.h.z);
    w.u0 = inverse * u;  // frees a register here; compilers do not find this order

    detail::ReducedMass<T> m;
    reduce_mass<shifts, !Root, N>(k, c, s, e, g, in.M, others.M, m, w);
    w.A.zz = m.Azz;
    if constexpr (!Root) {
      if constexpr (Armature) {
        detail::RevoluteColumn<T> z{armature * g.lx, armature * g.ly, armature * g.lz, armature * g.hx, armature * g.hy};
        detail::cross_z<shifts>(z, c, s, k.d);
        const T zz = armature * w.ghz;
        mass_inboard<S>(k, m, z, zz, out.M);
      } else {
        mass_inboard<S>(k, m, nullptr, nullptr, out.M);
      }
    }

    T hz = p;  // D̂·E
    if constexpr (Armature) w.hz = hz = remainder<N>(in.D.h.z, others.D.h.z, bias.wrench.h.z) + u * w.ghz;
    Force<T> D{
        {remainder<N>(in.D.l.x, others.D.l.x, bias.wrench.l.x), remainder<N>(in.D.l.y, others.D.l.y, bias.wrench.l.y),
         remainder<N>(in.D.l.z, others.D.l.z, bias.wrench.l.z)},
        {remainder<N>(in.D.h.x, others.D.h.x, bias.wrench.h.x), remainder<N>(in.D.h.y, others.D.h.y, bias.wrench.h.y), hz}};
    Vector3<T> mc;
    if constexpr (Gravity)
      mc.x = with<N>(in.mc.x, others.mc.x, b.mc.x), mc.y = with<N>(in.mc.y, others.mc.y, b.mc.y),
      mc.z = with<N>(in.mc.z, others.mc.z, b.mc.z);
    if constexpr (nothing_outboard)  // (26)
      D = {{u * g.lx, u * g.ly, T(0)}, {u * g.hx, u * g.hy, hz}};
    else
      D.l.x += u * g.lx, D.l.y += u * g.ly, D.l.z += u * g.lz, D.h.x += u * g.hx, D.h.y += u * g.hy;
    w.l.x = D.l.x, w.l.y = D.l.y, w.hx = D.h.x, w.hy = D.h.y;
    w.l.z = D.l.z;
    if constexpr (Gravity) w.mc.x = mc.x, w.mc.y = mc.y;
    if constexpr (Root) return;
    if constexpr (biased) add_reduced_bias(w, bias.acceleration, D);
    detail::cross_z<shifts>(D, c, s, k.d);
    if constexpr (Gravity) rotate_z(mc, c, s);
    momentum_inboard<S, Gravity>(k, mass, D, mc);
    out.D.l.x = D.l.x, out.D.l.y = D.l.y, out.D.l.z = D.l.z, out.D.h.x = D.h.x, out.D.h.y = D.h.y, out.D.h.z = D.h.z;
    if constexpr (Gravity) out.mc.x = mc.x, out.mc.y = mc.y, out.mc.z = mc.z;
  }

  /// Outward step of one body. In: the parent's velocity and gravity in its axes. Out: those of the body. Writes u and ṗ of the
  /// joint, Ω and Pb.
  template <PlacementShape S, bool Gravity, class L, class T>
  MOMENTREE_INLINE static void outboard(const L& k, const T& c, const T& s, const Record<T>& w, const T& p, Outboard<T>& out,
                                        T& u, T& pdot, BodySweep<T>& kept) {
    Vector3<T>&v = out.velocity.v, &o = out.velocity.w, &g = out.gravity;
    // (17): into the joint's frame
    detail::cross_placement<S>(k, out.velocity);
    if constexpr (Gravity) detail::rotate_placement<S>(k, g);
    if constexpr (Has<S>::d) v.x = v.x + k.d * o.y, v.y = v.y - k.d * o.x;
    rotate_z(v, c, -s);
    rotate_z(o, c, -s);
    if constexpr (Gravity) rotate_z(g, c, -s);
    // (27): u + ω_z directly, which is all that the outboard joint needs
    const T along = (w.gl.x * v.x + w.ghx * o.x) + (w.gl.y * v.y + w.ghy * o.y) + w.gl.z * v.z;
    T total;
    if constexpr (Armature)
      u = w.u0 - (along + w.ghz * o.z), total = u + o.z;
    else
      total = w.u0 - along, u = total - o.z;
    // (21), only the four components that (20) needs for a rotation about z
    T lx = (w.A.xx * v.x + w.Bxx * o.x) + (w.A.xy * v.y + w.Bxy * o.y) + (w.A.xz * v.z + w.l.x);
    T ly = (w.A.xy * v.x + w.Byx * o.x) + (w.A.yy * v.y + w.Byy * o.y) + (w.A.yz * v.z + w.l.y);
    T hx = (w.Bxx * v.x + w.Jxx * o.x) + (w.Byx * v.y + w.Jxy * o.y) + (w.Bzx * v.z + w.hx);
    T hy = (w.Bxy * v.x + w.Jxy * o.x) + (w.Byy * v.y + w.Jyy * o.y) + (w.Bzy * v.z + w.hy);
    T scaled(0);  // M̂ E ω_z = scaled · G
    if constexpr (Armature) {
      scaled = w.armature * o.z;
      lx = lx + scaled * w.gl.x, ly = ly + scaled * w.gl.y;
      hx = hx + scaled * w.ghx, hy = hy + scaled * w.ghy;
    }
    // (20): e_z·(Tb − Ω × Pb)
    const T gyroscopic = (v.y * lx - v.x * ly) + (o.y * hx - o.x * hy);
    if constexpr (Gravity)
      pdot = gyroscopic + (w.mc.x * g.y - w.mc.y * g.x);
    else
      pdot = gyroscopic;
    o.z = total;
    T lz = (w.A.xz * v.x + w.Bzx * o.x) + (w.A.yz * v.y + w.Bzy * o.y) + (w.A.zz * v.z + w.l.z), hz = p;
    if constexpr (Armature) lz = lz + scaled * w.gl.z, hz = w.hz + (w.armature * along + scaled * w.ghz);
    kept = {out.velocity, {{lx, ly, lz}, {hx, hy, hz}}};
  }

  /// The same for a body on the ground, which does not move: u = u0, Pb = D̂, Ω = u e_z.
  template <bool Gravity, class L, class T>
  MOMENTREE_INLINE static void outboard_root(const L& k, const T& c, const T& s, const Record<T>& w, const T& p, Outboard<T>& out,
                                             T& u, T& pdot, BodySweep<T>& kept) {
    Vector3<T>& g = out.gravity;
    const T o(0), total = w.u0;
    u = total;
    if constexpr (Gravity) {
      rotate_z(g, k.cos_b, -k.sin_b);
      rotate_x(g, k.cos_a, -k.sin_a);
      rotate_z(g, c, -s);
      pdot = w.mc.x * g.y - w.mc.y * g.x;
    } else {
      pdot = o;
    }
    out.velocity = {{o, o, o}, {o, o, total}};
    T hz = p;
    if constexpr (Armature) hz = w.hz;
    kept = {out.velocity, {w.l, {w.hx, w.hy, hz}}};
  }

  // Velocities as the state: the two outward passes. The inward pass is the step above, with a bias.

  /// (17), and the acceleration of the bias Ω × E u. In: the parent's velocity. Out: that of the body.
  template <PlacementShape S, class L, class T>
  MOMENTREE_INLINE static void velocity_outboard(const L& k, const T& c, const T& s, const T& u, Motion<T>& a, Motion<T>& bias) {
    detail::cross_placement<S>(k, a);
    detail::cross_joint_outboard<S>(k, c, s, a);
    put({{u * a.v.y, -(u * a.v.x), T(0)}, {u * a.w.y, -(u * a.w.x), T(0)}}, bias);
    a.w.z = a.w.z + u;
  }
  /// (39), (47), with `w` as the inward step left it. In: the parent's acceleration. Out: that of the body in `a`, u̇ in `udot`,
  /// a′ in `approach`.
  template <PlacementShape S, class L, class T>
  MOMENTREE_INLINE static void acceleration_outboard(const L& k, const T& c, const T& s, const Record<T>& w,
                                                     const Motion<T>& bias, Motion<T>& a, T& udot, Motion<T>& approach) {
    Vector3<T>&v = a.v, &o = a.w;
    detail::cross_placement<S>(k, a);
    detail::cross_joint_outboard<S>(k, c, s, a);
    v.x = v.x + bias.v.x, v.y = v.y + bias.v.y, o.x = o.x + bias.w.x, o.y = o.y + bias.w.y;
    put(a, approach);
    const T along = (w.gl.x * v.x + w.ghx * o.x) + (w.gl.y * v.y + w.ghy * o.y) + w.gl.z * v.z;
    T total;
    if constexpr (Armature)
      udot = w.u0 - (along + w.ghz * o.z), total = udot + o.z;
    else
      total = w.u0 - along, udot = total - o.z;
    o.z = total;
  }

  /// F += M̂ a for an acceleration without z components.
  template <class T>
  MOMENTREE_INLINE static void add_reduced_bias(const Record<T>& w, const Motion<T>& bias, Force<T>& F) {
    const Vector3<T>&v = bias.v, &o = bias.w;
    F.l.x = F.l.x + ((w.A.xx * v.x + w.Bxx * o.x) + (w.A.xy * v.y + w.Bxy * o.y));
    F.l.y = F.l.y + ((w.A.xy * v.x + w.Byx * o.x) + (w.A.yy * v.y + w.Byy * o.y));
    F.l.z = F.l.z + ((w.A.xz * v.x + w.Bzx * o.x) + (w.A.yz * v.y + w.Bzy * o.y));
    F.h.x = F.h.x + ((w.Bxx * v.x + w.Jxx * o.x) + (w.Byx * v.y + w.Jxy * o.y));
    F.h.y = F.h.y + ((w.Bxy * v.x + w.Jxy * o.x) + (w.Byy * v.y + w.Jyy * o.y));
    if constexpr (Armature) F.h.z = F.h.z + w.armature * ((w.gl.x * v.x + w.ghx * o.x) + (w.gl.y * v.y + w.ghy * o.y));
  }

  // Second recursion.

  /// (45): a wrench, to the parent's frame.
  template <PlacementShape S, class T>
  MOMENTREE_INLINE static void cross_inboard(const LinkConstants& k, const T& c, const T& s, Force<T>& W) {
    rotate_z(W.l, c, s);
    rotate_z(W.h, c, s);
    if constexpr (Has<S>::d) W.h.x = W.h.x - k.d * W.l.y, W.h.y = W.h.y + k.d * W.l.x;
    if constexpr (Has<S>::right) {
      W = {{W.l.x, -W.l.z, W.l.y}, {W.h.x, -W.h.z, W.h.y}};
    } else if constexpr (!Has<S>::parallel) {
      rotate_x(W.l, k.cos_a, k.sin_a);
      rotate_x(W.h, k.cos_a, k.sin_a);
    }
    if constexpr (Has<S>::beta) {
      rotate_z(W.l, k.cos_b, k.sin_b);
      rotate_z(W.h, k.cos_b, k.sin_b);
    }
    if constexpr (Has<S>::any_offset)
      shift(W, k.r);
    else if constexpr (Has<S>::a)
      W.h.y = W.h.y - k.r.x * W.l.z, W.h.z = W.h.z + k.r.x * W.l.y;
  }
  /// (39), (47). In: Ω̇ of the parent; `udot` = Mj⁻¹ (τ − Eᵀ W) − Gᵀ bias; `velocity` = Ω of the body. Out: Ω̇ of the body in
  /// `a`, u̇ in `udot`, a′ in `approach`. Accelerations are less gravity.
  template <PlacementShape S, class T>
  MOMENTREE_INLINE static void rate_outboard(const LinkConstants& k, const T& c, const T& s, const Record<T>& w,
                                             const Motion<T>& velocity, const T& u, T& udot, Motion<T>& a, Motion<T>& approach) {
    constexpr bool rotates_first = one_world_at_a_time<T>, shifts = Has<S>::d;
    Vector3<T>&v = a.v, &o = a.w;
    detail::cross_placement<S>(k, a);
    const auto cross_joint = [&]() MOMENTREE_INLINE_LAMBDA {
      if constexpr (shifts) v.x = v.x + k.d * o.y, v.y = v.y - k.d * o.x;
      rotate_z(v, c, -s);
      rotate_z(o, c, -s);
    };
    // u̇ + ω̇_z directly, which is all that the outboard joint needs; G is transformed to the parent's side to shorten the
    // dependency chain.
    detail::RevoluteColumn<T> g{w.gl.x, w.gl.y, w.gl.z, w.ghx, w.ghy};
    if constexpr (rotates_first)
      detail::cross_z<shifts>(g, c, s, k.d);
    else
      cross_joint();
    const T along = (g.lx * v.x + g.hx * o.x) + (g.ly * v.y + g.hy * o.y) + g.lz * v.z;
    T total;
    if constexpr (Armature)
      udot = udot - (along + w.ghz * o.z), total = udot + o.z;
    else
      total = udot - along, udot = total - o.z;
    if constexpr (rotates_first) cross_joint();
    v.x = v.x + u * velocity.v.y, v.y = v.y - u * velocity.v.x;
    o.x = o.x + u * velocity.w.y, o.y = o.y - u * velocity.w.x;
    put(a, approach);
    o.z = total;
  }

 private:
  // (23): the children's contributions and, in the equations of accelerations, the body's own.
  template <Children N, class T>
  MOMENTREE_INLINE static T remainder(const T& first, const T& others, NoBias::None) {
    return alone<N>(first, others);
  }
  template <Children N, class T>
  MOMENTREE_INLINE static T remainder(const T& first, const T& others, const T& own) {
    return with<N>(first, others, own);
  }

  // (22), (23): the children's contributions plus the body's own; for a leaf the latter alone.
  template <Children N, class T, class C>
  MOMENTREE_INLINE static T with(const T& first, const T& others, const C& own) {
    if constexpr (N == Children::none)
      return T(own);
    else
      return alone<N>(first, others) + own;
  }
  template <Children N, class T>
  MOMENTREE_INLINE static T alone(const T& first, const T& others) {
    if constexpr (N == Children::none)
      return T(0);
    else if constexpr (N == Children::one)
      return first;
    else
      return first + others;
  }

  // (25), M̂ = Mb − G (Mb E)ᵀ, and the part of (16) up to the parent's side of the joint. Block by block, so that few values are
  // live at a time; writes the entries that the outward step reads to the record.
  template <bool Shifts, bool CrossesZ, Children N, class L, class T>
  MOMENTREE_INLINE static void reduce_mass(const L& k, const T& c, const T& s, const detail::RevoluteColumn<T>& e,
                                           const detail::RevoluteColumn<T>& g, const SpatialMass<T>& in,
                                           const SpatialMass<T>& others, detail::ReducedMass<T>& m, Record<T>& w) {
    const auto by = [&]() MOMENTREE_INLINE_LAMBDA {
      if constexpr (CrossesZ)
        return PlaneRotation<T>(c, s);
      else
        return nullptr;
    }();
    constexpr bool leaf = N == Children::none;
    const detail::ConstantOf<L> d = k.d;
    const auto& b = k.body;
    const auto cross = [&](auto f) MOMENTREE_INLINE_LAMBDA {
      if constexpr (CrossesZ) f(by);
    };
    detail::PlaneSymmetric<T> A;  // rotated but not shifted, like B
    detail::PlaneMatrix<T> B, slid;
    detail::PlaneVector<T> Az;
    m.A = {with<N>(in.A.xx, others.A.xx, b.m), alone<N>(in.A.xy, others.A.xy), with<N>(in.A.yy, others.A.yy, b.m)};
    m.A.xx -= e.lx * g.lx, m.A.xy -= e.lx * g.ly, m.A.yy -= e.ly * g.ly;
    w.A.xx = m.A.xx, w.A.xy = m.A.xy, w.A.yy = m.A.yy;
    cross([&](const auto& turned) MOMENTREE_INLINE_LAMBDA {
      rotate_block(m.A.xx, m.A.xy, m.A.yy, turned);
      A = m.A;
    });
    m.B = {alone<N>(in.B.xx, others.B.xx), with<N>(in.B.xy, others.B.xy, b.mc.z), with<N>(in.B.yx, others.B.yx, -b.mc.z),
           alone<N>(in.B.yy, others.B.yy)};
    m.B.xx -= e.hx * g.lx, m.B.xy -= e.hy * g.lx, m.B.yx -= e.hx * g.ly, m.B.yy -= e.hy * g.ly;
    w.Bxx = m.B.xx, w.Bxy = m.B.xy, w.Byx = m.B.yx, w.Byy = m.B.yy;
    cross([&](const auto& turned) MOMENTREE_INLINE_LAMBDA {
      B = detail::cross_z<Shifts>(m.B, A, turned, d);
      slid = m.B;
    });
    m.J = {with<N>(in.J.xx, others.J.xx, b.J.xx), with<N>(in.J.xy, others.J.xy, b.J.xy), with<N>(in.J.yy, others.J.yy, b.J.yy)};
    m.J.xx -= e.hx * g.hx, m.J.xy -= e.hx * g.hy, m.J.yy -= e.hy * g.hy;
    w.Jxx = m.J.xx, w.Jxy = m.J.xy, w.Jyy = m.J.yy;
    cross([&](const auto& turned) MOMENTREE_INLINE_LAMBDA { detail::cross_z<Shifts>(m.J, slid, B, turned, d); });
    m.Az = {alone<N>(in.A.xz, others.A.xz), alone<N>(in.A.yz, others.A.yz)};
    if constexpr (!leaf) m.Az.x -= e.lx * g.lz, m.Az.y -= e.ly * g.lz;
    w.A.xz = m.Az.x, w.A.yz = m.Az.y;
    cross([&](const auto&) MOMENTREE_INLINE_LAMBDA {
      if constexpr (!leaf) rotate(m.Az.x, m.Az.y, c, s);
      Az = m.Az;
    });
    m.Bz = {with<N>(in.B.zx, others.B.zx, b.mc.y), with<N>(in.B.zy, others.B.zy, -b.mc.x)};
    if constexpr (!leaf) m.Bz.x -= e.hx * g.lz, m.Bz.y -= e.hy * g.lz;
    w.Bzx = m.Bz.x, w.Bzy = m.Bz.y;
    cross([&](const auto&) MOMENTREE_INLINE_LAMBDA {
      rotate(m.Bz.x, m.Bz.y, c, s);
      if constexpr (Shifts && !leaf) m.Bz.x = m.Bz.x - d * Az.y, m.Bz.y = m.Bz.y + d * Az.x;
    });
    m.Azz = with<N>(in.A.zz, others.A.zz, b.m);
    if constexpr (!leaf) m.Azz -= e.lz * g.lz;
  }

  // (16) from the parent's side of the joint to the parent's frame. With armature, M̂ E and its last entry are not zero.
  template <PlacementShape S, class L, class T, class Column, class Last>
  MOMENTREE_INLINE static void mass_inboard(const L& k, const detail::ReducedMass<T>& m, const Column& z, const Last& zz,
                                            SpatialMass<T>& out) {
    using detail::Twist;
    constexpr Twist twist = Has<S>::right ? Twist::right : Has<S>::parallel ? Twist::none : Twist::any;
    SpatialMass<T> M;
    M.A = detail::rotate_x<twist>(k, m.A, m.Az, m.Azz);
    if constexpr (Armature) {
      M.B = detail::rotate_x<twist>(k, m.B, m.Bz, Vector3<T>{z.lx, z.ly, z.lz});
      M.J = detail::rotate_x<twist>(k, m.J, detail::PlaneVector<T>{z.hx, z.hy}, zz);
    } else {
      M.B = detail::rotate_x<twist>(k, m.B, m.Bz);
      M.J = detail::rotate_x<twist>(k, m.J);
    }
    if constexpr (Has<S>::beta) rotate_z(M, k.cos_b, k.sin_b);
    if constexpr (Has<S>::any_offset)
      shift(M, k.r);
    else if constexpr (Has<S>::a)
      detail::shift_x<Armature ? Twist::any : twist>(M, k.r.x);
    // One by one: compilers split copies of whole structs of packs into bytes.
    out.A.xx = M.A.xx, out.A.yy = M.A.yy, out.A.zz = M.A.zz, out.A.xy = M.A.xy, out.A.xz = M.A.xz, out.A.yz = M.A.yz;
    out.B.xx = M.B.xx, out.B.xy = M.B.xy, out.B.xz = M.B.xz, out.B.yx = M.B.yx, out.B.yy = M.B.yy, out.B.yz = M.B.yz;
    out.B.zx = M.B.zx, out.B.zy = M.B.zy, out.B.zz = M.B.zz;
    out.J.xx = M.J.xx, out.J.yy = M.J.yy, out.J.zz = M.J.zz, out.J.xy = M.J.xy, out.J.xz = M.J.xz, out.J.yz = M.J.yz;
  }
  template <PlacementShape S, bool Gravity, class L, class T>
  MOMENTREE_INLINE static void momentum_inboard(const L& k, const detail::ConstantOf<L>& mass, Force<T>& D, Vector3<T>& mc) {
    const auto each = [&](auto rotate) MOMENTREE_INLINE_LAMBDA {
      rotate(D.l), rotate(D.h);
      if constexpr (Gravity) rotate(mc);
    };
    if constexpr (Has<S>::right)
      each([](Vector3<T>& x) MOMENTREE_INLINE_LAMBDA { x = {x.x, -x.z, x.y}; });
    else if constexpr (!Has<S>::parallel)
      each([&](Vector3<T>& x) MOMENTREE_INLINE_LAMBDA { rotate_x(x, k.cos_a, k.sin_a); });
    if constexpr (Has<S>::beta) each([&](Vector3<T>& x) MOMENTREE_INLINE_LAMBDA { rotate_z(x, k.cos_b, k.sin_b); });
    if constexpr (Has<S>::any_offset)
      shift(D, k.r);
    else if constexpr (Has<S>::a)
      D.h.y = D.h.y - k.r.x * D.l.z, D.h.z = D.h.z + k.r.x * D.l.y;
    else
      static_assert(!Has<S>::parallel, "a joint on its parent's axis has no kernel of its own");
    if constexpr (Gravity) {
      if constexpr (Has<S>::any_offset || Has<S>::a) mc.x += mass * k.r.x;
      if constexpr (Has<S>::any_offset || Has<S>::d) mc.y += mass * k.r.y, mc.z += mass * k.r.z;
    }
  }
};

using RevoluteSteps = RevoluteStepsOf<false>;
using ArmatureSteps = RevoluteStepsOf<true>;

}  // namespace momentree
