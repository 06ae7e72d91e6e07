#include <momentree/contact/impact.hpp>

#include <algorithm>
#include <cmath>

namespace momentree::contact {

namespace {

// Work of normal impulses by the mean velocities before and after.
double work_of_normals(const std::vector<double>& r, const std::vector<double>& before, const std::vector<double>& after) {
  double work = 0;
  for (std::size_t i = 0; i < r.size(); i += 3) work += 0.5 * r[i] * (before[i] + after[i]);
  return work;
}

}  // namespace

// The expansion, from the velocities after the compression.
bool ImpactLaw::expand(const System& compressed, const std::vector<double>& restitution, double s) {
  for (std::size_t i = 0; i < compressed.points(); ++i)
    expansion_.laws[i].least = s * restitution[i] * std::max(0.0, compression_[3 * i]);
  std::fill(expansion_.r.begin(), expansion_.r.end(), 0.0);
  return expansion_.solve();
}

bool ImpactLaw::fits(double most_work, double energy_lost, double tolerance) const {
  return work_of_normals(expansion_.r, expansion_.b, after_) <= most_work + tolerance &&
         expansion_.energy_change() <= energy_lost + tolerance;
}

ImpactResult ImpactLaw::together(System& system, const std::vector<double>& restitution) {
  ImpactResult result;
  for (PointLaw& law : system.laws) law.least = 0, law.slipping = false;
  std::fill(system.r.begin(), system.r.end(), 0.0);
  if (!system.solve()) {
    result.solved = false;
    return result;
  }
  compression_ = system.r;
  before_ = system.b;
  system.velocities(after_);
  const double work = work_of_normals(compression_, before_, after_);
  double most_work = 0;
  bool elastic = false;
  for (std::size_t i = 0; i < system.points(); ++i) {
    const double e = restitution[i];
    most_work -= e * e * 0.5 * compression_[3 * i] * (before_[3 * i] + after_[3 * i]);
    elastic = elastic || (e > 0 && compression_[3 * i] > 0);
  }
  if (!elastic) return result;

  expansion_.resize(system.points());
  expansion_.A = system.A, expansion_.b = after_;
  for (std::size_t i = 0; i < system.points(); ++i) expansion_.laws[i].friction = system.laws[i].friction;
  const double lost = -system.energy_change(), tolerance = 1e-14 * std::fabs(work);
  const auto accepted = [&](double s) {
    if (!expand(system, restitution, s)) return false;
    expansion_.velocities(after_);
    return fits(std::max(most_work, 0.0), lost, tolerance);
  };
  best_.assign(system.unknowns(), 0.0);
  if (accepted(1)) {
    best_ = expansion_.r;
  } else {
    double low = 0, high = 1;
    for (int k = 0; k < 20; ++k) {
      const double s = 0.5 * (low + high);
      if (accepted(s))
        low = s, best_ = expansion_.r;
      else
        high = s;
    }
    result.scale = low;
  }
  for (std::size_t i = 0; i < system.unknowns(); ++i) system.r[i] = compression_[i] + best_[i];
  return result;
}

ImpactResult ImpactLaw::in_turn(System& system, const std::vector<double>& restitution) {
  ImpactResult result;
  for (PointLaw& law : system.laws) law.least = 0, law.slipping = false;
  const std::size_t points = system.points(), n = system.unknowns();
  total_.assign(n, 0.0);
  velocity_ = system.b;
  double size = 0;
  for (const double x : velocity_) size = std::max(size, std::fabs(x));
  single_.resize(1), one_restitution_.resize(1);
  const double approach = 1e-13 * size;
  const auto fastest = [&] {
    std::size_t found = points;
    for (std::size_t i = 0; i < points; ++i)
      if (velocity_[3 * i] < -approach && (found == points || velocity_[3 * i] < velocity_[3 * found] - approach)) found = i;
    return found;
  };
  const std::size_t most = 1000 * points;
  std::size_t at = fastest();
  for (std::size_t k = 0; at != points && k < most; ++k, at = fastest()) {
    for (std::size_t i = 0; i < 3; ++i) {
      single_.b[i] = velocity_[3 * at + i];
      for (std::size_t j = 0; j < 3; ++j) single_.element(i, j) = system.element(3 * at + i, 3 * at + j);
    }
    single_.laws[0].friction = system.laws[at].friction;
    one_restitution_[0] = restitution[at];
    const ImpactResult one = together(single_, one_restitution_);
    if (!one.solved) {
      result.solved = false;
      return result;
    }
    result.scale = std::min(result.scale, one.scale);
    for (std::size_t j = 0; j < 3; ++j) total_[3 * at + j] += single_.r[j];
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < 3; ++j) velocity_[i] += system.element(i, 3 * at + j) * single_.r[j];
  }
  if (at != points) {  // they hit each other without end: the rest at once, and without rebound
    double left = 0;
    for (const double x : velocity_) left = std::max(left, std::fabs(x));
    system.b.swap(velocity_);
    std::fill(system.r.begin(), system.r.end(), 0.0);
    result.solved = system.solve(std::max(1e-11, approach / left));
    system.b.swap(velocity_);
    for (std::size_t i = 0; i < n; ++i) total_[i] += system.r[i];
  }
  system.r = total_;
  return result;
}

ImpactResult ImpactLaw::apply(System& system, const std::vector<double>& restitution, Simultaneous how) {
  if (how == Simultaneous::in_turn) return in_turn(system, restitution);
  ImpactResult result = together(system, restitution);
  if (result.solved) return result;
  result = in_turn(system, restitution);
  result.separated = true;
  return result;
}

}  // namespace momentree::contact
