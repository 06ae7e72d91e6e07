#include <momentree/contact/point.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <momentree/contact/linear.hpp>

namespace momentree::contact {

namespace {

// The tangent force within a disc of that radius: t = −κ w_t with κ ≥ 0, and κ finite only at the rim. `c`: w_t at t = 0.
void friction_in_disc(const double* A, const double* c, double radius, double* t) {
  const double xx = A[4], xy = A[5], yy = A[8];
  const double trace = xx + yy;
  if (!(radius > 0) || !(trace > 0)) {
    t[0] = t[1] = 0;
    return;
  }
  // (A + λ 1) t = −c with |t| = radius, or λ = 0 and |t| smaller.
  const auto at = [&](double shift) {
    const double a = xx + shift, d = yy + shift, determinant = a * d - xy * xy;
    t[0] = -(d * c[0] - xy * c[1]) / determinant, t[1] = -(a * c[1] - xy * c[0]) / determinant;
    return std::hypot(t[0], t[1]);
  };
  const double tiny = 1e-15 * trace;
  if (at(tiny) <= radius) return;
  double low = tiny, high = std::hypot(c[0], c[1]) / radius;
  for (int k = 0; k < 200 && high - low > 1e-16 * high; ++k) {
    const double middle = 0.5 * (low + high);
    (at(middle) > radius ? low : high) = middle;
  }
  const double size = at(high);
  if (size > radius) t[0] *= radius / size, t[1] *= radius / size;
}

struct Slip {
  double N, across, along;  // the velocity across the direction of sliding, and along it
};
// A point that slips in the direction at `angle` with w_n = 0.
bool slip_at(const double* A, const double* b, double friction, double angle, Slip& out) {
  const double s[2] = {std::cos(angle), std::sin(angle)};
  const double mobility = A[0] - friction * (A[1] * s[0] + A[2] * s[1]);
  if (!(mobility > 1e-14 * A[0])) return false;
  out.N = -b[0] / mobility;
  const double t[2] = {-friction * out.N * s[0], -friction * out.N * s[1]};
  const double w1 = b[1] + A[3] * out.N + A[4] * t[0] + A[5] * t[1], w2 = b[2] + A[6] * out.N + A[7] * t[0] + A[8] * t[1];
  out.across = s[0] * w2 - s[1] * w1, out.along = s[0] * w1 + s[1] * w2;
  return out.N >= 0;
}

// Any direction of sliding, by the sign changes of the velocity across it.
bool find_slip(const double* A, const double* b, const PointLaw& law, double* r) {
  constexpr int samples = 128;
  constexpr double step = 2 * std::numbers::pi / samples;
  Slip last{}, now{};
  bool known = slip_at(A, b, law.friction, -std::numbers::pi, last);
  for (int k = 1; k <= samples; ++k) {
    double high = -std::numbers::pi + k * step, low = high - step;
    const bool fine = slip_at(A, b, law.friction, high, now);
    const Slip before = last;
    const bool crosses = known && fine && (before.across > 0) != (now.across > 0);
    last = now, known = fine;
    if (!crosses) continue;
    Slip middle{};
    const bool rising = now.across > 0;
    for (int i = 0; i < 60; ++i) {
      const double angle = 0.5 * (low + high);
      if (!slip_at(A, b, law.friction, angle, middle)) break;
      ((middle.across > 0) == rising ? high : low) = angle;
    }
    if (!slip_at(A, b, law.friction, low, middle) || !(middle.along > 0) || middle.N < law.least) continue;
    r[0] = middle.N, r[1] = -law.friction * middle.N * std::cos(low), r[2] = -law.friction * middle.N * std::sin(low);
    return true;
  }
  return false;
}

}  // namespace

bool solve_point(const double* A, const double* b, const PointLaw& law, double* r) {
  const double size = std::max({std::fabs(b[0]), std::fabs(b[1]), std::fabs(b[2]), law.least * A[0]});
  const double rounding = 1e-15 * size;
  // With the least normal force.
  r[0] = law.least;
  if (law.slipping) {
    r[1] = -law.friction * r[0] * law.direction[0], r[2] = -law.friction * r[0] * law.direction[1];
  } else {
    const double c[2] = {b[1] + A[3] * r[0], b[2] + A[6] * r[0]};
    friction_in_disc(A, c, law.friction * r[0], r + 1);
  }
  if (b[0] + A[0] * r[0] + A[1] * r[1] + A[2] * r[2] >= -rounding) return true;
  if (law.slipping) {
    const double mobility = A[0] - law.friction * (A[1] * law.direction[0] + A[2] * law.direction[1]);
    if (!(mobility > 1e-14 * A[0])) return false;
    r[0] = -b[0] / mobility;
    r[1] = -law.friction * r[0] * law.direction[0], r[2] = -law.friction * r[0] * law.direction[1];
    return r[0] >= law.least;
  }
  if (!(law.friction > 0)) {
    if (!(A[0] > 0)) return false;
    r[0] = -b[0] / A[0], r[1] = r[2] = 0;
    return true;
  }
  std::vector<double> matrix(A, A + 9), right{-b[0], -b[1], -b[2]};
  std::vector<std::size_t> columns;
  if (solve_linear(matrix, right, columns)) {
    const double left = std::fabs(b[0] + A[0] * right[0] + A[1] * right[1] + A[2] * right[2]);
    if (left <= 1e-12 * size && right[0] >= law.least && std::hypot(right[1], right[2]) <= law.friction * right[0]) {
      std::copy(right.begin(), right.end(), r);
      return true;
    }
  }
  return find_slip(A, b, law, r);
}

}  // namespace momentree::contact
