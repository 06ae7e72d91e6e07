#pragma once
// Random joints for the tests of derived steps, and their numbers as every scalar sees them.
#include <array>
#include <cmath>
#include <optional>

#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/test_support.hpp>
#include <momentree/math/counted.hpp>
#include <momentree/math/pack.hpp>

namespace momentree::test {

inline double lane(double x) { return x; }
inline double lane(const Counted& x) { return x.value(); }
template <class S, int N>
double lane(const Pack<S, N>& x) {
  return static_cast<double>(x[N - 1]);
}
template <class T>
Vec3 lane(const Vector3<T>& a) {
  return {lane(a.x), lane(a.y), lane(a.z)};
}
template <class T>
Vector3<T> as(const Vec3& a) {
  return {T(a.x), T(a.y), T(a.z)};
}
template <class T>
SpatialMass<T> as(const SpatialMass<double>& M) {
  SpatialMass<T> to;
  const auto s = [](const Sym3& m) { return Symmetric3<T>{T(m.xx), T(m.yy), T(m.zz), T(m.xy), T(m.xz), T(m.yz)}; };
  to.A = s(M.A), to.J = s(M.J);
  to.B = {T(M.B.xx), T(M.B.xy), T(M.B.xz), T(M.B.yx), T(M.B.yy), T(M.B.yz), T(M.B.zx), T(M.B.zy), T(M.B.zz)};
  return to;
}
template <class T>
SpatialMass<double> lane(const SpatialMass<T>& M) {
  const auto s = [](const Symmetric3<T>& m) {
    return Sym3{lane(m.xx), lane(m.yy), lane(m.zz), lane(m.xy), lane(m.xz), lane(m.yz)};
  };
  return {s(M.A),
          {lane(M.B.xx), lane(M.B.xy), lane(M.B.xz), lane(M.B.yx), lane(M.B.yy), lane(M.B.yz), lane(M.B.zx), lane(M.B.zy),
           lane(M.B.zz)},
          s(M.J)};
}

/// The coordinates of a joint, numbers of its DoFs (momenta, or velocities) and forces.
template <class T>
struct TestJoint {
  std::array<T, 8> q{}, p{}, tau{};
  std::array<T, 2> c{}, s{};
  JointState<T> state() const { return {q.data(), c.data(), s.data()}; }
};
template <class T>
TestJoint<T> as(const TestJoint<double>& of) {
  TestJoint<T> to;
  for (std::size_t i = 0; i < 8; ++i) to.q[i] = T(of.q[i]), to.p[i] = T(of.p[i]), to.tau[i] = T(of.tau[i]);
  for (std::size_t i = 0; i < 2; ++i) to.c[i] = T(of.c[i]), to.s[i] = T(of.s[i]);
  return to;
}
template <class T>
Inboard<T> as(const Inboard<double>& a) {
  return {as<T>(a.M), {as<T>(a.D.l), as<T>(a.D.h)}, as<T>(a.mc)};
}
template <class T>
Inboard<double> lane(const Inboard<T>& a) {
  return {lane(a.M), {lane(a.D.l), lane(a.D.h)}, lane(a.mc)};
}

template <class A>
double largest(const A& a) {
  double x = 1;
  for (const double one : a) x = std::fmax(x, std::fabs(one));
  return x;
}
template <class A>
double relative(const A& a, const A& b) {
  return distance(a, b) / largest(b);
}

/// The generic functions; those of a free joint with the kernel frame away from the joint's origin.
struct GenericFreeOfCentre : SixDofsOfCentre<GenericFreeOfCentre> {};
template <class Kind>
using GenericOf =
    std::conditional_t<std::is_same_v<Kind, Free>, GenericFreeOfCentre, typename KernelsFor<Kind, Variant::plain>::Generic>;

/// A body with a joint of this kind. Nothing for a universal joint with nearly parallel axes.
template <class Kind>
std::optional<TestJoint<double>> random_joint(Draw& draw, bool root, LinkConstants& k) {
  using K = typename Kind::Kernels;
  JointSpec spec;
  spec.axis = normalized(draw.vector()), spec.axis2 = normalized(draw.vector());
  spec.pitch = draw();
  if (std::fabs(dot(spec.axis, spec.axis2)) > 0.9) return {};  // nearly parallel axes of a universal joint
  K::frame(spec, k.geometry);
  if (Kind::info.kind == momentree::Kind::free && root)
    for (double& x : k.geometry) x = draw();
  RigidMass body{1.5 + draw(), draw.vector(), {}};
  const Vec3 c = (1 / body.m) * body.mc;
  body.J = {body.m * (c.y * c.y + c.z * c.z) + 0.3,
            body.m * (c.x * c.x + c.z * c.z) + 0.4,
            body.m * (c.x * c.x + c.y * c.y) + 0.5,
            -body.m * c.x * c.y,
            -body.m * c.x * c.z,
            -body.m * c.y * c.z};
  k.body = body;
  TestJoint<double> joint;
  for (std::size_t i = 0; i < 8; ++i) joint.q[i] = 2 * draw(), joint.p[i] = draw();
  for (double& x : joint.tau) x = draw();
  K::normalise(joint.q.data());
  for (std::size_t i = 0; i < K::angles.size(); ++i) {
    const double angle = joint.q[static_cast<std::size_t>(K::angles[i])] + (K::rotates_about_z ? k.angle_0 : 0.0);
    joint.c[i] = std::cos(angle), joint.s[i] = std::sin(angle);
  }
  return joint;
}

}  // namespace momentree::test
