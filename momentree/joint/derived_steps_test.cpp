// Derived steps against the generic functions of their kind, for every kind that has them, rotation of the link and place.
#include <cmath>
#include <string>
#include <type_traits>

#include <doctest/doctest.h>

#include <momentree/joint/all_derived.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/test_support.hpp>
#include <momentree/math/counted.hpp>
#include <momentree/math/pack.hpp>

using namespace momentree;

namespace {

double lane(double x) { return x; }
double lane(const Counted& x) { return x.value(); }
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

// The coordinates and momenta of a joint, as every scalar sees them.
template <class T>
struct Joint {
  std::array<T, 8> q{}, p{};
  std::array<T, 2> c{}, s{};
  JointState<T> state() const { return {q.data(), c.data(), s.data()}; }
};
struct Results {
  Inboard<double> in{};
  Outboard<double> out{};
  std::array<double, 8> u{}, pdot{}, qdot{};
};

template <class Steps, bool Add, class T>
Results derived(const LinkConstants& k, double mass, const Joint<double>& of, const Results& start) {
  Joint<T> joint;
  for (std::size_t i = 0; i < 8; ++i) joint.q[i] = T(of.q[i]), joint.p[i] = T(of.p[i]);
  for (std::size_t i = 0; i < 2; ++i) joint.c[i] = T(of.c[i]), joint.s[i] = T(of.s[i]);
  Inboard<T> a{as<T>(start.in.M), {as<T>(start.in.D.l), as<T>(start.in.D.h)}, as<T>(start.in.mc)};
  Outboard<T> out{{as<T>(start.out.velocity.v), as<T>(start.out.velocity.w)}, as<T>(start.out.gravity)};
  typename Steps::template Record<T> w;
  std::array<T, 8> u, pdot, qdot;
  u.fill(T(0)), pdot.fill(T(0)), qdot.fill(T(0));
  Inboard<T> sum = a;
  Steps::template inboard<Add, T>(k, mass, true, joint.state(), joint.p.data(), a, w, Add ? sum : a);
  Steps::template outboard<T>(k, mass, joint.state(), joint.p.data(), w, out, u.data(), pdot.data(), qdot.data());
  Results r;
  if (Add) a = sum;
  r.in = {lane(a.M), {lane(a.D.l), lane(a.D.h)}, lane(a.mc)};
  r.out = {{lane(out.velocity.v), lane(out.velocity.w)}, lane(out.gravity)};
  for (std::size_t i = 0; i < 8; ++i) r.u[i] = lane(u[i]), r.pdot[i] = lane(pdot[i]), r.qdot[i] = lane(qdot[i]);
  return r;
}

// The generic functions; those of a free joint with the kernel frame away from the joint's origin.
struct GenericFreeOfCentre : SixDofsOfCentre<GenericFreeOfCentre> {};
template <class Kind>
using GenericOf =
    std::conditional_t<std::is_same_v<Kind, Free>, GenericFreeOfCentre, typename KernelsFor<Kind, Variant::plain>::Generic>;

// The same by the functions of the recursions, with the generic reduction.
template <class Kind>
Results generic(const LinkConstants& k, double mass, bool leaf, bool root, const Joint<double>& joint, const Results& start) {
  using K = GenericOf<Kind>;
  Results r = start;
  if (leaf) r.in = {};
  if (root) r.out.velocity = {};
  articulated_mass(k.body, r.in.M);
  r.in.mc += k.body.mc;
  const Vec3 mc = r.in.mc;
  typename K::template Record<double> w{};
  const double none[6] = {};
  K::template reduce<double>(k, joint.state(), joint.p.data(), none, r.in.M, r.in.D, w);
  const DenseTransform<double> x = dense_transform<K, double>(k, joint.state());
  x.inboard(r.in.M), x.inboard(r.in.D), x.inboard(r.in.mc, mass);
  Motion<double>& velocity = r.out.velocity;
  x.outboard(velocity), x.outboard(r.out.gravity);
  K::joint_velocity(w, velocity, r.u.data());
  const Force<double> Pb = K::articulated_momentum(w, joint.p.data(), velocity);
  velocity = K::template spatial_velocity<double>(k, joint.state(), velocity, r.u.data());
  const Force<double> wrench = accumulated_force(mass, mc, r.out.gravity) - cross(velocity, Pb);
  K::template momentum_rate<double>(k, joint.state(), r.u.data(), Pb, wrench, r.pdot.data());
  K::template coordinate_rate<double>(joint.q.data(), r.u.data(), r.qdot.data());
  return r;
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

template <class Kind, LinkRotation Rotation, Place At, class T>
[[gnu::noinline]] void law(Draw& draw, LinkRotation rotation, double tolerance) {
  using K = typename Kind::Kernels;
  using Steps = DerivedSteps<K, Rotation, At>;
  constexpr bool leaf = At == Place::leaf || At == Place::single, root = At == Place::root || At == Place::single;
  LinkConstants k = random_link(draw, rotation);
  JointSpec spec;
  spec.axis = normalized(draw.vector()), spec.axis2 = normalized(draw.vector());
  spec.pitch = draw();
  if (std::fabs(dot(spec.axis, spec.axis2)) > 0.9) return;  // nearly parallel axes of a universal joint
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
  Joint<double> joint;
  for (std::size_t i = 0; i < 8; ++i) joint.q[i] = 2 * draw(), joint.p[i] = draw();
  K::normalise(joint.q.data());
  for (std::size_t i = 0; i < K::angles.size(); ++i) {
    const double angle = joint.q[static_cast<std::size_t>(K::angles[i])] + (K::rotates_about_z ? k.angle_0 : 0.0);
    joint.c[i] = std::cos(angle), joint.s[i] = std::sin(angle);
  }
  Results start;
  start.in = {random_mass(draw), {draw.vector(), draw.vector()}, draw.vector()};
  start.out = {{draw.vector(), draw.vector()}, draw.vector()};
  const double mass = 2 + draw();
  const Results expected = generic<Kind>(k, mass, leaf, root, joint, start);
  const auto check = [&](const Results& found) {
    CHECK(relative(found.u, expected.u) < tolerance);
    CHECK(relative(found.pdot, expected.pdot) < tolerance);
    CHECK(relative(found.qdot, expected.qdot) < tolerance);
    if (leaf) return;  // nothing reads its velocity
    CHECK(relative(flat(found.out.velocity), flat(expected.out.velocity)) < tolerance);
    CHECK(norm(found.out.gravity - expected.out.gravity) < tolerance);
  };
  const Results found = derived<Steps, false, T>(k, mass, joint, start), more = derived<Steps, true, T>(k, mass, joint, start);
  check(found), check(more);
  if (root) return;  // nothing reads its contribution
  CHECK(relative(flat(found.in.M), flat(expected.in.M)) < tolerance);
  CHECK(relative(flat(found.in.D), flat(expected.in.D)) < tolerance);
  CHECK(norm(found.in.mc - expected.in.mc) < tolerance * (1 + norm(expected.in.mc)));
  Inboard<double> sum = start.in;
  sum += expected.in;
  CHECK(relative(flat(more.in.M), flat(sum.M)) < tolerance);
  CHECK(relative(flat(more.in.D), flat(sum.D)) < tolerance);
  CHECK(norm(more.in.mc - sum.mc) < tolerance * (1 + norm(sum.mc)));
}

template <class Kind, LinkRotation Rotation, class T>
void laws_of_places(Draw& draw, double tolerance) {
  constexpr unsigned kept = derived_rotations<typename Kind::Kernels>;
  if constexpr ((kept >> static_cast<unsigned>(Rotation) & 1u) != 0)
    for (int trial = 0; trial < 100; ++trial) {
      law<Kind, Rotation, Place::inner, T>(draw, Rotation, tolerance),
          law<Kind, Rotation, Place::leaf, T>(draw, Rotation, tolerance);
      law<Kind, LinkRotation::any, Place::root, T>(draw, Rotation, tolerance);
      law<Kind, LinkRotation::any, Place::single, T>(draw, Rotation, tolerance);
    }
}

template <class T>
void laws(double tolerance) {
  Draw draw;
  int kinds = 0;
  for (const KindInfo& kind : all_kinds())
    dispatch(kind.kind, [&](auto tag) {
      using Kind = typename decltype(tag)::type;
      if constexpr (has_derived_steps<typename Kind::Kernels>) {
        INFO(std::string(Kind::info.name));
        ++kinds;
        laws_of_places<Kind, LinkRotation::any, T>(draw, tolerance),
            laws_of_places<Kind, LinkRotation::tilted, T>(draw, tolerance);
        laws_of_places<Kind, LinkRotation::about_z, T>(draw, tolerance),
            laws_of_places<Kind, LinkRotation::none, T>(draw, tolerance);
      }
    });
  CHECK(kinds >= 7);
}

}  // namespace

TEST_CASE("(15) (16) (17) (20) (21) (22) (23) (24) (25) (26) (27) derived steps equal the generic functions") {
  SUBCASE("double") { laws<double>(1e-12); }
  SUBCASE("counted") { laws<Counted>(1e-12); }
  SUBCASE("lanes") { laws<Pack<double, 2>>(1e-12); }
}
