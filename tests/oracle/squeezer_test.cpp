// Andrews' squeezing mechanism, as in the Test Set for IVP Solvers and as A03 of the IFToMM benchmarks, against an integral.
//
// It has one degree of freedom and starts at rest, and its motor has a constant torque M. So the balance of energy gives the rate
// of the crank at each of its angles β, ½ I(β) β̇² = M (β − β0) − V(β) + V(β0), and one integral the time at which it is there:
//
//   t(β) = ∫ dβ / β̇ = ∫ 2 s √(I / 2 W) ds with β = β0 + s², where W is the right side above: it grows like s² from zero.
//
// Positions are intersections of circles; there are no differential equations and no Lagrange multipliers.
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include <momentree/momentree.hpp>

namespace momentree {
namespace {

// The data in the notation of the Test Set (m, kg, kg m², N/m, N m). K3, K5 and K7 have pins on the ground at B, A and A.
constexpr double ra = 0.00092, rr = 0.007, d = 0.028, da = 0.0115, e = 0.02, ea = 0.01421, ss = 0.035, sa = 0.01874, sb = 0.01043,
                 sc = 0.018, sd = 0.02, ta = 0.02308, tb = 0.00916, zt = 0.04, u = 0.04, ua = 0.01228, ub = 0.00449, zf = 0.02,
                 fa = 0.01421;
constexpr std::array<double, 2> A{-0.06934, -0.00227}, B{-0.03635, 0.03273}, C{0.014, 0.072};
constexpr std::array<double, 7> mass{0.04325, 0.00365, 0.02373, 0.00706, 0.0705, 0.00706, 0.05498},
    inertia{2.194e-6, 4.41e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5};
constexpr double spring_rate = 4530, spring_rest = 0.07785, motor = 0.033;
constexpr double start = -0.0617138900142764496;  // β0; the others follow from it

Model squeezer() {
  Model model({.gravity = {0, 0, 0}});
  const auto body = [&](int k, BodyId parent, Vec3 at, Vec3 com, double angle) {
    BodySpec spec;
    const auto i = static_cast<std::size_t>(k - 1);
    spec.name = "K" + std::to_string(k), spec.mass = mass[i], spec.com = com, spec.inertia = diagonal(0, inertia[i], inertia[i]);
    spec.parent = parent, spec.at.position = at, spec.joint = Revolute{.axis = z_axis, .effort = k == 1 ? motor : 0},
    spec.q = angle;
    return model.add(spec);
  };
  const Vec3 at_A{A[0], A[1], 0};
  const BodyId k1 = body(1, ground, {}, {ra, 0, 0}, start), k2 = body(2, k1, {rr, 0, 0}, {-da, 0, 0}, 0),
               k3 = body(3, ground, {B[0], B[1], 0}, {sb, -sa, 0}, 0.45527981916307038),
               k5 = body(5, ground, at_A, {ta, tb, 0}, 0.48736497954384255),
               k4 = body(4, k5, {zt, 0, 0}, {0, ea - e, 0}, 0.222668390165885884),
               k7 = body(7, ground, at_A, {-ub, -ua, 0}, 1.23054744454982119),
               k6 = body(6, k7, {0, -u, 0}, {zf - fa, 0, 0}, -0.222668390165885884);
  for (const auto& [last, end] : {std::pair{k3, Vec3{0, -ss, 0}}, std::pair{k4, Vec3{0, -e, 0}}, std::pair{k6, Vec3{zf, 0, 0}}})
    model.add_loop({.name = "loop " + std::to_string(last.index),
                    .body = last,
                    .to = k2,
                    .joint = Revolute{.axis = z_axis},
                    .at = {-d, 0, 0},
                    .child_at = end});
  model.add_spring({.name = "spring",
                    .from = {k3, {sd, -sc, 0}},
                    .to = {ground, {C[0], C[1], 0}},
                    .stiffness = spring_rate,
                    .rest = spring_rest});
  return model;
}

using Real = long double;
using Point = std::complex<Real>;  // of the plane

Point operator""_i(unsigned long long x) { return {0, static_cast<Real>(x)}; }
Real cross(Point a, Point b) { return a.real() * b.imag() - a.imag() * b.real(); }

/// Where circles of radii r and s about a and b meet: on the left of the way from a to b, or on its right.
Point meet(Point a, Real r, Point b, Real s, bool left) {
  const Point ab = b - a;
  const Real length = std::abs(ab), along = (r * r - s * s + length * length) / (2 * length);
  const Real aside = std::sqrt(r * r - along * along);
  return a + Point(along, left ? aside : -aside) * ab / length;
}

/// At an angle of the crank: I, and M less the derivative of the spring's energy.
struct Crank {
  Real inertia, effort;
};
Crank crank(Real angle) {
  const Point at_A(A[0], A[1]), at_B(B[0], B[1]), at_C(C[0], C[1]);
  const Point elbow = std::polar<Real>(rr, angle), pin = meet(elbow, d, at_B, ss, true);
  const Point end5 = meet(at_A, zt, pin, e, true), end7 = meet(at_A, u, pin, zf, false);
  // Velocities at a rate of 1 of the crank. Two bodies in a row from a point to a point of given velocities: x and y are their
  // rates in from + x i a = to + y i b.
  const auto rates = [](Point from, Point a, Point to, Point b) {
    const Point open = (to - from) / 1_i;
    return std::pair{cross(open, b) / cross(a, b), cross(open, a) / cross(a, b)};
  };
  const Point v_elbow = 1_i * elbow;
  const auto [w2, w3] = rates(v_elbow, pin - elbow, {}, pin - at_B);
  const Point v_pin = w3 * 1_i * (pin - at_B);
  const auto [w5, w4] = rates({}, end5 - at_A, v_pin, end5 - pin);
  const auto [w7, w6] = rates({}, end7 - at_A, v_pin, end7 - pin);
  const auto twice_energy = [](std::size_t k, Point v, Real w) { return mass[k - 1] * std::norm(v) + inertia[k - 1] * w * w; };
  Real sum = twice_energy(1, ra, 1) + twice_energy(2, v_elbow + w2 * 1_i * (pin - elbow) * (Real(da) / d), w2);
  sum += twice_energy(3, Point(sa, sb) * w3, w3) + twice_energy(5, Point(ta, tb) * w5, w5);
  sum += twice_energy(7, Point(ua, ub) * w7, w7);
  sum += twice_energy(4, w5 * 1_i * (end5 - at_A) + w4 * 1_i * (pin - end5) * ((Real(e) - ea) / e), w4);
  sum += twice_energy(6, w7 * 1_i * (end7 - at_A) + w6 * 1_i * (pin - end7) * ((Real(zf) - fa) / zf), w6);
  // The pin is at (0, -ss) of K3.
  const Point lever = Point(sd, -sc) * (pin - at_B) / Point(0, -ss), spring = at_B + lever - at_C;
  const Real length = std::abs(spring), rate = (spring * std::conj(w3 * 1_i * lever)).real() / length;
  return {sum, motor - spring_rate * (length - spring_rest) * rate};
}

/// Nodes and weights of Gauss and Legendre on (0, 1).
struct Rule {
  static constexpr int count = 20;
  std::array<Real, count> x, w;
  Rule() {
    for (int i = 0; i < count; ++i) {
      Real at = std::cos(std::numbers::pi_v<Real> * (i + 0.75L) / (count + 0.5L)), slope = 0;
      for (int newton = 0; newton < 8; ++newton) {
        Real before = 1, now = at;
        for (int k = 2; k <= count; ++k) before = std::exchange(now, ((2 * k - 1) * at * now - (k - 1) * before) / k);
        slope = count * (at * now - before) / (at * at - 1);
        at -= now / slope;
      }
      x[static_cast<std::size_t>(i)] = (1 + at) / 2, w[static_cast<std::size_t>(i)] = 1 / ((1 - at * at) * slope * slope);
    }
  }
};

/// The time at which the crank reaches an angle (s).
Real time_at(Real angle, int parts) {
  const Rule rule;
  const auto integral = [&](Real from, Real to, const auto& f) {
    Real sum = 0;
    for (std::size_t i = 0; i < Rule::count; ++i) sum += rule.w[i] * f(from + (to - from) * rule.x[i]);
    return sum * (to - from);
  };
  // W as a sum of parts: as a difference of energies it would lose its digits near the start.
  const auto power = [](Real s) { return crank(start + s * s).effort * 2 * s; };
  const Real last = std::sqrt(angle - start);
  Real time = 0, W = 0;
  for (int k = 0; k < parts; ++k) {
    const Real from = last * k / parts, to = last * (k + 1) / parts;
    time += integral(
        from, to, [&](Real s) { return 2 * s * std::sqrt(crank(start + s * s).inertia / (2 * (W + integral(from, s, power)))); });
    W += integral(from, to, power);
  }
  return time;
}

}  // namespace

TEST_CASE("Andrews' squeezing mechanism reaches its angle at the time that an integral gives") {
  constexpr double until = 0.03;
  // The integral has converged, to what long double gives.
  const Real fine = time_at(15.8L, 96);
  CHECK(std::fabs(static_cast<double>(time_at(15.8L, 64) - fine)) < 1e-17);

  for (const Variables variables : {Variables::velocities, Variables::momenta}) {
    CAPTURE((variables == Variables::momenta));
    Simulation run(squeezer(), {.method = "dop853", .variables = variables, .rtol = 1e-13, .atol = 1e-13});
    REQUIRE(run.run_until(until) == Status::ok);
    const double late = static_cast<double>(until - time_at(run.world().joint({0}).q[0], 64));
    CHECK(std::fabs(late) < 1e-14);
  }

  // The angle that the Test Set gives for this instant, and with which other programs are compared, comes a picosecond late.
  const double published = static_cast<double>(time_at(15.81077119629904L, 64) - until);
  CHECK(published == doctest::Approx(1.004e-12).epsilon(0.002));
}

}  // namespace momentree
