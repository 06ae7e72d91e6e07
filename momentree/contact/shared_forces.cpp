#include <momentree/contact/shared_forces.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace momentree::contact {

namespace {

constexpr double rounding_of_rows = 1e-13;         // residual of Q x = b
constexpr double smoothest = 1, sharpest = 1e-10;  // δ
constexpr double sharp_enough = 1e-4;              // for forces, which lose that many digits to rounding
constexpr double less = 1e-2;                      // by which δ decreases
constexpr int most_steps = 200;
constexpr double farthest = 1e8;  // λ where no forces are possible

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

// H = L Lᵀ in place, of a matrix that is positive definite but for rounding.
void factorise(std::vector<double>& H, std::size_t n) {
  double trace = 0;
  for (std::size_t i = 0; i < n; ++i) trace += H[i * n + i];
  const double least = 1e-12 * trace / static_cast<double>(n) + 1e-300;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = H[i * n + j];
      for (std::size_t k = 0; k < j; ++k) sum -= H[i * n + k] * H[j * n + k];
      H[i * n + j] = j < i ? sum / H[j * n + j] : std::sqrt(std::max(sum, least));
    }
}

void solve_factorised(const std::vector<double>& L, std::vector<double>& x) {
  const std::size_t n = x.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= L[i * n + k] * x[k];
    x[i] /= L[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= L[k * n + i] * x[k];
    x[i] /= L[i * n + i];
  }
}

}  // namespace

double ForceCone::margin(const std::vector<double>& x) const {
  return friction > 0 ? x[normal] - std::hypot(x[normal + 1], x[normal + 2]) / friction : x[normal];
}

void SharedForces::set(const std::vector<double>& x, const std::vector<double>& rows, std::span<const ForceCone> cones) {
  size_ = 0, unknowns_ = x.size();
  for (const double force : x) size_ = std::max(size_, std::fabs(force));
  Q_ = rows;
  cones_.assign(cones.begin(), cones.end());
  const std::size_t m = rows.size() / unknowns_;
  b_.assign(m, 0.0), Qe_.assign(m, 0.0), e_.assign(unknowns_, 0.0);
  for (const ForceCone& cone : cones_) e_[cone.normal] = 1;
  for (std::size_t k = 0; k < m; ++k)
    for (std::size_t i = 0; i < unknowns_; ++i) {
      b_[k] += Q_[k * unknowns_ + i] * x[i] / size_;
      Qe_[k] += Q_[k * unknowns_ + i] * e_[i];
    }
}

// x_ = P(sign Qᵀ λ), from point_; returns |x_|².
double SharedForces::project(double sign) {
  point_.assign(unknowns_, 0.0), x_.assign(unknowns_, 0.0);
  for (std::size_t k = 0; k < lambda_.size(); ++k)
    for (std::size_t i = 0; i < unknowns_; ++i) point_[i] += sign * lambda_[k] * Q_[k * unknowns_ + i];
  for (const ForceCone& cone : cones_) {
    const double* const from = point_.data() + cone.normal;
    double* const to = x_.data() + cone.normal;
    const double mu = cone.friction;
    if (!(mu > 0)) {
      to[0] = std::max(from[0], 0.0);
      continue;
    }
    const double t = std::hypot(from[1], from[2]);
    if (t <= mu * from[0]) {
      std::copy_n(from, 3, to);
    } else if (mu * t > -from[0]) {
      to[0] = (from[0] + mu * t) / (1 + mu * mu);
      to[1] = mu * to[0] / t * from[1], to[2] = mu * to[0] / t * from[2];
    }
  }
  return dot(x_, x_);
}

// Adds Q P' Qᵀ at point_, times a factor, to H_.
void SharedForces::add_curvature(double factor) {
  const std::size_t m = lambda_.size();
  for (const ForceCone& cone : cones_) {
    const double *const from = point_.data() + cone.normal, *const to = x_.data() + cone.normal;
    const double mu = cone.friction, t = mu > 0 ? std::hypot(from[1], from[2]) : 0;
    if (!(to[0] > 0)) continue;
    const std::size_t rows = mu > 0 ? 3 : 1;
    std::array<double, 9> D{1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (rows == 3 && t > mu * from[0]) {
      const double c = 1 / (1 + mu * mu), turn = mu * to[0] / t;
      const std::array<double, 3> s{1, mu * from[1] / t, mu * from[2] / t};
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
          D[3 * i + j] = c * s[i] * s[j];
          if (i > 0 && j > 0) D[3 * i + j] += turn * ((i == j ? 1 : 0) - s[i] * s[j] / (mu * mu));
        }
    }
    for (std::size_t k = 0; k < m; ++k) {
      const double* const own = Q_.data() + k * unknowns_ + cone.normal;
      std::array<double, 3> turned{};
      for (std::size_t i = 0; i < rows; ++i)
        for (std::size_t j = 0; j < rows; ++j) turned[j] += factor * own[i] * D[3 * i + j];
      for (std::size_t l = 0; l <= k; ++l)
        for (std::size_t i = 0; i < rows; ++i) H_[k * m + l] += turned[i] * Q_[l * unknowns_ + cone.normal + i];
    }
  }
}

// b − Q x_ times a factor, in gradient_; returns its largest part.
double SharedForces::find_gradient(double factor) {
  double most = 0;
  gradient_ = b_;
  for (std::size_t r = 0; r < b_.size(); ++r) {
    for (std::size_t i = 0; i < unknowns_; ++i) gradient_[r] -= factor * Q_[r * unknowns_ + i] * x_[i];
    most = std::max(most, std::fabs(gradient_[r]));
  }
  return most;
}

// Newton's method for the least of c/2 |P(σ Qᵀ λ)|² − σ bᵀ λ, from the present λ: (S1) for σ = 1; (S2) for σ = −1, where (Q e)ᵀ λ
// stays 1. False if it was not found.
bool SharedForces::minimise(double sign, double curvature) {
  constexpr double nearly = 1e-12;  // of the objective: Newton's method then needs one more step
  constexpr double undamped = 1e-7, least_damping = 1e-9;
  const std::size_t m = b_.size();
  const auto value = [&] { return 0.5 * curvature * project(sign) - sign * dot(b_, lambda_); };
  double now = value(), damping = 1e-2;  // relative to the curvature
  for (int k = 0; k < most_steps; ++k) {
    const double open = find_gradient(curvature);
    if (sign > 0 && open < rounding_of_rows) return true;
    if (sign > 0 && !(dot(lambda_, lambda_) < farthest * farthest)) return false;
    from_ = lambda_;
    double slope = 0;
    for (bool better = false; !better; damping *= better ? 1e-2 : 10) {
      H_.assign(m * m, 0.0);
      add_curvature(curvature);
      for (std::size_t r = 0; r < m; ++r) H_[r * m + r] += damping * curvature;
      factorise(H_, m);
      step_ = gradient_;
      solve_factorised(H_, step_);
      for (std::size_t r = 0; r < m; ++r) lambda_[r] = from_[r] + sign * step_[r];
      if (sign < 0) {
        along_ = Qe_;
        solve_factorised(H_, along_);
        const double multiplier = dot(Qe_, step_) / dot(Qe_, along_);
        for (std::size_t r = 0; r < m; ++r) lambda_[r] += multiplier * along_[r];
        const double off = (1 - dot(Qe_, lambda_)) / dot(Qe_, Qe_);  // by rounding
        for (std::size_t r = 0; r < m; ++r) lambda_[r] += off * Qe_[r];
      }
      slope = sign * (dot(gradient_, lambda_) - dot(gradient_, from_));
      const double next = value();
      better = slope < nearly || next < now - 0.1 * slope;
      if (better) {
        now = next;
      } else {
        lambda_ = from_;
        now = value();
        if (damping > 1) return false;
      }
    }
    if (sign < 0 && slope < nearly && damping < undamped) return true;
    damping = std::max(damping, least_damping);
  }
  return false;
}

// The largest s, with δ down to `smallest`.
double SharedForces::deepest(double smallest) {
  const double square = dot(Qe_, Qe_);
  constexpr double open = 1e-12;  // equations that leave all normal forces open
  if (!(square > open)) return HUGE_VAL;
  lambda_ = Qe_;
  for (double& x : lambda_) x /= square;
  double s = 0;
  for (double delta = smoothest; delta > 0.5 * smallest; delta *= less) {
    minimise(-1, 1 / delta);
    s = dot(x_, x_) / delta + dot(b_, lambda_);
  }
  return s;
}

bool SharedForces::choose(std::vector<double>& x, const std::vector<double>& rows, std::span<const ForceCone> cones) {
  set(x, rows, cones);
  if (!(size_ > 0) || !std::isfinite(size_)) return true;
  lambda_ = b_;
  possible_ = minimise(1, 1);
  if (possible_) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = size_ * x_[i];
    return true;
  }
  const double s = deepest(sharp_enough);
  if (!std::isfinite(s)) return false;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = x_[i] / sharp_enough + s * e_[i];
  for (std::size_t k = 0; k < b_.size(); ++k) {  // the equations hold, and forces are nearly these
    double open = b_[k];
    for (std::size_t i = 0; i < x.size(); ++i) open -= rows[k * x.size() + i] * x[i];
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += open * rows[k * x.size() + i];
  }
  known_margin_ = HUGE_VAL;
  for (const ForceCone& cone : cones_) known_margin_ = std::min(known_margin_, cone.margin(x));
  for (double& force : x) force *= size_;
  return possible_ = known_margin_ >= 0;  // (S1) did not converge
}

double SharedForces::margin() {
  if (!(size_ > 0) || !std::isfinite(size_)) return 0;
  const double s = deepest(sharpest);
  if (!possible_ && s > 0) return known_margin_;  // (S2) did not converge
  return std::min(s, 1.0);
}

}  // namespace momentree::contact
