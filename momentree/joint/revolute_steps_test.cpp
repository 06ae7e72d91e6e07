// Whole steps across a revolute joint, by the shape of its link, against the generic functions.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <doctest/doctest.h>

#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/test_support.hpp>

using namespace momentree;

namespace {

// A link of a given shape, as `Tree` makes it: a along the parent's x, d along the joint's own axis.
LinkConstants link_of_shape(PlacementShape shape, Draw& draw) {
  LinkConstants k = random_link(draw, shape != PlacementShape::general);
  const double turns[] = {0, std::acos(0.0)};
  const bool right = shape >= PlacementShape::right && shape <= PlacementShape::right_meeting;
  if (right || shape >= PlacementShape::parallel) {
    const double a = turns[right ? 1 : 0];
    k.cos_a = right ? 0 : 1, k.sin_a = right ? 1 : 0, k.cs_a = 0, k.ss_a = std::sin(a) * std::sin(a);
  }
  k.shape = shape;
  const RigidMass body{1.5 + draw(), draw.vector(), {1.5 + draw(), 1.6 + draw(), 1.7 + draw(), draw(), draw(), draw()}};
  k.body = body;
  if (shape <= PlacementShape::tilted) return k;
  const PlacementShape with_a[] = {PlacementShape::screw,   PlacementShape::screw_a,  PlacementShape::right,
                                   PlacementShape::right_a, PlacementShape::parallel, PlacementShape::parallel_a};
  const PlacementShape with_d[] = {PlacementShape::screw, PlacementShape::screw_d, PlacementShape::right, PlacementShape::right_d,
                                   PlacementShape::parallel};
  k.d = std::count(std::begin(with_d), std::end(with_d), shape) > 0 ? draw() : 0;
  k.r = {std::count(std::begin(with_a), std::end(with_a), shape) > 0 ? draw() : 0, -k.d * k.sin_a, k.d * k.cos_a};
  return k;
}

// One inward and one outward step against the generic functions; `of`: the link's own shape, if the inward step is that of a more
// general one.
template <class Steps, PlacementShape S, bool Gravity, bool Keep, Children N, bool Root>
void step_laws(Draw& draw, PlacementShape of = S) {
  using L = GenericRevolute;
  using K = std::conditional_t<Steps::has_armature, ArmatureKernels, RevoluteKernels>;
  const LinkConstants k = link_of_shape(of, draw);
  const double mass = 2 + draw(), q = 3 * draw(), p = draw(), c = std::cos(q), s = std::sin(q),
               armature = !Steps::has_armature ? 0
                          : draw() < 0         ? 1.5 + draw()
                                               : 1e9;  // as with `damped`
  const JointState<double> joint{&q, &c, &s};
  const auto some = [&] { return Inboard<double>{random_mass(draw), {draw.vector(), draw.vector()}, draw.vector()}; };
  Inboard<double> in = some(), others = some(), expected{};
  if (N != Children::none) expected += in;
  if (N == Children::several) expected += others;
  add_rigid_mass(expected.M, k.body);  // (22), (23)
  expected.mc += k.body.mc;
  typename L::template Record<double> record{};
  record.mc = expected.mc;
  L::reduce<double>(k, joint, &p, &armature, expected.M, expected.D, record);  // (24)–(26)
  const DenseTransform<double> x = dense_transform<L, double>(k, joint);
  x.inboard(expected.M), x.inboard(expected.D), x.inboard(expected.mc, mass);  // (16)

  typename Steps::template Record<double> w{};
  Inboard<double> aside = in;
  Steps::template inboard<S, Gravity, Keep, N, Root>(k, mass, armature, c, s, p, in, others, w, aside);
  Steps::template inboard<S, Gravity, Keep, N, Root>(k, mass, armature, c, s, p, in, others, w, in);  // output aliases input
  CHECK(distance(flat(in.M), flat(aside.M)) == 0);
  CHECK(distance(flat(in.D), flat(aside.D)) == 0);
  if (!Root) {
    CHECK(distance(flat(in.M), flat(expected.M)) < 1e-12);
    CHECK(distance(flat(in.D), flat(expected.D)) < 1e-12);
    if (Gravity) CHECK(norm(in.mc - expected.mc) < 1e-13);
  }

  const Outboard<double> base{Root ? Motion<double>{} : Motion<double>{draw.vector(), draw.vector()},
                              Gravity ? draw.vector() : Vec3{}};
  Outboard<double> out = base, far = base;
  double u = 0, pdot = 0, u_expected = 0, pdot_expected = 0;
  BodySweep<double> kept{};
  if constexpr (Root)
    Steps::template outboard_root<Gravity, Keep>(k, c, s, w, p, out, u, pdot, &kept);
  else
    dispatch_link<Steps::has_armature>(
        of, [&](auto own) { Steps::template outboard<own(), Gravity, Keep>(k, c, s, w, p, false, out, u, pdot, &kept); });
  x.outboard(far.velocity), x.outboard(far.gravity);
  L::joint_velocity(record, far.velocity, &u_expected);                                                   // (27)
  const Force<double> Pb = L::articulated_momentum(record, &p, far.velocity);                             // (21)
  far.velocity = L::spatial_velocity<double>(k, joint, far.velocity, &u_expected);                        // (17)
  const Force<double> weight{mass * far.gravity, cross(record.mc, far.gravity)};                          // (15)
  L::momentum_rate<double>(k, joint, &u_expected, Pb, weight - cross(far.velocity, Pb), &pdot_expected);  // (20)
  CHECK(std::fabs(u - u_expected) * (1 + armature) < 1e-12);
  CHECK(std::fabs(pdot - pdot_expected) < 1e-11);
  CHECK(distance(flat(out.velocity), flat(far.velocity)) < 1e-12);
  if (Gravity) CHECK(norm(out.gravity - far.gravity) < 1e-13);
  if (Keep) {
    CHECK(distance(flat(kept.velocity), flat(far.velocity)) < 1e-12);
    CHECK(distance(flat(kept.articulated), flat(Pb)) < 1e-11);
  }

  // Second recursion: (45), and (39) with (47).
  Force<double> W{draw.vector(), draw.vector()}, W_expected = W;
  Steps::template cross_inboard<S>(k, c, s, W), x.inboard(W_expected);
  CHECK(distance(flat(W), flat(W_expected)) < 1e-13);
  if (!Keep) return;  // its records refer to the other side of the joint
  const Motion<double> velocity{draw.vector(), draw.vector()};
  Motion<double> a{draw.vector(), draw.vector()}, a_expected = a, approach{};
  const Motion<double> bias = L::acceleration_bias<double>(k, joint, velocity, &u);
  double udot = draw(), udot_expected = udot;
  K::joint_acceleration(w, bias, &udot);
  Steps::template rate_outboard<S>(k, c, s, w, velocity, u, udot, a, approach);
  x.outboard(a_expected);
  a_expected = a_expected + bias;
  CHECK(distance(flat(approach), flat(a_expected)) < 1e-13);
  L::joint_acceleration(record, a_expected, &udot_expected);
  CHECK(std::fabs(udot - udot_expected) < 1e-12);
  a_expected = L::spatial_velocity<double>(k, joint, a_expected, &udot_expected);
  CHECK(distance(flat(a), flat(a_expected)) < 1e-12);
}

}  // namespace

TEST_CASE_TEMPLATE(
    "steps of a pin, by the shape of its link, are the generic pieces: (22)-(27), (15)-(17), (20), (21), (39), (45), (47)", Steps,
    RevoluteSteps, ArmatureSteps) {
  Draw draw;
  const auto all = []<std::size_t... I>(std::index_sequence<I...>, auto law) {
    (law(std::integral_constant<PlacementShape, static_cast<PlacementShape>(I)>{}), ...);
  };
  all(std::make_index_sequence<11>{}, [&](auto shape) {
    constexpr PlacementShape S = shape();
    CAPTURE(static_cast<int>(S));
    constexpr PlacementShape main = S == PlacementShape::general || S == PlacementShape::tilted ? S
                                    : S < PlacementShape::right                                 ? PlacementShape::screw
                                    : S < PlacementShape::parallel                              ? PlacementShape::right
                                                                                                : PlacementShape::parallel;
    constexpr PlacementShape aside = main == S && S < PlacementShape::screw ? PlacementShape::general : PlacementShape::screw;
    constexpr PlacementShape few = S < PlacementShape::screw                                    ? PlacementShape::general
                                   : S >= PlacementShape::right && S < PlacementShape::parallel ? PlacementShape::right
                                                                                                : PlacementShape::screw;
    constexpr PlacementShape own = Steps::has_armature ? few : S, fork = Steps::has_armature ? few : main;
    for (int trial = 0; trial < 20; ++trial) {
      step_laws<Steps, own, true, false, Children::one, false>(draw, S);
      step_laws<Steps, own, true, false, Children::none, false>(draw, S);
      step_laws<Steps, own, false, false, Children::one, false>(draw, S);
      step_laws<Steps, own, true, true, Children::one, false>(draw, S);
      step_laws<Steps, own, true, true, Children::none, false>(draw, S);
      step_laws<Steps, own, false, true, Children::one, false>(draw, S);
      // Branching bodies and later children use steps of fewer shapes.
      step_laws<Steps, fork, true, false, Children::several, false>(draw, S);
      step_laws<Steps, fork, false, true, Children::several, false>(draw, S);
      step_laws<Steps, aside, true, false, Children::none, false>(draw, S);
      step_laws<Steps, aside, true, true, Children::one, false>(draw, S);
      step_laws<Steps, aside, true, false, Children::several, false>(draw, S);
      if constexpr (S == PlacementShape::parallel || S == PlacementShape::parallel_a) {  // used for roots
        step_laws<Steps, S, true, false, Children::one, true>(draw);
        step_laws<Steps, S, true, false, Children::none, true>(draw);
        step_laws<Steps, S, true, true, Children::one, true>(draw);
        step_laws<Steps, S, false, true, Children::none, true>(draw);
        step_laws<Steps, S, true, true, Children::several, true>(draw);
        step_laws<Steps, S, false, false, Children::several, true>(draw);
      }
    }
  });
}
