// Derived steps against the generic functions of their kind, for every kind that has them, rotation of the link and place.
#include <string>

#include <doctest/doctest.h>

#include <momentree/joint/all_derived.hpp>
#include <momentree/joint/derived_test_support.hpp>

using namespace momentree;
using namespace momentree::test;

namespace {

struct Results {
  Inboard<double> in{};
  Outboard<double> out{};
  std::array<double, 8> u{}, pdot{}, qdot{};
};

template <class Steps, bool Add, class T>
Results derived(const LinkConstants& k, double mass, const TestJoint<double>& of, const Results& start) {
  const TestJoint<T> joint = as<T>(of);
  Inboard<T> a = as<T>(start.in);
  Outboard<T> out{{as<T>(start.out.velocity.v), as<T>(start.out.velocity.w)}, as<T>(start.out.gravity)};
  typename Steps::template Record<T> w;
  std::array<T, 8> u, pdot, qdot;
  u.fill(T(0)), pdot.fill(T(0)), qdot.fill(T(0));
  Inboard<T> sum = a;
  Steps::template inboard<Add, T>(k, mass, true, joint.state(), joint.p.data(), a, w, Add ? sum : a);
  Steps::template outboard<T>(k, mass, joint.state(), joint.p.data(), w, out, u.data(), pdot.data(), qdot.data());
  Results r;
  if (Add) a = sum;
  r.in = lane(a);
  r.out = {{lane(out.velocity.v), lane(out.velocity.w)}, lane(out.gravity)};
  for (std::size_t i = 0; i < 8; ++i) r.u[i] = lane(u[i]), r.pdot[i] = lane(pdot[i]), r.qdot[i] = lane(qdot[i]);
  return r;
}

// The same by the functions of the recursions, with the generic reduction.
template <class Kind>
Results generic(const LinkConstants& k, double mass, bool leaf, bool root, const TestJoint<double>& joint, const Results& start) {
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

template <class Kind, LinkRotation Rotation, BodyPlace At, class T>
[[gnu::noinline]] void law(Draw& draw, LinkRotation rotation, double tolerance) {
  using K = typename Kind::Kernels;
  using Steps = DerivedSteps<K, Rotation, At>;
  constexpr bool leaf = At == BodyPlace::leaf || At == BodyPlace::single, root = At == BodyPlace::root || At == BodyPlace::single;
  LinkConstants k = random_link(draw, rotation);
  const auto random = random_joint<Kind>(draw, root, k);
  if (!random) return;
  const TestJoint<double>& joint = *random;
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
  const auto check_inboard = [&](const Inboard<double>& found, const Inboard<double>& sum) {
    CHECK(relative(flat(found.M), flat(sum.M)) < tolerance);
    CHECK(relative(flat(found.D), flat(sum.D)) < tolerance);
    CHECK(norm(found.mc - sum.mc) < tolerance * (1 + norm(sum.mc)));
  };
  const Results found = derived<Steps, false, T>(k, mass, joint, start);
  check(found);
  if (!root) check_inboard(found.in, expected.in);  // nothing reads the contribution of a root
  if constexpr (At == BodyPlace::leaf) {            // only leaves add to a sum
    const Results more = derived<Steps, true, T>(k, mass, joint, start);
    Inboard<double> sum = start.in;
    sum += expected.in;
    check(more), check_inboard(more.in, sum);
  }
}

template <class Kind, LinkRotation Rotation, class T>
void laws_of_places(Draw& draw, double tolerance) {
  constexpr unsigned kept = momentum_forms<typename Kind::Kernels>.rotations;
  if constexpr ((kept >> static_cast<unsigned>(Rotation) & 1u) != 0)
    for (int trial = 0; trial < 100; ++trial) {
      law<Kind, Rotation, BodyPlace::inner, T>(draw, Rotation, tolerance),
          law<Kind, Rotation, BodyPlace::leaf, T>(draw, Rotation, tolerance);
      law<Kind, LinkRotation::any, BodyPlace::root, T>(draw, Rotation, tolerance);
      law<Kind, LinkRotation::any, BodyPlace::single, T>(draw, Rotation, tolerance);
    }
}

template <class T>
void laws(double tolerance) {
  Draw draw;
  int kinds = 0;
  for (const KindInfo& kind : all_kinds())
    dispatch(kind.kind, [&](auto tag) {
      using Kind = typename decltype(tag)::type;
      if constexpr (momentum_forms<typename Kind::Kernels>.any()) {
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
