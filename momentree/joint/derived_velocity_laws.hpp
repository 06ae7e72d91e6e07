#pragma once
// Derived steps in velocities against the generic functions of their kind, for every kind that has them, rotation or shape of the
// link and place. Included by one test per scalar, because each takes long to compile.
#include <string>
#include <type_traits>

#include <momentree/joint/all_velocity_derived.hpp>
#include <momentree/joint/derived_test_support.hpp>

namespace momentree::test::velocity_steps {

struct Results {
  Motion<double> velocity{}, acceleration{};
  Inboard<double> in{};
  std::array<double, 8> qdot{}, udot{};
};

template <class Steps, bool Add, class T>
Results derived(const LinkConstants& k, double armature, const TestJoint<double>& of, const Results& start) {
  const TestJoint<T> joint = as<T>(of);
  Motion<T> velocity{as<T>(start.velocity.v), as<T>(start.velocity.w)};
  Motion<T> acceleration{as<T>(start.acceleration.v), as<T>(start.acceleration.w)};
  Inboard<T> a = as<T>(start.in), sum = a;
  typename Steps::template Record<T> w;
  std::array<T, 8> qdot, udot;
  qdot.fill(T(0)), udot.fill(T(0));
  Steps::template velocities<T>(k, joint.state(), joint.p.data(), w, velocity, qdot.data());
  Steps::template inboard<Add, T>(k, armature, joint.state(), joint.tau.data(), a, w, Add ? sum : a);
  Steps::template outboard<T>(k, joint.state(), w, acceleration, udot.data());
  Results r;
  r.velocity.w = lane(velocity.w);
  r.acceleration = {lane(acceleration.v), lane(acceleration.w)};
  r.in = lane(Add ? sum : a);
  for (std::size_t i = 0; i < 8; ++i) r.qdot[i] = lane(qdot[i]), r.udot[i] = lane(udot[i]);
  return r;
}

// The same by the functions of the recursions, as in velocity.ipp, with the generic reduction.
template <class Kind>
Results generic(const LinkConstants& k, double armature, bool leaf, const TestJoint<double>& joint, const Results& start) {
  using K = GenericOf<Kind>;
  Results r = start;
  const DenseTransform<double> x = dense_transform<K, double>(k, joint.state());
  Motion<double>& velocity = r.velocity;
  velocity.v = {};
  x.outboard(velocity);
  velocity = K::template spatial_velocity<double>(k, joint.state(), velocity, joint.p.data());
  Motion<double> bias = K::template acceleration_bias<double>(k, joint.state(), velocity, joint.p.data());
  bias.v += cross(velocity.w, velocity.v);
  velocity.v = {};
  K::template coordinate_rate<double>(joint.q.data(), joint.p.data(), r.qdot.data());
  if (leaf) r.in = {};
  articulated_mass(k.body, r.in.M);
  r.in.D += gyroscopic_wrench(k.body, velocity);
  typename K::template Record<double> w{};
  const double armatures[6] = {armature};
  K::template reduce<double>(k, joint.state(), joint.tau.data(), armatures, r.in.M, r.in.D, w);
  K::add_reduced_bias(w, bias, r.in.D);
  x.inboard(r.in.M), x.inboard(r.in.D);
  Motion<double>& a = r.acceleration;
  x.outboard(a);
  a = a + bias;
  K::joint_velocity(w, a, r.udot.data());
  a = K::template spatial_velocity<double>(k, joint.state(), a, r.udot.data());
  return r;
}

template <class Kind, class K, auto Form, BodyPlace At, class T>
[[gnu::noinline]] void law(Draw& draw, double tolerance) {
  using Steps = DerivedVelocitySteps<K, Form, At>;
  constexpr bool leaf = At == BodyPlace::leaf || At == BodyPlace::single, root = At == BodyPlace::root || At == BodyPlace::single;
  LinkConstants k = random_link(draw, Form);
  const auto random = random_joint<Kind>(draw, root, k);
  if (!random) return;
  Results start;
  start.velocity = {{}, draw.vector()}, start.acceleration = {draw.vector(), draw.vector()};
  start.in = {random_mass(draw), {draw.vector(), draw.vector()}, {}};
  if (root) start.velocity.w = start.acceleration.w = {};
  const double armature = std::is_same_v<K, ArmatureKernels> ? 0.5 + 0.4 * draw() : 0;
  const Results expected = generic<Kind>(k, armature, leaf, *random, start);
  const auto check = [&](const Results& found) {
    CHECK(relative(found.qdot, expected.qdot) < tolerance);
    CHECK(relative(found.udot, expected.udot) < tolerance);
    if (leaf) return;  // nothing reads its motion
    CHECK(norm(found.velocity.w - expected.velocity.w) < tolerance);
    CHECK(relative(flat(found.acceleration), flat(expected.acceleration)) < tolerance);
  };
  const auto check_inboard = [&](const Inboard<double>& found, const Inboard<double>& sum) {
    CHECK(relative(flat(found.M), flat(sum.M)) < tolerance);
    CHECK(relative(flat(found.D), flat(sum.D)) < tolerance);
  };
  const Results found = derived<Steps, false, T>(k, armature, *random, start);
  check(found);
  if (!root) check_inboard(found.in, expected.in);  // nothing reads the contribution of a root
  if constexpr (At == BodyPlace::leaf) {            // only leaves add to a sum
    const Results more = derived<Steps, true, T>(k, armature, *random, start);
    Inboard<double> sum = start.in;
    sum += expected.in;
    check(more), check_inboard(more.in, sum);
  }
}

template <class Kind, class K, auto Form, class T>
void laws_of_places(Draw& draw, double tolerance) {
  constexpr bool by_shape = velocity_forms<K>.shapes != 0;
  constexpr unsigned kept = by_shape ? velocity_forms<K>.shapes : velocity_forms<K>.rotations;
  constexpr bool most_general = static_cast<unsigned>(Form) == 0;
  if constexpr ((kept >> static_cast<unsigned>(Form) & 1u) != 0)
    for (int trial = 0; trial < 50; ++trial) {
      law<Kind, K, Form, BodyPlace::inner, T>(draw, tolerance), law<Kind, K, Form, BodyPlace::leaf, T>(draw, tolerance);
      if constexpr (most_general)
        law<Kind, K, Form, BodyPlace::root, T>(draw, tolerance), law<Kind, K, Form, BodyPlace::single, T>(draw, tolerance);
    }
}

template <class Kind, class K, class T>
void laws_of_kernels(Draw& draw, double tolerance) {
  if constexpr (velocity_forms<K>.shapes != 0) {
    for (unsigned s = 0; s <= static_cast<unsigned>(PlacementShape::parallel_a); ++s)
      dispatch_shape(static_cast<PlacementShape>(s), [&](auto shape) { laws_of_places<Kind, K, shape(), T>(draw, tolerance); });
  } else {
    laws_of_places<Kind, K, LinkRotation::any, T>(draw, tolerance),
        laws_of_places<Kind, K, LinkRotation::tilted, T>(draw, tolerance);
    laws_of_places<Kind, K, LinkRotation::about_z, T>(draw, tolerance),
        laws_of_places<Kind, K, LinkRotation::none, T>(draw, tolerance);
  }
}

template <class T>
void laws(double tolerance) {
  Draw draw;
  int kinds = 0;
  for (const KindInfo& kind : all_kinds())
    dispatch(kind.kind, [&](auto tag) {
      using Kind = typename decltype(tag)::type;
      INFO(std::string(Kind::info.name));
      if constexpr (velocity_forms<typename Kind::Kernels>.any()) {
        ++kinds;
        laws_of_kernels<Kind, typename Kind::Kernels, T>(draw, tolerance);
      }
      if constexpr (requires { typename Kind::ArmatureKernels; })
        laws_of_kernels<Kind, typename Kind::ArmatureKernels, T>(draw, tolerance);
    });
  CHECK(kinds >= 8);
}

}  // namespace momentree::test::velocity_steps
