#include <momentree/contact/system.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/contact/law_newton.hpp>
#include <momentree/contact/linear.hpp>
#include <momentree/contact/point.hpp>

namespace momentree::contact {

namespace {

constexpr int sweeps_before_polish = 16;
constexpr double still = 1e-12;  // sliding velocities below this, relative to the largest |b|, are zero

// The nearest point with N ≥ N0 and |t| ≤ μ N.
void project_on_cone(const PointLaw& law, double* y) {
  const double mu = law.friction, size = std::hypot(y[1], y[2]);
  if (size > mu * y[0]) {
    const double N = std::max(0.0, (y[0] + mu * size) / (1 + mu * mu)), shorten = size > 0 ? mu * N / size : 0;
    y[0] = N, y[1] *= shorten, y[2] *= shorten;
  }
  if (y[0] >= law.least) return;
  y[0] = law.least;
  const double now = std::hypot(y[1], y[2]), most = mu * law.least;
  if (now > most) y[1] *= most / now, y[2] *= most / now;
}

}  // namespace

void System::resize(std::size_t points) {
  const std::size_t n = 3 * points;
  laws.assign(points, PointLaw{});
  A.assign(n * n, 0.0), b.assign(n, 0.0), r.assign(n, 0.0);
  guess_.assign(points, PointState::open), pressed_.assign(points, false);
}

double System::velocity(std::size_t row) const {
  const std::size_t n = unknowns();
  const double* const a = A.data() + row * n;
  double w = b[row];
  for (std::size_t j = 0; j < n; ++j) w += a[j] * r[j];
  return w;
}

void System::velocities(std::vector<double>& w) const {
  w.resize(unknowns());
  for (std::size_t i = 0; i < w.size(); ++i) w[i] = velocity(i);
}

double System::scale() const {
  double most = 0;
  for (const double x : b) most = std::max(most, std::fabs(x));
  for (std::size_t i = 0; i < points(); ++i) most = std::max(most, laws[i].least * element(3 * i, 3 * i));
  return most;
}

// dw_n/dN, with the friction of a sliding point. Not positive: no finite force keeps the point apart (Painlevé).
double System::normal_mobility(std::size_t point) const {
  const std::size_t n = 3 * point;
  const PointLaw& law = laws[point];
  double a = element(n, n);
  if (law.slipping) a -= law.friction * (element(n, n + 1) * law.direction[0] + element(n, n + 2) * law.direction[1]);
  return a;
}

// The larger eigenvalue of the tangential 2x2 block.
double System::tangent_mobility(std::size_t point) const {
  const std::size_t t = 3 * point + 1;
  const double xx = element(t, t), yy = element(t + 1, t + 1), xy = element(t, t + 1);
  return 0.5 * (xx + yy + std::hypot(xx - yy, 2 * xy));
}

void System::relax_normal(std::size_t point) {
  const std::size_t n = 3 * point;
  const double a = normal_mobility(point);
  const PointLaw& law = laws[point];
  if (!(a > 0)) return;
  r[n] = std::max(law.least, r[n] - velocity(n) / a);
  if (law.slipping) r[n + 1] = -law.friction * r[n] * law.direction[0], r[n + 2] = -law.friction * r[n] * law.direction[1];
}

void System::relax_friction(std::size_t point) {
  const std::size_t n = 3 * point;
  const PointLaw& law = laws[point];
  if (law.slipping) return;
  const double a = tangent_mobility(point), most = law.friction * r[n];
  if (!(a > 0) || !(most > 0)) {
    r[n + 1] = r[n + 2] = 0;
    return;
  }
  for (int k = 0; k < 3; ++k) {
    const double t1 = r[n + 1] - velocity(n + 1) / a, t2 = r[n + 2] - velocity(n + 2) / a, size = std::hypot(t1, t2);
    const double shorten = size > most ? most / size : 1;
    r[n + 1] = shorten * t1, r[n + 2] = shorten * t2;
  }
}

void System::relax(std::size_t point) {
  relax_normal(point);
  relax_friction(point);
}

double System::violation(std::size_t point) const {
  const std::size_t n = 3 * point;
  const PointLaw& law = laws[point];
  const double a = element(n, n), N = r[n];
  const double wn = velocity(n);
  double worst = a > 0 ? std::fabs(N - std::max(law.least, N - wn / a)) * a : std::max(0.0, -wn);
  const double at = tangent_mobility(point);
  if (!(at > 0)) return worst;
  if (law.slipping) {
    worst = std::max(
        worst, std::hypot(r[n + 1] + law.friction * N * law.direction[0], r[n + 2] + law.friction * N * law.direction[1]) * at);
  } else {
    const double t1 = r[n + 1] - velocity(n + 1) / at, t2 = r[n + 2] - velocity(n + 2) / at, size = std::hypot(t1, t2);
    const double most = law.friction * std::max(N, 0.0), shorten = size > most ? most / size : 1;
    worst = std::max(worst, std::hypot(r[n + 1] - shorten * t1, r[n + 2] - shorten * t2) * at);
  }
  return worst;
}

double System::residual() const {
  const double size = scale();
  double worst = 0;
  for (std::size_t i = 0; i < points(); ++i) worst = std::max(worst, violation(i));
  if (!std::isfinite(worst)) return HUGE_VAL;
  return size > 0 ? worst / size : worst;
}

PointState System::state(std::size_t point) const {
  const std::size_t n = 3 * point;
  const PointLaw& law = laws[point];
  if (!(r[n] > 0)) return PointState::open;
  if (law.slipping) return PointState::slip;
  return std::hypot(velocity(n + 1), velocity(n + 2)) > still * scale() ? PointState::slip : PointState::stick;
}

double System::energy_change() const {
  double sum = 0;
  for (std::size_t i = 0; i < unknowns(); ++i) sum += 0.5 * r[i] * (b[i] + velocity(i));
  return sum;
}

// What the projections of the law say at the iterate: which points press, and which of them slip.
void System::classify() {
  for (std::size_t i = 0; i < points(); ++i) {
    const std::size_t n = 3 * i;
    const PointLaw& law = laws[i];
    const double a = element(n, n), N = a > 0 ? r[n] - velocity(n) / a : r[n];
    pressed_[i] = N > law.least;
    const double most = law.friction * std::max(N, law.least), at = tangent_mobility(i);
    if (!(most > 0) || !(at > 0)) {
      guess_[i] = PointState::open;  // without friction
      continue;
    }
    const double w1 = velocity(n + 1), w2 = velocity(n + 2);
    const bool full = std::hypot(r[n + 1] - w1 / at, r[n + 2] - w2 / at) > most;
    guess_[i] = law.slipping || (full && (w1 != 0 || w2 != 0)) ? PointState::slip : PointState::stick;
  }
}

// One Newton step of the equations of the guessed states: w_n = 0 or N = N0; w_t = 0 or t + μ N w_t/|w_t| = 0.
bool System::newton_step() {
  const std::size_t n = unknowns();
  matrix_.assign(n * n, 0.0), right_.assign(n, 0.0);
  const auto row_of = [&](std::size_t i) { return matrix_.data() + i * n; };
  for (std::size_t i = 0; i < points(); ++i) {
    const std::size_t at = 3 * i;
    const PointLaw& law = laws[i];
    double* const normal = row_of(at);
    if (pressed_[i]) {
      std::copy_n(A.data() + at * n, n, normal);
      right_[at] = -velocity(at);
    } else {
      normal[at] = 1, right_[at] = law.least - r[at];
    }
    for (std::size_t d = 1; d <= 2; ++d) {
      double* const row = row_of(at + d);
      if (guess_[i] == PointState::stick) {
        std::copy_n(A.data() + (at + d) * n, n, row);
        right_[at + d] = -velocity(at + d);
      } else if (guess_[i] == PointState::open) {
        row[at + d] = 1, right_[at + d] = -r[at + d];
      } else if (law.slipping) {
        row[at + d] = 1, row[at] = law.friction * law.direction[d - 1];
        right_[at + d] = -(r[at + d] + law.friction * r[at] * law.direction[d - 1]);
      } else {
        const double w1 = velocity(at + 1), w2 = velocity(at + 2), speed = std::hypot(w1, w2);
        if (!(speed > 0)) return false;
        const double s[2] = {w1 / speed, w2 / speed}, turn = law.friction * r[at] / speed;
        for (std::size_t j = 0; j < n; ++j) {
          const double along = s[0] * element(at + 1, j) + s[1] * element(at + 2, j);
          row[j] = turn * (element(at + d, j) - along * s[d - 1]);
        }
        row[at + d] += 1, row[at] += law.friction * s[d - 1];
        right_[at + d] = -(r[at + d] + law.friction * r[at] * s[d - 1]);
      }
    }
  }
  if (!solve_linear(matrix_, right_, column_of_, Solution::least)) return false;
  for (std::size_t i = 0; i < n; ++i) r[i] += right_[i];
  return true;
}

// Newton's method on the projections of the law, from the iterate; keeps the best one. True if that is a solution.
bool System::polish() {
  kept_ = r;
  double best = residual();
  for (int k = 0; k < 20 && best > 1e-16; ++k) {
    classify();
    if (!newton_step()) break;
    const double now = residual();
    if (now < best) {
      best = now, kept_ = r;
    } else if (best <= solved || now > 1e3) {
      break;
    }
  }
  r = kept_;
  if (best > solved) return false;
  trim();
  return true;
}

// Rounding leaves no pull and no friction beyond the cone.
void System::trim() {
  for (std::size_t i = 0; i < points(); ++i) {
    const std::size_t n = 3 * i;
    const PointLaw& law = laws[i];
    r[n] = std::max(r[n], law.least);
    const double most = law.friction * r[n], size = std::hypot(r[n + 1], r[n + 2]);
    if (size > most) r[n + 1] *= most / size, r[n + 2] *= most / size;
  }
}

bool System::accept() {
  if (residual() > acceptable_) return false;
  trim();
  return true;
}

// Sweeps of projections, with Newton's method from time to time.
bool System::sweep(int sweeps) {
  int next = sweeps_before_polish;
  for (int k = 1; k <= sweeps; ++k) {
    for (std::size_t i = 0; i < points(); ++i) relax(i);
    if (k < next) continue;
    next = k + std::max(sweeps_before_polish, k / 2);
    if (polish()) return true;
  }
  return accept();
}

// One sweep towards the minimum of ½ rᵀA r + bᵀr over the cones of friction, whose velocities are unique. Where nothing slips
// there, it obeys Coulomb's law as well: of several solutions of that law the one that dissipates most.
double System::descend() {
  double most = 0;
  for (std::size_t i = 0; i < points(); ++i) {
    const std::size_t n = 3 * i;
    const PointLaw& law = laws[i];
    double* const own = r.data() + n;
    const double before[3] = {own[0], own[1], own[2]};
    if (law.slipping || !(law.friction > 0)) {
      relax_normal(i);
    } else {
      const double size = element(n, n) + tangent_mobility(i);  // at least the largest eigenvalue of the block
      if (!(size > 0)) continue;
      double y[3];
      for (std::size_t d = 0; d < 3; ++d) y[d] = own[d] - velocity(n + d) / size;
      project_on_cone(law, y);
      std::copy_n(y, 3, own);
    }
    for (std::size_t d = 0; d < 3; ++d) most = std::max(most, std::fabs(own[d] - before[d]) * element(n, n));
  }
  return most;
}

// All points press and none begins to slip: the least forces, if they obey the law. True for most bodies at rest, where the
// forces of redundant points are open and projections converge slowly.
bool System::solve_at_rest() {
  kept_ = r;
  for (std::size_t i = 0; i < points(); ++i) {
    pressed_[i] = true;
    guess_[i] = laws[i].slipping ? PointState::slip : laws[i].friction > 0 ? PointState::stick : PointState::open;
  }
  std::fill(r.begin(), r.end(), 0.0);
  if (newton_step() && accept()) return true;
  r = kept_;
  return false;
}

// Newton's method on the law itself, as one block, with the identity for J and A for Y (C4).
bool System::newton() {
  static constexpr double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::size_t n = unknowns();
  newton_.clear({static_cast<int>(n)});
  kept_.clear();
  for (std::size_t i = 0; i < points(); ++i) {
    double* const own = r.data() + 3 * i;
    if (element(3 * i, 3 * i) > 0) {
      newton_.add({.parts = {{{0, static_cast<int>(3 * i), 3, identity, A.data() + 3 * i * n}, {}}},
                   .friction = laws[i].friction,
                   .least = laws[i].least,
                   .slipping = laws[i].slipping,
                   .direction = laws[i].direction,
                   .b = {b[3 * i], b[3 * i + 1], b[3 * i + 2]}});
      kept_.insert(kept_.end(), own, own + 3);
    } else {
      own[0] = laws[i].least, own[1] = own[2] = 0;
    }
  }
  newton_.solve(kept_.data(), solved);
  const double* next = kept_.data();
  for (std::size_t i = 0; i < points(); ++i)
    if (element(3 * i, 3 * i) > 0) std::copy_n(next, 3, r.data() + 3 * i), next += 3;
  return polish() || accept();
}

bool System::solve(double acceptable) {
  acceptable_ = acceptable;
  for (std::size_t i = 0; i < points(); ++i) r[3 * i] = std::max(r[3 * i], laws[i].least);
  if (scale() == 0) {
    bool rests = true;
    for (const PointLaw& law : laws) rests = rests && law.least == 0;
    if (rests) {
      std::fill(r.begin(), r.end(), 0.0);
      return true;
    }
  }
  if (points() == 1 && solve_point(A.data(), b.data(), laws[0], r.data())) return true;
  if (solve_at_rest()) return true;
  const double size = scale();
  for (int k = 0; k < 50 && descend() > 1e-6 * size; ++k) {
  }
  if (polish()) return true;
  if (sweep(100) || newton()) return true;
  for (std::size_t i = 0; i < points(); ++i) r[3 * i] = laws[i].least, r[3 * i + 1] = r[3 * i + 2] = 0;
  return newton() || sweep(1000);
}

}  // namespace momentree::contact
