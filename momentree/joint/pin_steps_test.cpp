// Whole steps across a pin, by the shape of its link, against the pieces that every kind has.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <doctest/doctest.h>

#include <momentree/joint/dispatch.hpp>
#include <momentree/joint/test_support.hpp>

using namespace momentree;

namespace {

// A link of a shape, as `Tree` makes it: a along the parent's x, d along the joint's own axis.
Link link_of_shape(LinkShape shape, Draw& draw) {
  Link k = random_link(draw, shape != LinkShape::general);
  const double turns[] = {0, std::acos(0.0)};
  const bool right = shape >= LinkShape::right && shape <= LinkShape::right_meeting;
  if (right || shape >= LinkShape::parallel) {
    const double a = turns[right ? 1 : 0];
    k.cos_a = right ? 0 : 1, k.sin_a = right ? 1 : 0, k.cs_a = 0, k.ss_a = std::sin(a) * std::sin(a);
  }
  k.shape = shape;
  const RigidMass body{1.5 + draw(), draw.vector(), {1.5 + draw(), 1.6 + draw(), 1.7 + draw(), draw(), draw(), draw()}};
  k.body = body;
  if (shape <= LinkShape::tilted) return k;
  const LinkShape with_a[] = {LinkShape::screw,   LinkShape::screw_a,  LinkShape::right,
                              LinkShape::right_a, LinkShape::parallel, LinkShape::parallel_a};
  const LinkShape with_d[] = {LinkShape::screw, LinkShape::screw_d, LinkShape::right, LinkShape::right_d, LinkShape::parallel};
  k.d = std::count(std::begin(with_d), std::end(with_d), shape) > 0 ? draw() : 0;
  k.r = {std::count(std::begin(with_a), std::end(with_a), shape) > 0 ? draw() : 0, -k.d * k.sin_a, k.d * k.cos_a};
  return k;
}

// One step inboard and one outboard against the same by the generic pieces.
template <LinkShape S, bool Gravity, bool Keep, bool Tip, bool Root>
void step_laws(Draw& draw) {
  using L = PinWithRotor;
  const Link k = link_of_shape(S, draw);
  const double mass = 2 + draw(), q = 3 * draw(), p = draw(), c = std::cos(q), s = std::sin(q), no_rotor = 0;
  const JointState<double> joint{&q, &c, &s};
  Inboard<double> in{random_mass(draw), {draw.vector(), draw.vector()}, draw.vector()};
  Inboard<double> expected = Tip ? Inboard<double>{} : in;
  add_rigid_mass(expected.M, k.body);  // (22), (23)
  expected.mc += k.body.mc;
  typename L::template Record<double> record{};
  record.mc = expected.mc;
  L::reduce<double>(k, joint, &p, &no_rotor, expected.M, expected.D, record);  // (24)–(26)
  const DenseCrossing<double> x = dense_crossing<L, double>(k, joint);
  x.inboard(expected.M), x.inboard(expected.D), x.inboard(expected.mc, mass);  // (16)

  PinRecord<double> w{};
  PinSteps::inboard<S, Gravity, Keep, Tip, Root>(k, mass, c, s, p, in, w);
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
  PinSteps::outboard<S, Gravity, Keep>(k, c, s, w, p, Root, out, u, pdot, Keep ? &kept : nullptr);
  x.outboard(far.velocity), x.outboard(far.gravity);
  L::joint_velocity(record, far.velocity, &u_expected);                                                   // (27)
  const Force<double> Pb = L::articulated_momentum(record, &p, far.velocity);                             // (21)
  far.velocity = L::spatial_velocity<double>(k, joint, far.velocity, &u_expected);                        // (17)
  const Force<double> weight{mass * far.gravity, cross(record.mc, far.gravity)};                          // (15)
  L::momentum_rate<double>(k, joint, &u_expected, Pb, weight - cross(far.velocity, Pb), &pdot_expected);  // (20)
  CHECK(std::fabs(u - u_expected) < 1e-12);
  CHECK(std::fabs(pdot - pdot_expected) < 1e-11);
  CHECK(distance(flat(out.velocity), flat(far.velocity)) < 1e-12);
  if (Gravity) CHECK(norm(out.gravity - far.gravity) < 1e-13);
  if (Keep) {
    CHECK(distance(flat(kept.velocity), flat(far.velocity)) < 1e-12);
    CHECK(distance(flat(kept.articulated), flat(Pb)) < 1e-11);
  }

  // The second recursion crosses by itself.
  Force<double> W{draw.vector(), draw.vector()}, W_expected = W;
  PinSteps::cross_inboard<S>(k, c, s, W), x.inboard(W_expected);
  CHECK(distance(flat(W), flat(W_expected)) < 1e-13);
  Motion<double> a{draw.vector(), draw.vector()}, a_expected = a;
  PinSteps::cross_outboard<S>(k, c, s, a), x.outboard(a_expected);
  CHECK(distance(flat(a), flat(a_expected)) < 1e-13);
}

}  // namespace

TEST_CASE("steps of a pin, by the shape of its link, are the generic pieces: (22)-(27), (15)-(17), (20), (21), (45)") {
  Draw draw;
  const auto all = []<std::size_t... I>(std::index_sequence<I...>, auto law) {
    (law(std::integral_constant<LinkShape, static_cast<LinkShape>(I)>{}), ...);
  };
  all(std::make_index_sequence<11>{}, [&](auto shape) {
    constexpr LinkShape S = shape();
    CAPTURE(static_cast<int>(S));
    for (int trial = 0; trial < 20; ++trial) {
      step_laws<S, true, false, false, false>(draw);
      step_laws<S, true, false, true, false>(draw);
      step_laws<S, false, false, false, false>(draw);
      step_laws<S, true, true, false, false>(draw);
      step_laws<S, true, true, true, false>(draw);
      step_laws<S, false, true, false, false>(draw);
      if constexpr (S == LinkShape::parallel || S == LinkShape::parallel_a) {  // roots go by these
        step_laws<S, true, false, false, true>(draw);
        step_laws<S, true, false, true, true>(draw);
        step_laws<S, true, true, false, true>(draw);
        step_laws<S, false, true, true, true>(draw);
      }
    }
  });
}
