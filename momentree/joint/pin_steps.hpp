#pragma once
// Steps of the two sweeps across a pin without rotor: (22)–(26) and (16) inboard, (17), (27), (21), (20) outboard, as one piece
// each. What reduction about z leaves has zeros, and so has the placement of most links.
#include <momentree/joint/screw_kernels.hpp>

namespace momentree {

/// What reduction about z leaves: M̂ E = 0, so B has no z column and J no z row; D̂·E = p; G·E = 1.
template <class T>
struct PinRecord {
  Symmetric3<T> A;
  T Bxx, Bxy, Byx, Byy, Bzx, Bzy, Jxx, Jxy, Jyy;
  Vector3<T> l;  // D̂
  T hx, hy;
  Vector3<T> gl;  // G
  T ghx, ghy;
  T u0, inverse_mass;
  Vector3<T> mc;
};

namespace detail {

/// (16), the turn about z and the slide by d along it, of what has no z column in B and no z row in J.
template <bool Slides, class T>
MOMENTREE_INLINE void turn_reduced_z(SpatialMass<T>& M, const T& c, const T& s, double d) {
  const Turn<T> by(c, s);
  turn_block(M.A.xx, M.A.xy, M.A.yy, by);
  turn(M.A.xz, M.A.yz, c, s);
  turn(M.B.zx, M.B.zy, c, s);
  turn_block(M.J.xx, M.J.xy, M.J.yy, by);
  if constexpr (!Slides) {
    turn_block(M.B.xx, M.B.xy, M.B.yx, M.B.yy, by);
  } else {
    // B ← B − A r̃, J ← J + r̃ B_new + (r̃ B_old)ᵀ with r = d e_z, merged with the turn of B.
    const T p = M.B.xx - M.B.yy, q = M.B.xy + M.B.yx;
    const T t = by.ss * p + by.cs * q, o = by.cs * p - by.ss * q;
    const T yy = M.B.yy + t, slid = t + d * M.A.xy;
    M.B.xx = M.B.xx - slid, M.B.yy = M.B.yy + slid;
    const T xy = M.B.xy + o, yx = M.B.yx + o;
    M.B.xy = xy + d * M.A.xx, M.B.yx = yx - d * M.A.yy;
    M.B.zx = M.B.zx - d * M.A.yz, M.B.zy = M.B.zy + d * M.A.xz;
    M.J.xx = M.J.xx - d * (M.B.yx + yx), M.J.yy = M.J.yy + d * (M.B.xy + xy);
    M.J.xy = M.J.xy + d * (M.B.xx - yy);
  }
}

/// (16), the turn about x by α, of the same; what was zero is filled.
template <class T>
MOMENTREE_INLINE void turn_reduced_x(const Link& k, SpatialMass<T>& M) {
  const double c = k.cos_a, s = k.sin_a;
  const Turn<double> by = Turn<double>::of_products(k.cs_a, k.ss_a);
  turn_block(M.A.yy, M.A.yz, M.A.zz, by);
  turn(M.A.xy, M.A.xz, c, s);
  const T a = c * M.B.yy - s * M.B.zy, b = s * M.B.yy + c * M.B.zy;  // rows y, z of the y column
  M.B.yy = c * a, M.B.yz = s * a, M.B.zy = c * b, M.B.zz = s * b;
  M.B.xz = s * M.B.xy;
  M.B.xy = c * M.B.xy;
  turn(M.B.yx, M.B.zx, c, s);
  M.J.zz = by.ss * M.J.yy;
  M.J.yz = by.cs * M.J.yy;
  M.J.yy = (1 - by.ss) * M.J.yy;
  M.J.xz = s * M.J.xy;
  M.J.xy = c * M.J.xy;
}
/// The same by 90°: components change places, and stay zero where they come from zeros.
template <class T>
MOMENTREE_INLINE void turn_reduced_right(SpatialMass<T>& M) {
  const T Ayy = M.A.yy, Axy = M.A.xy, Byx = M.B.yx;
  M.A.yy = M.A.zz, M.A.zz = Ayy, M.A.yz = -M.A.yz;
  M.A.xy = -M.A.xz, M.A.xz = Axy;
  M.B.yx = -M.B.zx, M.B.zx = Byx;
  M.B.xz = M.B.xy, M.B.yz = -M.B.zy, M.B.zz = M.B.yy;
  M.B.xy = M.B.yy = M.B.zy = T(0);
  M.J.zz = M.J.yy, M.J.xz = M.J.xy;
  M.J.yy = M.J.xy = M.J.yz = T(0);
}

/// (16), the shift by a along x. `Zeros`: the column of B and the row of J that are zero before: none, those of y, those of z.
enum class Zeros { none, y, z };
template <Zeros Z, class T>
MOMENTREE_INLINE void shift_x(SpatialMass<T>& M, double a) {
  const Symmetric3<T>& A = M.A;
  if constexpr (Z == Zeros::y) {
    M.B.xy = -(a * A.xz), M.B.yy = -(a * A.yz), M.B.zy = -(a * A.zz);
    const T yz = M.B.yz;
    M.B.xz = M.B.xz + a * A.xy, M.B.yz = M.B.yz + a * A.yy, M.B.zz = M.B.zz + a * A.yz;
    M.J.yy = -(a * M.B.zy), M.J.zz = M.J.zz + a * (yz + M.B.yz);
    M.J.xy = -(a * M.B.zx), M.J.xz = M.J.xz + a * M.B.yx, M.J.yz = -(a * M.B.zz);
  } else {
    const T zy = M.B.zy, yy = M.B.yy;
    M.B.xy = M.B.xy - a * A.xz, M.B.yy = M.B.yy - a * A.yz, M.B.zy = M.B.zy - a * A.zz;
    M.J.yy = M.J.yy - a * (zy + M.B.zy);
    M.J.xy = M.J.xy - a * M.B.zx;
    if constexpr (Z == Zeros::z) {
      M.B.xz = a * A.xy, M.B.yz = a * A.yy, M.B.zz = a * A.yz;
      M.J.zz = a * M.B.yz, M.J.xz = a * M.B.yx, M.J.yz = a * (yy - M.B.zz);
    } else {
      const T yz = M.B.yz;
      M.B.xz = M.B.xz + a * A.xy, M.B.yz = M.B.yz + a * A.yy, M.B.zz = M.B.zz + a * A.yz;
      M.J.zz = M.J.zz + a * (yz + M.B.yz);
      M.J.xz = M.J.xz + a * M.B.yx;
      M.J.yz = M.J.yz + a * (yy - M.B.zz);
    }
  }
}

}  // namespace detail

/// (16) for what a pin without rotor has reduced: the zero rows stay zero while turning about z.
template <class T, bool Aligned>
struct PinCrossing : ScrewCrossing<T, Aligned> {
  using ScrewCrossing<T, Aligned>::inboard;
  MOMENTREE_INLINE void inboard(SpatialMass<T>& M) const {
    const Link& k = this->link;
    detail::turn_reduced_z<false>(M, this->c, this->s, 0);
    detail::turn_reduced_x(k, M);
    if constexpr (!Aligned) turn_z(M, k.cos_b, k.sin_b);
    shift(M, k.r);
  }
};

struct PinSteps {
  /// Whether the mass is turned about z before it is reduced, while 1 / Mj is in flight: more operations, but for one world at a
  /// time less waiting. E, and what is about z, are the same on both sides of the turn. Records are then those of the parent's
  /// side: not where they are kept for others.
  template <class T, bool Keep>
  static constexpr bool late = std::is_same_v<T, double> && !Keep;

  /// What of a link's placement a shape has.
  template <LinkShape S>
  struct Has {
    static constexpr bool turn_b = S == LinkShape::general;
    static constexpr bool any_offset = S == LinkShape::general || S == LinkShape::tilted;
    static constexpr bool right = S >= LinkShape::right && S <= LinkShape::right_meeting;
    static constexpr bool parallel = S >= LinkShape::parallel;
    static constexpr bool a =
        S == LinkShape::screw || S == LinkShape::screw_a || S == LinkShape::right || S == LinkShape::right_a || parallel;
    static constexpr bool d = S == LinkShape::screw || S == LinkShape::screw_d || S == LinkShape::right ||
                              S == LinkShape::right_d || S == LinkShape::parallel;
  };

  /// In: what the children reduced, in the body's frame; `tip`: nothing. Out: what the parent gets, in its frame; `root`: nobody
  /// asks for it. `mass`: of the body and all outboard of it.
  template <LinkShape S, bool Gravity, bool Keep, class T>
  MOMENTREE_INLINE static void inboard(const Link& k, double mass, const T& c, const T& s, const T& p, bool tip, bool root,
                                       Inboard<T>& in, PinRecord<T>& w) {
    SpatialMass<T>& M = in.M;
    Force<T>& D = in.D;
    if (!late<T, Keep> && tip) {
      M = rigid_mass<T>(k.body);
      D = {};
      if constexpr (Gravity) in.mc = {T(k.body.mc.x), T(k.body.mc.y), T(k.body.mc.z)};
    } else {
      if (tip) in = {};
      add_rigid_mass(M, k.body);  // (22), (23)
      if constexpr (Gravity) in.mc.x += k.body.mc.x, in.mc.y += k.body.mc.y, in.mc.z += k.body.mc.z;
    }
    const T inverse = T(1) / M.J.zz, u = p - D.h.z;           // (24)
    const auto cross_joint = [&]() MOMENTREE_INLINE_LAMBDA {  // (16), as far as the parent's side of the joint
      if constexpr (late<T, Keep>) {
        turn(M.B.xz, M.B.yz, c, s);
        turn(M.J.xz, M.J.yz, c, s);
        if constexpr (Has<S>::d) M.J.xz = M.J.xz - k.d * M.B.yz, M.J.yz = M.J.yz + k.d * M.B.xz;
      }
      detail::turn_reduced_z<Has<S>::d>(M, c, s, k.d);
      turn_z(D.l, c, s);
      turn_z(D.h, c, s);
      if constexpr (Gravity) turn_z(in.mc, c, s);
      if constexpr (Has<S>::d) D.h.x = D.h.x - k.d * D.l.y, D.h.y = D.h.y + k.d * D.l.x;
    };
    if constexpr (late<T, Keep>) cross_joint();
    reduce(p, u, inverse, M, D, w);  // (25), (26)
    if constexpr (Gravity) w.mc.x = in.mc.x, w.mc.y = in.mc.y;
    if constexpr (Keep) w.A.zz = M.A.zz, w.l.z = D.l.z, w.inverse_mass = inverse;
    if (!late<T, Keep> && root) return;
    if constexpr (!late<T, Keep>) cross_joint();
    if constexpr (Has<S>::right) {
      detail::turn_reduced_right(M);
      D = {{D.l.x, -D.l.z, D.l.y}, {D.h.x, -D.h.z, D.h.y}};
      if constexpr (Gravity) in.mc = {in.mc.x, -in.mc.z, in.mc.y};
    } else if constexpr (!Has<S>::parallel) {
      detail::turn_reduced_x(k, M);
      turn_x(D.l, k.cos_a, k.sin_a);
      turn_x(D.h, k.cos_a, k.sin_a);
      if constexpr (Gravity) turn_x(in.mc, k.cos_a, k.sin_a);
    }
    if constexpr (Has<S>::turn_b) {
      turn_z(M, k.cos_b, k.sin_b);
      turn_z(D.l, k.cos_b, k.sin_b);
      turn_z(D.h, k.cos_b, k.sin_b);
      if constexpr (Gravity) turn_z(in.mc, k.cos_b, k.sin_b);
    }
    if constexpr (Has<S>::any_offset) {
      shift(M, k.r);
      shift(D, k.r);
    } else if constexpr (Has<S>::a) {
      constexpr auto zeros = Has<S>::right ? detail::Zeros::y : Has<S>::parallel ? detail::Zeros::z : detail::Zeros::none;
      detail::shift_x<zeros>(M, k.r.x);
      D.h.y = D.h.y - k.r.x * D.l.z, D.h.z = D.h.z + k.r.x * D.l.y;
    } else if constexpr (Has<S>::parallel) {
      static_assert(Has<S>::a, "a joint on its parent's axis has no kernel of its own");
    }
    if constexpr (Gravity) {
      if constexpr (Has<S>::any_offset || Has<S>::a) in.mc.x += mass * k.r.x;
      if constexpr (Has<S>::any_offset || Has<S>::d) in.mc.y += mass * k.r.y, in.mc.z += mass * k.r.z;
    }
  }

  /// In: the parent's velocity, and gravity in its axes; out: those of the body. Gives u and ṗ of the joint; if kept, Ω and Pb.
  template <LinkShape S, bool Gravity, bool Keep, class T>
  MOMENTREE_INLINE static void outboard(const Link& k, const T& c, const T& s, const PinRecord<T>& w, const T& p, bool root,
                                        Outboard<T>& out, T& u, T& pdot, BodySweep<T>* kept) {
    Vector3<T>&v = out.velocity.v, &o = out.velocity.w, &g = out.gravity;
    // (17): the way into the joint's frame
    const bool moves = late<T, Keep> || !root;  // else there is no velocity to bring
    if constexpr (Has<S>::any_offset)
      if (moves) shift_outboard(out.velocity, k.r);
    if constexpr (Has<S>::a) v.y = v.y + k.r.x * o.z, v.z = v.z - k.r.x * o.y;
    const auto each = [&](auto turned) MOMENTREE_INLINE_LAMBDA {
      if (moves) turned(v), turned(o);
      if constexpr (Gravity) turned(g);
    };
    if constexpr (Has<S>::turn_b) each([&](Vector3<T>& x) MOMENTREE_INLINE_LAMBDA { turn_z(x, k.cos_b, -k.sin_b); });
    if constexpr (Has<S>::right)
      each([&](Vector3<T>& x) MOMENTREE_INLINE_LAMBDA { x = {x.x, x.z, -x.y}; });
    else if constexpr (!Has<S>::parallel)
      each([&](Vector3<T>& x) MOMENTREE_INLINE_LAMBDA { turn_x(x, k.cos_a, -k.sin_a); });
    const auto cross_joint = [&]() MOMENTREE_INLINE_LAMBDA {
      if constexpr (Has<S>::d) v.x = v.x + k.d * o.y, v.y = v.y - k.d * o.x;
      each([&](Vector3<T>& x) MOMENTREE_INLINE_LAMBDA { turn_z(x, c, -s); });
    };
    if constexpr (!late<T, Keep>) cross_joint();
    // (27): u + ω_z at once, which is all that the next joint asks for
    const T turning = w.u0 - ((w.gl.x * v.x + w.ghx * o.x) + (w.gl.y * v.y + w.ghy * o.y) + w.gl.z * v.z);
    u = turning - o.z;
    // (21), the four components that turning about z asks for
    const T lx = (w.A.xx * v.x + w.Bxx * o.x) + (w.A.xy * v.y + w.Bxy * o.y) + (w.A.xz * v.z + w.l.x);
    const T ly = (w.A.xy * v.x + w.Byx * o.x) + (w.A.yy * v.y + w.Byy * o.y) + (w.A.yz * v.z + w.l.y);
    const T hx = (w.Bxx * v.x + w.Jxx * o.x) + (w.Byx * v.y + w.Jxy * o.y) + (w.Bzx * v.z + w.hx);
    const T hy = (w.Bxy * v.x + w.Jxy * o.x) + (w.Byy * v.y + w.Jyy * o.y) + (w.Bzy * v.z + w.hy);
    // (20): e_z·(Tb − Ω × Pb)
    const T gyroscopic = (v.y * lx - v.x * ly) + (o.y * hx - o.x * hy);
    if constexpr (Gravity)
      pdot = gyroscopic + (w.mc.x * g.y - w.mc.y * g.x);
    else
      pdot = gyroscopic;
    o.z = turning;
    if constexpr (Keep) {
      const T lz = (w.A.xz * v.x + w.Bzx * o.x) + (w.A.yz * v.y + w.Bzy * o.y) + (w.A.zz * v.z + w.l.z);
      *kept = {out.velocity, {{lx, ly, lz}, {hx, hy, p}}};
    }
    if constexpr (late<T, Keep>) cross_joint();
  }

  // The second recursion.

  /// (45): a wrench, to the parent.
  template <LinkShape S, class T>
  MOMENTREE_INLINE static void cross_inboard(const Link& k, const T& c, const T& s, Force<T>& W) {
    turn_z(W.l, c, s);
    turn_z(W.h, c, s);
    if constexpr (Has<S>::d) W.h.x = W.h.x - k.d * W.l.y, W.h.y = W.h.y + k.d * W.l.x;
    if constexpr (Has<S>::right) {
      W = {{W.l.x, -W.l.z, W.l.y}, {W.h.x, -W.h.z, W.h.y}};
    } else if constexpr (!Has<S>::parallel) {
      turn_x(W.l, k.cos_a, k.sin_a);
      turn_x(W.h, k.cos_a, k.sin_a);
    }
    if constexpr (Has<S>::turn_b) {
      turn_z(W.l, k.cos_b, k.sin_b);
      turn_z(W.h, k.cos_b, k.sin_b);
    }
    if constexpr (Has<S>::any_offset)
      shift(W, k.r);
    else if constexpr (Has<S>::a)
      W.h.y = W.h.y - k.r.x * W.l.z, W.h.z = W.h.z + k.r.x * W.l.y;
  }
  /// X Ω̇ of the parent.
  template <LinkShape S, class T>
  MOMENTREE_INLINE static void cross_outboard(const Link& k, const T& c, const T& s, Motion<T>& a) {
    Vector3<T>&v = a.v, &o = a.w;
    if constexpr (Has<S>::any_offset)
      shift_outboard(a, k.r);
    else if constexpr (Has<S>::a)
      v.y = v.y + k.r.x * o.z, v.z = v.z - k.r.x * o.y;
    if constexpr (Has<S>::turn_b) {
      turn_z(v, k.cos_b, -k.sin_b);
      turn_z(o, k.cos_b, -k.sin_b);
    }
    if constexpr (Has<S>::right) {
      a = {{v.x, v.z, -v.y}, {o.x, o.z, -o.y}};
    } else if constexpr (!Has<S>::parallel) {
      turn_x(v, k.cos_a, -k.sin_a);
      turn_x(o, k.cos_a, -k.sin_a);
    }
    if constexpr (Has<S>::d) v.x = v.x + k.d * o.y, v.y = v.y - k.d * o.x;
    turn_z(v, c, -s);
    turn_z(o, c, -s);
  }

  /// (25), (26): Mb E is the third column of the right half; u = p − Eᵀ Db, inverse = 1 / Mj. The record
  /// gets what steps outboard read.
  template <class T>
  MOMENTREE_INLINE static void reduce(const T& p, const T& u, const T& inverse, SpatialMass<T>& M, Force<T>& D, PinRecord<T>& w) {
    const Vector3<T> el{M.B.xz, M.B.yz, M.B.zz};
    const T ex = M.J.xz, ey = M.J.yz;
    const Vector3<T> gl = inverse * el;
    const T gx = inverse * ex, gy = inverse * ey;
    M.A.xx -= el.x * gl.x, M.A.yy -= el.y * gl.y, M.A.zz -= el.z * gl.z;  // (25)
    M.A.xy -= el.x * gl.y, M.A.xz -= el.x * gl.z, M.A.yz -= el.y * gl.z;
    M.B.xx -= ex * gl.x, M.B.yx -= ex * gl.y, M.B.zx -= ex * gl.z;
    M.B.xy -= ey * gl.x, M.B.yy -= ey * gl.y, M.B.zy -= ey * gl.z;
    M.B.xz = T(0), M.B.yz = T(0), M.B.zz = T(0);
    M.J.xx -= ex * gx, M.J.xy -= ex * gy, M.J.yy -= ey * gy;
    M.J.xz = T(0), M.J.yz = T(0), M.J.zz = T(0);
    D.l += u * gl;  // (26)
    D.h = {D.h.x + gx * u, D.h.y + gy * u, p};
    w.A.xx = M.A.xx, w.A.yy = M.A.yy, w.A.xy = M.A.xy, w.A.xz = M.A.xz, w.A.yz = M.A.yz;
    w.Bxx = M.B.xx, w.Bxy = M.B.xy, w.Byx = M.B.yx, w.Byy = M.B.yy, w.Bzx = M.B.zx, w.Bzy = M.B.zy;
    w.Jxx = M.J.xx, w.Jxy = M.J.xy, w.Jyy = M.J.yy;
    w.l.x = D.l.x, w.l.y = D.l.y, w.hx = D.h.x, w.hy = D.h.y;
    w.gl = gl, w.ghx = gx, w.ghy = gy;
    w.u0 = inverse * u;
  }
};

/// Calls f(std::integral_constant<LinkShape, …>{}) for a shape known at run time.
template <class F>
MOMENTREE_INLINE void dispatch_shape(LinkShape shape, F&& f) {
  switch (shape) {
#define MOMENTREE_SHAPE(name) \
  case LinkShape::name: return f(std::integral_constant<LinkShape, LinkShape::name>{});
    MOMENTREE_SHAPE(general)
    MOMENTREE_SHAPE(tilted)
    MOMENTREE_SHAPE(screw)
    MOMENTREE_SHAPE(screw_a)
    MOMENTREE_SHAPE(screw_d)
    MOMENTREE_SHAPE(right)
    MOMENTREE_SHAPE(right_a)
    MOMENTREE_SHAPE(right_d)
    MOMENTREE_SHAPE(right_meeting)
    MOMENTREE_SHAPE(parallel)
    MOMENTREE_SHAPE(parallel_a)
#undef MOMENTREE_SHAPE
  }
}

}  // namespace momentree
