// Whole steps across a revolute joint against the generic functions: every step that the recursions select, by the shape of the
// link and the flags of its node.
#include <algorithm>
#include <cmath>
#include <iterator>

#include <doctest/doctest.h>

#include <momentree/dynamics/revolute_dispatch.hpp>
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

// The steps as the recursions call them. Each is compiled once, with everything inlined, as in the library's loops.

template <class Steps, bool Gravity>
[[gnu::noinline]] void step_inboard(const LinkConstants& k, unsigned flags, double mass, double armature, const double& c,
                                    const double& s, const double& p, const Inboard<double>& in, const Inboard<double>& others,
                                    typename Steps::template Record<double>& w, Inboard<double>& out) {
  dispatch_inboard<Steps::has_armature>(k.shape, flags, [&](auto shape, auto children, auto destination) MOMENTREE_INLINE_LAMBDA {
    Steps::template inboard<shape(), Gravity, children(), destination() == Destination::none>(k, mass, armature, c, s, p, in,
                                                                                              others, w, out);
  });
}
template <class Steps, bool Gravity>
[[gnu::noinline]] void step_outboard(const LinkConstants& k, unsigned flags, const double& c, const double& s,
                                     const typename Steps::template Record<double>& w, const double& p, Outboard<double>& out,
                                     double& u, double& pdot, BodySweep<double>& kept) {
  if ((flags & node::root) != 0) return Steps::template outboard_root<Gravity>(k, c, s, w, p, out, u, pdot, kept);
  dispatch_link<Steps::has_armature>(k.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
    Steps::template outboard<shape(), Gravity>(k, c, s, w, p, out, u, pdot, kept);
  });
}
template <class Steps>
[[gnu::noinline]] void wrench_inboard(const LinkConstants& k, const double& c, const double& s, Force<double>& W) {
  dispatch_link<Steps::has_armature>(
      k.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA { Steps::template cross_inboard<shape()>(k, c, s, W); });
}
template <class Steps>
[[gnu::noinline]] void step_accelerations(const LinkConstants& k, const double& c, const double& s,
                                          const typename Steps::template Record<double>& w, const Motion<double>& velocity,
                                          const double& u, double& udot, Motion<double>& a, Motion<double>& approach) {
  dispatch_link<Steps::has_armature>(k.shape, [&](auto shape) MOMENTREE_INLINE_LAMBDA {
    Steps::template rate_outboard<shape()>(k, c, s, w, velocity, u, udot, a, approach);
  });
}

template <class Steps>
struct Step {
  bool gravity;
  decltype(&step_inboard<Steps, true>) inboard;
  decltype(&step_outboard<Steps, true>) outboard;
};

// One inward and one outward step of a link of a shape, of a body with these node flags, against the generic functions.
template <class Steps>
void step_laws(Draw& draw, const Step<Steps>& step, PlacementShape shape, unsigned flags) {
  using L = GenericRevolute;
  using K = std::conditional_t<Steps::has_armature, ArmatureKernels, RevoluteKernels>;
  const bool root = (flags & node::root) != 0, leaf = (flags & node::leaf) != 0, branching = (flags & node::branching) != 0;
  const LinkConstants k = link_of_shape(shape, draw);
  const double mass = 2 + draw(), q = 3 * draw(), p = draw(), c = std::cos(q), s = std::sin(q),
               armature = !Steps::has_armature ? 0
                          : draw() < 0         ? 1.5 + draw()
                                               : 1e9;  // as with `damped`
  const JointState<double> joint{&q, &c, &s};
  const auto some = [&] { return Inboard<double>{random_mass(draw), {draw.vector(), draw.vector()}, draw.vector()}; };
  Inboard<double> in = some(), others = some(), expected{};
  if (!leaf) expected += in;
  if (branching) expected += others;
  articulated_mass(k.body, expected.M);  // (22)
  expected.mc += k.body.mc;
  typename L::template Record<double> record{};
  record.mc = expected.mc;
  L::reduce<double>(k, joint, &p, &armature, expected.M, expected.D, record);  // (24)–(26)
  const DenseTransform<double> x = dense_transform<L, double>(k, joint);
  x.inboard(expected.M), x.inboard(expected.D), x.inboard(expected.mc, mass);  // (16)

  typename Steps::template Record<double> w{};
  Inboard<double> aside = in;
  step.inboard(k, flags, mass, armature, c, s, p, in, others, w, aside);
  step.inboard(k, flags, mass, armature, c, s, p, in, others, w, in);  // output aliases input
  CHECK(distance(flat(in.M), flat(aside.M)) == 0);
  CHECK(distance(flat(in.D), flat(aside.D)) == 0);
  if (!root) {
    CHECK(distance(flat(in.M), flat(expected.M)) < 1e-12);
    CHECK(distance(flat(in.D), flat(expected.D)) < 1e-12);
    if (step.gravity) CHECK(norm(in.mc - expected.mc) < 1e-13);
  }

  const Outboard<double> base{root ? Motion<double>{} : Motion<double>{draw.vector(), draw.vector()},
                              step.gravity ? draw.vector() : Vec3{}};
  Outboard<double> out = base, far = base;
  double u = 0, pdot = 0, u_expected = 0, pdot_expected = 0;
  BodySweep<double> kept{};
  step.outboard(k, flags, c, s, w, p, out, u, pdot, kept);
  x.outboard(far.velocity), x.outboard(far.gravity);
  L::joint_velocity(record, far.velocity, &u_expected);                                                   // (27)
  const Force<double> Pb = L::articulated_momentum(record, &p, far.velocity);                             // (21)
  far.velocity = L::spatial_velocity<double>(k, joint, far.velocity, &u_expected);                        // (17)
  const Force<double> weight{mass * far.gravity, cross(record.mc, far.gravity)};                          // (15)
  L::momentum_rate<double>(k, joint, &u_expected, Pb, weight - cross(far.velocity, Pb), &pdot_expected);  // (20)
  CHECK(std::fabs(u - u_expected) * (1 + armature) < 1e-12);
  CHECK(std::fabs(pdot - pdot_expected) < 1e-11);
  CHECK(distance(flat(out.velocity), flat(far.velocity)) < 1e-12);
  if (step.gravity) CHECK(norm(out.gravity - far.gravity) < 1e-13);
  CHECK(distance(flat(kept.velocity), flat(far.velocity)) < 1e-12);
  CHECK(distance(flat(kept.articulated), flat(Pb)) < 1e-11);

  // Second recursion: (45), and (39) with (47).
  Force<double> W{draw.vector(), draw.vector()}, W_expected = W;
  wrench_inboard<Steps>(k, c, s, W), x.inboard(W_expected);
  CHECK(distance(flat(W), flat(W_expected)) < 1e-13);
  const Motion<double> velocity{draw.vector(), draw.vector()};
  Motion<double> a{draw.vector(), draw.vector()}, a_expected = a, approach{};
  const Motion<double> bias = L::acceleration_bias<double>(k, joint, velocity, &u);
  double udot = draw(), udot_expected = udot;
  K::joint_acceleration(w, bias, &udot);
  step_accelerations<Steps>(k, c, s, w, velocity, u, udot, a, approach);
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
    "(15) (16) (17) (20) (21) (22) (23) (24) (25) (26) (27) (39) (45) (47) steps of a revolute joint equal the generic functions",
    Steps, RevoluteSteps, ArmatureSteps) {
  const Step<Steps> steps[] = {{false, step_inboard<Steps, false>, step_outboard<Steps, false>},
                               {true, step_inboard<Steps, true>, step_outboard<Steps, true>}};
  Draw draw;
  for (const Step<Steps>& step : steps)
    for (int shape = 0; shape <= static_cast<int>(PlacementShape::parallel_a); ++shape)
      for (const unsigned children : {0u, static_cast<unsigned>(node::leaf), static_cast<unsigned>(node::branching)})
        for (const unsigned place : {0u, static_cast<unsigned>(node::last_child), static_cast<unsigned>(node::root)}) {
          CAPTURE(step.gravity);
          CAPTURE(shape);
          CAPTURE(children);
          CAPTURE(place);
          for (int trial = 0; trial < 20; ++trial) step_laws(draw, step, static_cast<PlacementShape>(shape), children | place);
        }
}
