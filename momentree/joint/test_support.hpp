#pragma once
// Random numbers for the joint laws, and distances between results.
#include <array>
#include <cmath>
#include <vector>

#include <momentree/joint/kernels.hpp>
#include <momentree/joint/placement_shapes.hpp>

namespace momentree {

// One draw per statement: compilers evaluate arguments in different orders.
struct Draw {
  unsigned long long state = 88172645463325252ULL;
  double operator()() {  // (−1, 1)
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return static_cast<double>(state >> 11) * (2.0 / 9007199254740992.0) - 1;
  }
  Vec3 vector() {
    const double x = (*this)();
    const double y = (*this)();
    const double z = (*this)();
    return {x, y, z};
  }
};

/// Rotations of a placement: Rz(β) Rx(α) Rz(θ0); β = 0; α = 0, too; and θ0 = 0.
enum class LinkRotation { any, tilted, about_z, none };
inline LinkConstants random_link(Draw& draw, LinkRotation rotation) {
  LinkConstants k;
  const double a = rotation > LinkRotation::tilted ? 0 : 3 * draw();
  const double b = rotation > LinkRotation::any ? 0 : 3 * draw();
  k.angle_0 = rotation == LinkRotation::none ? 0 : 3 * draw();
  k.cos_a = std::cos(a), k.sin_a = std::sin(a), k.cos_b = std::cos(b), k.sin_b = std::sin(b);
  k.cos_0 = std::cos(k.angle_0), k.sin_0 = std::sin(k.angle_0);
  k.r = draw.vector();
  find_rotation(k);
  return k;
}
/// A link of a shape, for joints that rotate about z.
inline LinkConstants random_link(Draw& draw, PlacementShape shape) {
  LinkConstants k = random_link(draw, shape == PlacementShape::general   ? LinkRotation::any
                                      : shape < PlacementShape::parallel ? LinkRotation::tilted
                                                                         : LinkRotation::about_z);
  k.shape = shape;
  dispatch_shape(shape, [&](auto s) {
    using Has = PlacementTerms<s()>;
    if (Has::right) k.cos_a = 0, k.sin_a = 1, find_rotation(k);
    if (Has::any_offset) return;
    const double a = Has::a ? k.r.x : 0;
    k.d = Has::d ? k.r.y : 0;
    k.r = {a, -k.sin_a * k.d, k.cos_a * k.d};
  });
  return k;
}
inline LinkConstants random_link(Draw& draw, bool aligned) {
  return random_link(draw, aligned ? LinkRotation::tilted : LinkRotation::any);
}

inline SpatialMass<double> random_mass(Draw& draw) {  // of a body reduced along one direction: a full articulated mass
  SpatialMass<double> M{};
  for (int i = 0; i < 3; ++i) {
    RigidMass body;
    body.m = 1.5 + draw();
    const Vec3 c = draw.vector();
    body.mc = body.m * c;
    const double cc = dot(c, c);
    body.J = Sym3{body.m * (cc - c.x * c.x) + 0.3,
                  body.m * (cc - c.y * c.y) + 0.4,
                  body.m * (cc - c.z * c.z) + 0.5,
                  -body.m * c.x * c.y,
                  -body.m * c.x * c.z,
                  -body.m * c.y * c.z};
    add_rigid_mass(M, body);
    // An articulated mass is not that of a rigid body: reduce it along an arbitrary direction.
    const Motion<double> e{draw.vector(), draw.vector()};
    const Force<double> Me = M * e;
    subtract_outer(M, (0.5 / dot(e, Me)) * Me, Me);
  }
  return M;
}

inline std::array<double, 6> flat(const Force<double>& f) { return {f.l.x, f.l.y, f.l.z, f.h.x, f.h.y, f.h.z}; }
inline std::array<double, 6> flat(const Motion<double>& m) { return {m.v.x, m.v.y, m.v.z, m.w.x, m.w.y, m.w.z}; }
inline std::vector<double> flat(const SpatialMass<double>& M) {
  return {M.A.xx, M.A.yy, M.A.zz, M.A.xy, M.A.xz, M.A.yz, M.B.xx, M.B.xy, M.B.xz, M.B.yx, M.B.yy,
          M.B.yz, M.B.zx, M.B.zy, M.B.zz, M.J.xx, M.J.yy, M.J.zz, M.J.xy, M.J.xz, M.J.yz};
}
template <class A, class B>
double distance(const A& a, const B& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::fmax(worst, std::fabs(a[i] - b[i]));
  return worst;
}

}  // namespace momentree
