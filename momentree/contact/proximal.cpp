// The last resort of the solver: Newton's method on the law's projections with shortened steps (Alart & Curnier 1991), for a
// sequence of problems in which each point yields a little, A + εD instead of A, about the previous solution: proximal points
// (Rockafellar 1976). Redundant points then share their load in one way, and as a rule the sequence approaches a solution of the
// rigid problem: from a first guess it does so for 155 of 157 piles of boxes that 100 sweeps of projections do not solve, in 5 to
// 200 steps.
#include <algorithm>
#include <cmath>

#include <momentree/contact/linear.hpp>
#include <momentree/contact/system.hpp>

namespace momentree::contact {

namespace {

constexpr double first_yield = 0.1, least_yield = 1e-8;  // ε
constexpr int most_halvings = 12;
constexpr int most_flat = 10;  // steps that hardly improve

}  // namespace

// F = 0 at a solution, in units of velocity; of each point r − P(r − w/d), times d, with P the projection of the law. Fills
// `map_`, with the derivatives `matrix_`, and returns |F|².
double System::natural_map(bool with_derivatives) {
  const std::size_t n = unknowns();
  map_.assign(n, 0.0);
  if (with_derivatives) matrix_.assign(n * n, 0.0);
  for (std::size_t i = 0; i < points(); ++i) {
    const std::size_t at = 3 * i;
    const PointLaw& law = laws[i];
    const double a = element(at, at), d = tangent_mobility(i);
    const double free = a > 0 ? r[at] - velocity(at) / a : law.least, N = std::max(law.least, free), most = law.friction * N;
    const bool pressed = free > law.least;
    double* const rows = with_derivatives ? matrix_.data() + at * n : nullptr;
    const auto identity = [&](std::size_t k, double size) {
      map_[at + k] = size * r[at + k];
      if (rows) rows[k * n + at + k] = size;
    };
    if (pressed) {
      map_[at] = velocity(at);
      if (rows) std::copy_n(A.data() + at * n, n, rows);
    } else {
      identity(0, a > 0 ? a : 1);
      map_[at] -= (a > 0 ? a : 1) * law.least;
    }
    if (!(law.friction > 0) || !(d > 0)) {
      identity(1, d > 0 ? d : 1), identity(2, d > 0 ? d : 1);
      continue;
    }
    const double x[2] = {r[at + 1] - velocity(at + 1) / d, r[at + 2] - velocity(at + 2) / d}, size = std::hypot(x[0], x[1]);
    if (!law.slipping && size <= most && most > 0) {
      for (std::size_t k = 1; k <= 2; ++k) map_[at + k] = velocity(at + k);
      if (rows) std::copy_n(A.data() + (at + 1) * n, 2 * n, rows + n);
      continue;
    }
    // On the rim of the disc of friction: t = μ N s, with s along x or opposite to the direction of slip that is given.
    const bool turns = !law.slipping && size > 0;
    const double s[2] = {law.slipping ? -law.direction[0]
                         : turns      ? x[0] / size
                                      : 1,
                         law.slipping ? -law.direction[1]
                         : turns      ? x[1] / size
                                      : 0};
    const double ratio = turns ? most / size : 0;
    for (std::size_t k = 0; k < 2; ++k) map_[at + k + 1] = d * (r[at + k + 1] - most * s[k]);
    if (!rows) continue;
    for (std::size_t j = 0; j < n; ++j) {
      double dx[2] = {-element(at + 1, j) / d, -element(at + 2, j) / d};
      if (j == at + 1 || j == at + 2) dx[j - at - 1] += 1;
      const double along = s[0] * dx[0] + s[1] * dx[1], dN = pressed ? (j == at ? 1 : 0) - element(at, j) / a : 0;
      for (std::size_t k = 0; k < 2; ++k)
        rows[(k + 1) * n + j] = d * ((j == at + k + 1 ? 1 : 0) - ratio * (dx[k] - along * s[k]) - law.friction * dN * s[k]);
    }
  }
  double square = 0;
  for (const double x : map_) square += x * x;
  return square;
}

// Newton's method with steps that are halved until |F| decreases. True if F vanishes.
bool System::damped_newton(int most_steps) {
  const double size = scale();
  double now = natural_map(true);
  int flat = 0;
  for (int k = 0; k < most_steps && std::isfinite(now); ++k) {
    if (now < 1e-24 * size * size) return true;
    right_ = map_;
    if (!solve_linear(matrix_, right_, column_of_)) return false;
    start_ = r;
    double best = HUGE_VAL, best_length = 1, length = 1;
    for (int j = 0; j < most_halvings; ++j, length *= 0.5) {
      for (std::size_t i = 0; i < r.size(); ++i) r[i] = start_[i] - length * right_[i];
      const double next = natural_map(false);
      if (next < best) best = next, best_length = length;
      if (next < (1 - 1e-4 * length) * now) break;
    }
    flat += best > 0.999 * now ? 1 : 0;
    if (flat > most_flat) return false;
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = start_[i] - best_length * right_[i];
    now = natural_map(true);
  }
  return now < 1e-24 * size * size;
}

// A sequence of at most that many problems, with less and less yield. Leaves the best solution found in r; true if it solves the
// rigid problem.
bool System::proximal_points(int most_problems) {
  const std::size_t n = unknowns();
  rigid_ = b, best_ = r, diagonal_.resize(n);
  for (std::size_t i = 0; i < n; ++i) diagonal_[i] = element(i, i);
  double best = HUGE_VAL, yield = first_yield, shrink = 0.1;
  for (int k = 0, failed = 0; k < most_problems && failed < 7; ++k) {
    centre_ = r;
    for (std::size_t i = 0; i < n; ++i)
      element(i, i) = (1 + yield) * diagonal_[i], b[i] = rigid_[i] - yield * diagonal_[i] * centre_[i];
    const bool found = damped_newton(20);
    for (std::size_t i = 0; i < n; ++i) element(i, i) = diagonal_[i];
    b = rigid_;
    if (!found) {  // more slowly, from a problem that is easier
      r = centre_, yield *= 6, shrink = 0.6, ++failed;
      continue;
    }
    const double now = residual();
    if (!(now < best) && best < 1e-12) break;  // no nearer: rounding
    if (now < best) best = now, best_ = r;
    if (now < solved) break;
    yield = std::max(shrink * yield, least_yield);
  }
  r = best_;
  return polish() || accept();
}

}  // namespace momentree::contact
