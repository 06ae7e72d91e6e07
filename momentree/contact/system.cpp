#include <momentree/contact/system.hpp>

#include <algorithm>
#include <cmath>

namespace momentree::contact {

void System::resize(std::size_t points) {
  const std::size_t n = 3 * points;
  laws.assign(points, PointLaw{});
  A.assign(n * n, 0.0), b.assign(n, 0.0), r.assign(n, 0.0);
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

PointState System::state(std::size_t point) const {
  constexpr double still = 1e-12;  // relative to the largest |b|
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

// The points as one block, with the identity for J and A for Y (C4).
void System::prepare() {
  static constexpr double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::size_t n = unknowns();
  const auto more_than_rounding = [least = LawNewton::round_off * scale()](double x) { return std::fabs(x) > least ? x : 0; };
  newton_.clear({static_cast<int>(n)});
  impulses_.clear();
  for (std::size_t i = 0; i < points(); ++i) {
    const double* const own = r.data() + 3 * i;
    if (!moves(i)) continue;
    newton_.add({.parts = {{{0, static_cast<int>(3 * i), 3, identity, A.data() + 3 * i * n}, {}}},
                 .friction = laws[i].friction,
                 .least = laws[i].least,
                 .slipping = laws[i].slipping,
                 .direction = laws[i].direction,
                 .b = {more_than_rounding(b[3 * i]), more_than_rounding(b[3 * i + 1]), more_than_rounding(b[3 * i + 2])}});
    impulses_.insert(impulses_.end(), own, own + 3);
  }
}

double System::residual() {
  prepare();
  return prepared_residual();
}

double System::prepared_residual() {
  double worst = newton_.residual(impulses_.data());
  for (std::size_t i = 0; i < points(); ++i)
    if (!moves(i)) worst = std::max(worst, -b[3 * i] / scale());
  return std::isfinite(worst) ? worst : HUGE_VAL;
}

bool System::solve(double acceptable) {
  constexpr double solved = 5e-14;           // residual
  constexpr double starts[] = {0, 100, 10};  // from r; from normal forces of so many times what stops the fastest motion
  const double size = scale();
  double left = HUGE_VAL;
  for (const double start : starts) {
    if (left <= acceptable) break;
    for (std::size_t i = 0; i < unknowns(); ++i) {
      const bool normal = i % 3 == 0;
      if (start > 0) r[i] = normal && moves(i / 3) ? start * size / element(i, i) : 0;
      if (size == 0 || !moves(i / 3)) r[i] = 0;
      if (normal) r[i] = std::max(r[i], laws[i / 3].least);
    }
    prepare();
    newton_.solve_carefully(impulses_.data(), solved);
    const double* next = impulses_.data();
    for (std::size_t i = 0; i < points(); ++i)
      if (moves(i)) std::copy_n(next, 3, r.data() + 3 * i), next += 3;
    left = prepared_residual();
  }
  return left <= acceptable;
}

}  // namespace momentree::contact
