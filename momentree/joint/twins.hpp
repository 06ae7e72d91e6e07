#pragma once
// Two branches of one mechanism that are built alike, as the legs of a robot are, in the two lanes of one scalar.
#include <momentree/joint/link.hpp>
#include <momentree/math/pack.hpp>

namespace momentree {

/// Whether this is compiled for processors with lanes for two doubles. Where not, nobody looks for twins.
#if defined(__SSE2__) || defined(__aarch64__) || defined(__wasm_simd128__)
inline constexpr bool has_twin_lanes = true;
#else
inline constexpr bool has_twin_lanes = false;
#endif

/// The same number of two bodies. Its lanes are no worlds, so it is of another type than those packs.
using Twins = Pack<double, 2, static_cast<Isa>(0xff)>;
MOMENTREE_INLINE Twins twins(double first, double second) { return Twins(Twins::Vector{first, second}); }
MOMENTREE_INLINE Vector3<Twins> twins(const Vec3& first, const Vec3& second) {
  return {twins(first.x, second.x), twins(first.y, second.y), twins(first.z, second.z)};
}

/// A shape that has all that both links have.
constexpr LinkShape common_shape(LinkShape a, LinkShape b) {
  if (a == b) return a;
  return a < LinkShape::screw || b < LinkShape::screw ? LinkShape::general : LinkShape::screw;
}

/// The constants of two links, as steps read them.
struct TwinLinks {
  struct Body {
    Twins m;
    Vector3<Twins> mc;
    Symmetric3<Twins> J;
  };
  Twins cos_a, sin_a, cs_a, ss_a;
  Vector3<Twins> r;
  Twins d, cos_b, sin_b;
  Body body;
  LinkShape shape;

  MOMENTREE_INLINE TwinLinks(const Link& k, const Link& l)
      : cos_a(twins(k.cos_a, l.cos_a)),
        sin_a(twins(k.sin_a, l.sin_a)),
        cs_a(twins(k.cs_a, l.cs_a)),
        ss_a(twins(k.ss_a, l.ss_a)),
        r(twins(k.r, l.r)),
        d(twins(k.d, l.d)),
        cos_b(twins(k.cos_b, l.cos_b)),
        sin_b(twins(k.sin_b, l.sin_b)),
        body{twins(k.body.m, l.body.m),
             twins(k.body.mc, l.body.mc),
             {twins(k.body.J.xx, l.body.J.xx), twins(k.body.J.yy, l.body.J.yy), twins(k.body.J.zz, l.body.J.zz),
              twins(k.body.J.xy, l.body.J.xy), twins(k.body.J.xz, l.body.J.xz), twins(k.body.J.yz, l.body.J.yz)}},
        shape(common_shape(k.shape, l.shape)) {}
};

// What stands in the two lanes, to the two bodies; number by number, as it was written, or it would be waited for.

MOMENTREE_INLINE void part(const Twins& from, double& one, double& other) { one = from[0], other = from[1]; }
MOMENTREE_INLINE void part(const Vector3<Twins>& from, Vec3& one, Vec3& other) {
  part(from.x, one.x, other.x), part(from.y, one.y, other.y), part(from.z, one.z, other.z);
}
MOMENTREE_INLINE void part(const Symmetric3<Twins>& from, Sym3& one, Sym3& other) {
  part(from.xx, one.xx, other.xx), part(from.yy, one.yy, other.yy), part(from.zz, one.zz, other.zz);
  part(from.xy, one.xy, other.xy), part(from.xz, one.xz, other.xz), part(from.yz, one.yz, other.yz);
}
MOMENTREE_INLINE void part(const Matrix3<Twins>& from, Mat3& one, Mat3& other) {
  part(from.xx, one.xx, other.xx), part(from.xy, one.xy, other.xy), part(from.xz, one.xz, other.xz);
  part(from.yx, one.yx, other.yx), part(from.yy, one.yy, other.yy), part(from.yz, one.yz, other.yz);
  part(from.zx, one.zx, other.zx), part(from.zy, one.zy, other.zy), part(from.zz, one.zz, other.zz);
}
MOMENTREE_INLINE void part(const Motion<Twins>& from, Motion<double>& one, Motion<double>& other) {
  part(from.v, one.v, other.v), part(from.w, one.w, other.w);
}
MOMENTREE_INLINE void part(const Force<Twins>& from, Force<double>& one, Force<double>& other) {
  part(from.l, one.l, other.l), part(from.h, one.h, other.h);
}
MOMENTREE_INLINE void part(const SpatialMass<Twins>& from, SpatialMass<double>& one, SpatialMass<double>& other) {
  part(from.A, one.A, other.A), part(from.B, one.B, other.B), part(from.J, one.J, other.J);
}
MOMENTREE_INLINE void part(const Inboard<Twins>& from, Inboard<double>& one, Inboard<double>& other) {
  part(from.M, one.M, other.M), part(from.D, one.D, other.D), part(from.mc, one.mc, other.mc);
}
MOMENTREE_INLINE void part(const BodySweep<Twins>& from, BodySweep<double>& one, BodySweep<double>& other) {
  part(from.velocity, one.velocity, other.velocity), part(from.articulated, one.articulated, other.articulated);
}

}  // namespace momentree
