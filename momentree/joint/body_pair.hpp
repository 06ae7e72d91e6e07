#pragma once
// Two isomorphic branches of one mechanism, such as the legs of a robot, in the two lanes of one scalar.
#include <momentree/joint/link_constants.hpp>
#include <momentree/joint/pass_data.hpp>
#include <momentree/math/pack.hpp>

namespace momentree {

/// True if the target has SIMD lanes for two doubles. Otherwise paired branches are not searched for.
#if defined(__SSE2__) || defined(__aarch64__) || defined(__wasm_simd128__)
inline constexpr bool has_pair_lanes = true;
#else
inline constexpr bool has_pair_lanes = false;
#endif

/// The same quantity of two bodies. Its lanes are bodies, not worlds, so its type differs from that of the packs of worlds.
using BodyPair = Pack<double, 2, static_cast<Isa>(0xff)>;
MOMENTREE_INLINE BodyPair pairs(double first, double second) { return BodyPair(BodyPair::Vector{first, second}); }
MOMENTREE_INLINE Vector3<BodyPair> pairs(const Vec3& first, const Vec3& second) {
  return {pairs(first.x, second.x), pairs(first.y, second.y), pairs(first.z, second.z)};
}

/// The most specific shape that covers both links.
constexpr PlacementShape common_shape(PlacementShape a, PlacementShape b) {
  if (a == b) return a;
  return a < PlacementShape::screw || b < PlacementShape::screw ? PlacementShape::general : PlacementShape::screw;
}

/// The constants of two links, one per lane, as read by the steps.
struct PairedLinks {
  struct Body {
    BodyPair m;
    Vector3<BodyPair> mc;
    Symmetric3<BodyPair> J;
  };
  BodyPair cos_a, sin_a, cs_a, ss_a;
  Vector3<BodyPair> r;
  BodyPair d, cos_b, sin_b;
  Body body;
  PlacementShape shape;

  MOMENTREE_INLINE PairedLinks(const LinkConstants& k, const LinkConstants& l)
      : cos_a(pairs(k.cos_a, l.cos_a)),
        sin_a(pairs(k.sin_a, l.sin_a)),
        cs_a(pairs(k.cs_a, l.cs_a)),
        ss_a(pairs(k.ss_a, l.ss_a)),
        r(pairs(k.r, l.r)),
        d(pairs(k.d, l.d)),
        cos_b(pairs(k.cos_b, l.cos_b)),
        sin_b(pairs(k.sin_b, l.sin_b)),
        body{pairs(k.body.m, l.body.m),
             pairs(k.body.mc, l.body.mc),
             {pairs(k.body.J.xx, l.body.J.xx), pairs(k.body.J.yy, l.body.J.yy), pairs(k.body.J.zz, l.body.J.zz),
              pairs(k.body.J.xy, l.body.J.xy), pairs(k.body.J.xz, l.body.J.xz), pairs(k.body.J.yz, l.body.J.yz)}},
        shape(common_shape(k.shape, l.shape)) {}
};

// Splits the two lanes between the two bodies. Components are stored one by one, because a wider load of data that was just
// written stalls.

MOMENTREE_INLINE void part(const BodyPair& from, double& one, double& other) { one = from[0], other = from[1]; }
MOMENTREE_INLINE void part(const Vector3<BodyPair>& from, Vec3& one, Vec3& other) {
  part(from.x, one.x, other.x), part(from.y, one.y, other.y), part(from.z, one.z, other.z);
}
MOMENTREE_INLINE void part(const Symmetric3<BodyPair>& from, Sym3& one, Sym3& other) {
  part(from.xx, one.xx, other.xx), part(from.yy, one.yy, other.yy), part(from.zz, one.zz, other.zz);
  part(from.xy, one.xy, other.xy), part(from.xz, one.xz, other.xz), part(from.yz, one.yz, other.yz);
}
MOMENTREE_INLINE void part(const Matrix3<BodyPair>& from, Mat3& one, Mat3& other) {
  part(from.xx, one.xx, other.xx), part(from.xy, one.xy, other.xy), part(from.xz, one.xz, other.xz);
  part(from.yx, one.yx, other.yx), part(from.yy, one.yy, other.yy), part(from.yz, one.yz, other.yz);
  part(from.zx, one.zx, other.zx), part(from.zy, one.zy, other.zy), part(from.zz, one.zz, other.zz);
}
MOMENTREE_INLINE void part(const Motion<BodyPair>& from, Motion<double>& one, Motion<double>& other) {
  part(from.v, one.v, other.v), part(from.w, one.w, other.w);
}
MOMENTREE_INLINE void part(const Force<BodyPair>& from, Force<double>& one, Force<double>& other) {
  part(from.l, one.l, other.l), part(from.h, one.h, other.h);
}
MOMENTREE_INLINE void part(const SpatialMass<BodyPair>& from, SpatialMass<double>& one, SpatialMass<double>& other) {
  part(from.A, one.A, other.A), part(from.B, one.B, other.B), part(from.J, one.J, other.J);
}
MOMENTREE_INLINE void part(const Inboard<BodyPair>& from, Inboard<double>& one, Inboard<double>& other) {
  part(from.M, one.M, other.M), part(from.D, one.D, other.D), part(from.mc, one.mc, other.mc);
}
MOMENTREE_INLINE void part(const BodySweep<BodyPair>& from, BodySweep<double>& one, BodySweep<double>& other) {
  part(from.velocity, one.velocity, other.velocity), part(from.articulated, one.articulated, other.articulated);
}

}  // namespace momentree
