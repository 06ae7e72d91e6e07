#include <momentree/contact/law_newton.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <momentree/contact/indices.hpp>

namespace momentree::contact {

namespace {

constexpr double first_yield = 1e-3, least_yield = 1e-12;      // ε
constexpr double most_yield = 1e-2, least_whole_yield = 1e-9;  // the same with whole steps
constexpr double vanishing = 1e-14;                            // velocity, relative to the largest one before
constexpr double minimal = 1e-6;                               // how near a minimum is enough, relative to the forces
constexpr double worthwhile = 0.9;                             // of a residual, to be worth other impulses
constexpr double far = 1e-3;                                   // where it was not found
constexpr int most_problems = 60, most_idle = 20;              // in all, and those that hardly improve the residual
constexpr int most_newton_steps = 30, most_flat = 10;          // in a problem, and those that hardly improve it
constexpr int most_whole_steps = 40, most_idle_steps = 5;      // in all, and those that do not improve what is enough
constexpr int most_shorter = 2;                                // lengths of a step: more lead into local minima

// Adds three columns of Y times three rows of KJ to a block. Told that they do not overlap, compilers use vector instructions.
template <class Rows, class Columns, class N>
void add_product(const double* __restrict Y, const double* __restrict KJ, double* __restrict block, Rows rows, Columns columns,
                 N n) {
  for (std::size_t k = 0; k < rows; ++k)
    for (std::size_t j = 0; j < n; ++j)
      block[k * columns + j] += Y[k] * KJ[j] + Y[rows + k] * KJ[n + j] + Y[2 * rows + k] * KJ[2 * n + j];
}

// The nearest tangential part that is not longer than `most`, and its derivative H.
void project_disc(const double* y, double most, double* r, std::array<double, 9>& H) {
  const double t = length_of(y[1], y[2]), shorten = t > most ? most / t : most > 0 ? 1 : 0;
  r[1] = shorten * y[1], r[2] = shorten * y[2];
  for (std::size_t i = 1; i < 3; ++i)
    for (std::size_t j = 1; j < 3; ++j) H[3 * i + j] = shorten * ((i == j ? 1 : 0) - (t > most ? y[i] * y[j] / (t * t) : 0));
}

// The nearest point of the cone of friction with N ≥ least, and its derivative H.
void project(const LawNewton::Point& law, const double* y, double* r, std::array<double, 9>& H) {
  const double mu = law.friction, t = length_of(y[1], y[2]);
  H = {};
  if (!(mu > 0)) {
    r[0] = std::max(law.least, y[0]), r[1] = r[2] = 0;
    H[0] = y[0] > law.least ? 1 : 0;
    return;
  }
  const double s[2] = {t > 0 ? y[1] / t : 1, t > 0 ? y[2] / t : 0};
  const double N = t <= mu * y[0] ? y[0] : (y[0] + mu * t) / (1 + mu * mu);
  if (N > law.least && t <= mu * y[0]) {
    std::copy_n(y, 3, r);
    H[0] = H[4] = H[8] = 1;
  } else if (N > law.least) {
    r[0] = N, r[1] = mu * N * s[0], r[2] = mu * N * s[1];
    const double along[3] = {1, mu * s[0], mu * s[1]}, turn = mu * N / t;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        H[3 * i + j] = along[i] * along[j] / (1 + mu * mu);
        if (i > 0 && j > 0) H[3 * i + j] += turn * ((i == j ? 1 : 0) - s[i - 1] * s[j - 1]);
      }
  } else {
    r[0] = law.least;
    project_disc(y, mu * law.least, r, H);
  }
}

}  // namespace

void LawMatrix::clear(const std::vector<int>& sizes) {
  sizes_ = sizes;
  points.clear();
}

void LawMatrix::prepare() {
  matrix_.clear(sizes_);
  A.assign(points.size(), {}), K.assign(points.size(), {});
  const bool moments = std::ranges::any_of(points, [](const Point& point) { return point.pressed_by >= 0; });
  G.assign(moments ? points.size() : 0, {});
  tangential.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& point = points[i];
    if (point.parts[0].block >= 0 && point.parts[1].block >= 0) matrix_.connect(point.parts[0].block, point.parts[1].block);
    std::array<double, 9>& own = A[i];
    for (const Part& one : point.parts)
      for (const Part& other : point.parts) {
        if (one.block < 0 || one.block != other.block) continue;
        const std::size_t n = at(one.count), whole = size_of(one);
        for (std::size_t row = 0; row < 3; ++row)
          for (std::size_t column = 0; column < 3; ++column)
            for (std::size_t k = 0; k < n; ++k)
              own[3 * row + column] += one.J[row * n + k] * other.Y[column * whole + at(one.first) + k];
      }
    tangential[i] = 0.5 * (own[4] + own[8] + length_of(own[4] - own[8], own[5] + own[7]));
    if (point.pressed_by >= 0 && !(own[0] > 0)) own[0] = tangential[i];
  }
  matrix_.analyse();
  x_.resize(matrix_.unknowns()), c.resize(3 * points.size());
}

void LawMatrix::find_velocities(const double* r, std::vector<double>& w) {
  w.resize(3 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) std::copy_n(points[i].b.data(), 3, w.data() + 3 * i);
  add_change(r, w.data());
}

void LawMatrix::add_change(const double* r, double* w) {
  std::fill(x_.begin(), x_.end(), 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) add_motion(points[i], r + 3 * i);
  for (std::size_t i = 0; i < points.size(); ++i) add_velocity(points[i], w + 3 * i);
}

// Adds Σ Y r of a point to x_.
void LawMatrix::add_motion(const Point& point, const double* r) {
  for (const Part& part : point.parts)
    if (part.block >= 0)
      sized(size_of(part), [&](auto n) {
        double* const x = x_.data() + matrix_.first(part.block);
        for (std::size_t k = 0; k < n; ++k) x[k] += part.Y[k] * r[0] + part.Y[n + k] * r[1] + part.Y[2 * n + k] * r[2];
      });
}

// Adds J x_ of a point to w.
void LawMatrix::add_velocity(const Point& point, double* w) const {
  for (const Part& part : point.parts)
    if (part.block >= 0)
      sized(at(part.count), [&](auto n) {
        const double* const x = x_.data() + matrix_.first(part.block) + part.first;
        double sum[3] = {};
        for (std::size_t k = 0; k < n; ++k)
          sum[0] += part.J[k] * x[k], sum[1] += part.J[n + k] * x[k], sum[2] += part.J[2 * n + k] * x[k];
        for (std::size_t row = 0; row < 3; ++row) w[row] += sum[row];
      });
}

// Adds Y K J to the matrix: impulses of a point by velocities of another, or of itself.
void LawMatrix::add_matrix(const Point& point, const Point& by, const std::array<double, 9>& factors) {
  for (const Part& other : by.parts) {
    if (other.block < 0) continue;
    KJ_.resize(3 * at(other.count));
    double* const KJ = KJ_.data();
    sized(at(other.count), [&](auto n) {
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t j = 0; j < n; ++j)
          KJ[k * n + j] =
              factors[3 * k] * other.J[j] + factors[3 * k + 1] * other.J[n + j] + factors[3 * k + 2] * other.J[2 * n + j];
    });
    for (const Part& part : point.parts) {
      if (part.block < 0) continue;
      double* const block = matrix_.block(part.block, other.block) + other.first;
      all_sized([&](auto rows, auto columns, auto n) { add_product(part.Y, KJ, block, rows, columns, n); }, size_of(part),
                size_of(other), at(other.count));
    }
  }
}

bool LawMatrix::solve(std::vector<double>& step) {
  matrix_.reset();
  std::fill(x_.begin(), x_.end(), 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    add_motion(points[i], c.data() + 3 * i);
    if (K[i] != std::array<double, 9>{}) add_matrix(points[i], points[i], K[i]);
    if (points[i].pressed_by >= 0) add_matrix(points[i], points[at(points[i].pressed_by)], G[i]);
  }
  if (!matrix_.factorise()) return false;
  matrix_.solve(x_.data());
  step = c;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double dw[3] = {};
    add_velocity(points[i], dw);
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l) step[3 * i + k] -= K[i][3 * k + l] * dw[l];
    if (points[i].pressed_by < 0) continue;
    double pressing[3] = {};
    add_velocity(points[at(points[i].pressed_by)], pressing);
    for (std::size_t k = 0; k < 3; ++k) step[3 * i + k] -= G[i][3 * k] * pressing[0];
  }
  return std::ranges::all_of(step, [](double x) { return std::isfinite(x); });
}

void LawNewton::prepare() {
  if (std::exchange(prepared_, true)) return;
  law_.prepare();
  normal_.resize(law_.points.size());
  scale_ = 0;
  for (std::size_t i = 0; i < law_.points.size(); ++i) {
    for (const double b : law_.points[i].b) scale_ = std::max(scale_, std::fabs(b));
    scale_ = std::max(scale_, law_.points[i].least * law_.A[i][0]);
  }
}

// (C3) with yield (C5) at the velocities w_: F = a (r − P(r − w/a)). Returns Σ |F|²/a. With c and K its derivative: F vanishes
// for Δr = c − K Δw, to first order.
double LawNewton::natural_map(const double* r, bool linearise) {
  double square = 0;
  for (std::size_t i = 0; i < law_.points.size(); ++i) {
    const Point& point = law_.points[i];
    const bool moment = point.pressed_by >= 0;
    const std::size_t by = moment ? at(point.pressed_by) : i;
    const double *const own = r + 3 * i, a = law_.A[i][0], d = law_.tangential[i], mu = point.friction;
    double w[3];
    for (std::size_t k = 0; k < 3; ++k) w[k] = w_[3 * i + k] + yield_ * (k == 0 ? a : d) * (own[k] - centre_[3 * i + k]);
    const double free = own[0] - w[0] / a;
    normal_[i] = moment ? normal_[by] : std::max(point.least, free);
    // The first row: an impulse that holds or presses, or that of a bound.
    const double twist = point.torsion * normal_[i], bound = moment ? std::clamp(free, -twist, twist) : point.least;
    const bool pressed = moment ? std::fabs(free) < twist : free > point.least;
    const double most = mu * normal_[i];
    double* const c = law_.c.data() + 3 * i;
    std::array<double, 9>& K = law_.K[i];
    double F[3] = {pressed ? w[0] : a * (own[0] - bound), d * own[1], d * own[2]};
    // Bounds follow ΔN = c − K Δw of the point that presses.
    const auto follows = [&](std::size_t row, double part) {
      (moment ? law_.G : law_.K)[i][3 * row] = part * law_.K[by][0];
      return part * (r[3 * by] + law_.c[3 * by]);
    };
    if (linearise) {
      K = {};
      if (moment) law_.G[i] = {};
      c[0] = pressed ? -w[0] / (yield_ * a) : bound - own[0], c[1] = -own[1], c[2] = -own[2];
      K[0] = pressed ? 1 / (yield_ * a) : 0;
      if (moment && !pressed) c[0] = follows(0, std::copysign(point.torsion, free)) - own[0];
    }
    // The force of friction without its bound; of a prescribed motion, its direction.
    const double t[2] = {d > 0 ? own[1] - w[1] / d : -w[1], d > 0 ? own[2] - w[2] / d : -w[2]}, size = length_of(t[0], t[1]);
    const bool sticks = !point.slipping && d > 0 && size <= most && most > 0;
    if (mu > 0 && sticks) {
      F[1] = w[1], F[2] = w[2];
      if (linearise)
        for (std::size_t k = 1; k < 3; ++k) c[k] = -w[k] / (yield_ * d), K[4 * k] = 1 / (yield_ * d);
    } else if (mu > 0 && (point.slipping || size > 0)) {  // t = μ N s
      const bool turns = !point.slipping && d > 0;        // s, with what is across it
      const double s[2] = {point.slipping ? -point.direction[0] : t[0] / size,
                           point.slipping ? -point.direction[1] : t[1] / size};
      for (std::size_t k = 0; k < 2; ++k) F[k + 1] = (d > 0 ? d : a) * (own[k + 1] - most * s[k]);
      if (linearise) {
        const double across[2] = {-s[1], s[0]}, ratio = turns ? most / size : 0, yields = 1 - ratio + ratio * yield_;
        const double off = (across[0] * own[1] + across[1] * own[2]) * (1 / yields - 1);
        for (std::size_t k = 0; k < 2; ++k) {
          c[k + 1] = follows(k + 1, mu * s[k]) - own[k + 1] - off * across[k];
          for (std::size_t l = 0; turns && l < 2; ++l) K[3 * (k + 1) + l + 1] = ratio / (d * yields) * across[k] * across[l];
        }
      }
    }
    for (const double f : F) square += f * f / a;
  }
  return square;
}

double LawNewton::residual(const double* r) {
  prepare();
  law_.find_velocities(r, w_);
  return violation(r);
}

// The largest violation of (C3) at the velocities w_.
double LawNewton::violation(const double* r) const {
  double worst = 0;
  for (std::size_t i = 0; i < law_.points.size(); ++i) {
    const Point& point = law_.points[i];
    const double *const own = r + 3 * i, *const w = w_.data() + 3 * i, a = law_.A[i][0], d = law_.tangential[i];
    const double N = std::max(point.pressed_by >= 0 ? r[3 * point.pressed_by] : own[0], 0.0);
    const double most = point.friction * N, twist = point.torsion * N, unit = d > 0 ? d : a;
    const double t1 = own[1] - w[1] / unit, t2 = own[2] - w[2] / unit, size = length_of(t1, t2);
    const double shorten = size > most ? most / size : 1;
    const double free = own[0] - w[0] / a;
    const double nearest = point.pressed_by >= 0 ? std::clamp(free, -twist, twist) : std::max(point.least, free);
    const double normal = std::fabs(own[0] - nearest) * a;
    double tangential = length_of(own[1] - shorten * t1, own[2] - shorten * t2) * unit;
    if (point.slipping) tangential = length_of(own[1] + most * point.direction[0], own[2] + most * point.direction[1]) * unit;
    if (!std::isfinite(normal + tangential)) return HUGE_VAL;
    worst = std::max(worst, std::max(normal, tangential) - round_off * a * std::fabs(own[0]));
  }
  return scale_ > 0 ? worst / scale_ : worst;
}

// The law itself, with yield about centre_: steps from r_ are halved until |F| decreases. Where it hardly does, a whole step
// leaves the local minimum. False if no solution was found.
bool LawNewton::newton() {
  double inertia = 0;  // Σ 1/a
  for (const std::array<double, 9>& A : law_.A) inertia += 1 / A[0];
  const double small = std::max(vanishing, 0.1 * accuracy_) * scale_;
  const auto map = [this](bool linearise) {
    law_.find_velocities(r_.data(), w_);
    return natural_map(r_.data(), linearise);
  };
  double now = map(true);
  for (int k = 0, flat = 0; k < most_newton_steps && now > small * small * inertia && flat < most_flat && law_.solve(step_);
       ++k) {
    from_ = r_;
    const auto step_to = [&](double length) {
      for (std::size_t i = 0; i < r_.size(); ++i) r_[i] = from_[i] + length * step_[i];
    };
    double best = HUGE_VAL, best_length = 1, length = 1;
    for (int j = 0; j < most_shorter; ++j, length *= 0.5) {
      step_to(length);
      const double next = map(false);
      if (next < best) best = next, best_length = length;
      if (next < (1 - 1e-4 * length) * now) break;
    }
    flat += best > 0.999 * now ? 1 : 0;
    step_to(best > 0.97 * now ? 1 : best_length);
    now = map(true);
  }
  return now <= small * small * inertia;
}

// (C6) of a point with velocity w; with K the derivative.
void LawNewton::find_nearest(std::size_t point, const double* w, double* r, bool linearise) {
  const double delta = yield_ * std::max(law_.A[point][0], law_.tangential[point]);
  double y[3];
  for (std::size_t k = 0; k < 3; ++k) y[k] = centre_[3 * point + k] - (w[k] + (k == 0 ? shift_[point] : 0)) / delta;
  std::array<double, 9> H{};
  if (const Point& law = law_.points[point]; law.slipping) {  // with the friction of the last solution
    r[0] = std::max(law.least, y[0]), H[0] = y[0] > law.least ? 1 : 0;
    for (std::size_t k = 0; k < 2; ++k) r[k + 1] = -law.friction * std::max(law.least, centre_[3 * point]) * law.direction[k];
  } else if (law.pressed_by >= 0) {  // moments within bounds of the last solution
    const double N = std::max(0.0, centre_[3 * at(law.pressed_by)]), twist = law.torsion * N;
    project_disc(y, law.friction * N, r, H);
    r[0] = std::clamp(y[0], -twist, twist), H[0] = std::fabs(y[0]) < twist ? 1 : 0;
  } else {
    project(law, y, r, H);
  }
  if (!linearise) return;
  for (std::size_t k = 0; k < 9; ++k) law_.K[point][k] = H[k] / delta;
}

// The slope of the function that (C6) minimises, that far along the step: (r − Π)ᵀ Δw.
double LawNewton::slope(double length) {
  double sum = 0;
  for (std::size_t i = 0; i < law_.points.size(); ++i) {
    double w[3], to[3];
    for (std::size_t k = 0; k < 3; ++k) w[k] = w_[3 * i + k] + length * moved_[3 * i + k];
    find_nearest(i, w, to, false);
    for (std::size_t k = 0; k < 3; ++k) sum += (r_[3 * i + k] + length * step_[3 * i + k] - to[k]) * moved_[3 * i + k];
  }
  return sum;
}

// The length of the step at which that slope is nearly zero, at most 1.
double LawNewton::find_length() {
  constexpr double nearly = 0.1;  // of the slope at the start
  constexpr int most_tries = 20;
  double low = 0, high = 1, at_low = slope(0), at_high = slope(1), length = 1;
  const double zero = nearly * std::fabs(at_low);
  if (!(at_high > zero)) return 1;
  for (int k = 0; k < most_tries; ++k) {
    length = k % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * at_low / (at_low - at_high);
    const double now = slope(length);
    if (std::fabs(now) < zero) break;
    (now < 0 ? low : high) = length, (now < 0 ? at_low : at_high) = now;
  }
  return length;
}

// (C6) of all points, from r_. Returns how far r_ is from them, relative to the forces.
double LawNewton::minimise() {
  double off = 0;
  for (int step = 0; step < most_newton_steps; ++step) {
    law_.find_velocities(r_.data(), w_);
    double size = 0;
    off = 0;
    for (std::size_t i = 0; i < law_.points.size(); ++i) {
      double to[3];
      find_nearest(i, w_.data() + 3 * i, to, true);
      for (std::size_t k = 0; k < 3; ++k) {
        law_.c[3 * i + k] = to[k] - r_[3 * i + k];
        off = std::max(off, std::fabs(law_.c[3 * i + k])), size = std::max(size, std::fabs(to[k]));
      }
    }
    if (size > 0) off /= size;
    if (off < minimal || !law_.solve(step_)) break;
    moved_.assign(r_.size(), 0.0);
    law_.add_change(step_.data(), moved_.data());
    const double length = find_length();
    for (std::size_t i = 0; i < r_.size(); ++i) r_[i] += length * step_[i];
  }
  return off;
}

// Newton's method without shorter steps, from r_: the law yields the less, the better it is obeyed. Of 1,734 problems of a pile
// of 100 boxes that fall on each other, two needed more, and 3.6 steps were enough on average. Leaves the best impulses in best_
// and returns their residual.
double LawNewton::take_whole_steps(double accuracy, double enough) {
  best_ = r_;
  double best = residual(r_.data()), now = best;
  for (int k = 0, idle = 0; k < most_whole_steps && best > accuracy && (best > enough || idle < most_idle_steps); ++k) {
    yield_ = std::clamp(10 * now, least_whole_yield, most_yield), centre_ = r_;
    natural_map(r_.data(), true);
    if (!law_.solve(step_)) break;
    for (std::size_t i = 0; i < r_.size(); ++i) r_[i] += step_[i];
    now = residual(r_.data());
    ++idle;
    if (now < worthwhile * best)
      best = now, best_ = r_, idle = 0;  // where rows contradict each other, forces grow for next to nothing
  }
  return best;
}

// A sequence of problems with less and less yield, from best_, whose residual is `best`. Each is solved with shorter steps, if
// need be from the minimum of (C6).
double LawNewton::take_shorter_steps(double best, double accuracy) {
  r_ = best_;
  const auto note = [&] {
    const double now = residual(r_.data());
    if (now < worthwhile * best) best = now, best_ = r_;
    return now;
  };
  yield_ = first_yield, accuracy_ = accuracy;
  shift_.assign(law_.points.size(), 0.0);
  double shrink = 0.1;
  bool nearby = std::any_of(r_.begin(), r_.end(), [](double x) { return x != 0; });  // Newton's method converges from r_
  for (int k = 0, idle = 0; k < most_problems && best > accuracy && idle < most_idle; ++k) {
    const double before = best;
    centre_ = r_;
    if (!nearby) {
      law_.find_velocities(r_.data(), w_);
      // At first s = 0: where nothing slips then, the law is obeyed. Later half of the change, since s may alternate.
      for (std::size_t i = 0; i < law_.points.size() && k > 0; ++i)
        if (law_.points[i].pressed_by < 0)
          shift_[i] = 0.5 * (shift_[i] + law_.points[i].friction * length_of(w_[3 * i + 1], w_[3 * i + 2]));
      if (minimise() > far) {  // more slowly
        r_ = centre_, yield_ = std::min(5 * yield_, 1.0), shrink = 0.4;
        continue;
      }
    }
    minimum_ = r_;
    const double associated = nearby ? best : note();
    if (best <= accuracy) break;
    const bool found = newton();
    const double now = note();
    if (!(now < associated)) r_ = minimum_;
    idle = best < before ? 0 : idle + 1;
    if (std::exchange(nearby, found && yield_ > least_yield) && !nearby) continue;
    yield_ = std::max((nearby && !(now < 0.3 * before) ? 0.01 : shrink) * yield_, least_yield);  // the law may be obeyed far away
  }
  return best;
}

double LawNewton::solve(double* r, double accuracy, double enough) {
  if (law_.points.empty()) return 0;
  prepare();
  r_.assign(r, r + 3 * law_.points.size());
  double best = take_whole_steps(accuracy, enough);
  if (best > enough) best = take_shorter_steps(best, enough);
  take_best(r);
  return best;
}

double LawNewton::solve_carefully(double* r, double accuracy) {
  if (law_.points.empty()) return 0;
  prepare();
  best_.assign(r, r + 3 * law_.points.size());
  const double best = take_shorter_steps(residual(r), accuracy);
  take_best(r);
  return best;
}

// Rounding leaves no pull and no friction beyond the cone.
void LawNewton::take_best(double* r) {
  for (std::size_t i = 0; i < law_.points.size(); ++i) {
    const Point& point = law_.points[i];
    double* const own = best_.data() + 3 * i;
    const double N = point.pressed_by >= 0 ? best_[3 * at(point.pressed_by)] : std::max(own[0], point.least);
    own[0] = point.pressed_by >= 0 ? std::clamp(own[0], -point.torsion * N, point.torsion * N) : N;
    const double most = point.friction * N, size = length_of(own[1], own[2]);
    if (size > most) own[1] *= most / size, own[2] *= most / size;
  }
  std::copy(best_.begin(), best_.end(), r);
}

}  // namespace momentree::contact
