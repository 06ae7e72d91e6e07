#include <momentree/contact/many_points.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>

#include <momentree/contact/indices.hpp>

namespace momentree::contact {

namespace {

constexpr int first_sweeps = 3, most_sweeps = 64;  // before Newton's method, and without it
constexpr int bisections = 8;                      // of the part of the expansion that the energy permits

// Of a symmetric 3×3 block; zero if it is nearly singular.
std::array<double, 9> inverse_of(const std::array<double, 9>& A) {
  const double a = A[4] * A[8] - A[5] * A[7], b = A[5] * A[6] - A[3] * A[8], c = A[3] * A[7] - A[4] * A[6];
  const double determinant = A[0] * a + A[1] * b + A[2] * c;
  if (!(determinant > 1e-9 * A[0] * A[4] * A[8])) return {};
  const double d = 1 / determinant;
  return {d * a, d * (A[2] * A[7] - A[1] * A[8]), d * (A[1] * A[5] - A[2] * A[4]),
          d * b, d * (A[0] * A[8] - A[2] * A[6]), d * (A[2] * A[3] - A[0] * A[5]),
          d * c, d * (A[1] * A[6] - A[0] * A[7]), d * (A[0] * A[4] - A[1] * A[3])};
}

// Adds three rows of n numbers, times a factor each. Told that they do not overlap, compilers use vector instructions.
template <class N>
void add_rows(N n, const double* __restrict rows, double r0, double r1, double r2, double* __restrict sum) {
  for (std::size_t k = 0; k < n; ++k) sum[k] += rows[k] * r0 + rows[n + k] * r1 + rows[2 * n + k] * r2;
}

}  // namespace

void MovedPoints::clear(int dofs, int groups, int bodies) {
  dofs_ = dofs;
  links.clear(bodies, groups);
  trial_.x.clear();
  points.clear(), J.clear(), Y.clear();
}

LinksMotion& MovedPoints::unmoved() {
  if (trial_.x.empty()) start(trial_);
  return trial_;
}

void ManyPoints::clear(int dofs, int groups, int bodies) {
  MovedPoints::clear(dofs, groups, bodies);
  blocks_.clear(), b.clear(), r.clear();
  parent_.resize(static_cast<std::size_t>(groups));
  std::iota(parent_.begin(), parent_.end(), 0);
}

int ManyPoints::root(int group) {
  while (parent_[static_cast<std::size_t>(group)] != group) {
    int& up = parent_[static_cast<std::size_t>(group)];
    up = parent_[static_cast<std::size_t>(up)];
    group = up;
  }
  return group;
}

// Groups that share a point are in one island. Islands, and the points in them, are in the order of the points.
void ManyPoints::prepare() {
  for (const Point& point : points) {
    if (point.parts[0].group < 0 || point.parts[1].group < 0) continue;
    const int one = root(point.parts[0].group), other = root(point.parts[1].group);
    parent_[static_cast<std::size_t>(std::max(one, other))] = std::min(one, other);
  }
  const auto island = [&](std::size_t i) {
    const auto& parts = points[i].parts;
    return root(parts[0].group >= 0 ? parts[0].group : parts[1].group);
  };
  order_.resize(points.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::stable_sort(order_.begin(), order_.end(), [&](std::size_t i, std::size_t j) { return island(i) < island(j); });
  ends_.clear();
  for (std::size_t k = 1; k <= order_.size(); ++k)
    if (k == order_.size() || island(order_[k]) != island(order_[k - 1])) ends_.push_back(k);
  blocks_.assign(points.size(), {});
  tangential_.resize(points.size()), inverses_.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::array<double, 9>& A = blocks_[i] = block(i);
    inverses_[i] = inverse_of(A);
    tangential_[i] = 0.5 * (A[4] + A[8] + length_of(A[4] - A[8], A[5] + A[7]));
  }
}

ManyPoints::Island ManyPoints::island(std::size_t number) const {
  const std::size_t first = number == 0 ? 0 : ends_[number - 1];
  return {order_.data() + first, ends_[number] - first};
}

std::array<double, 9> MovedPoints::block(std::size_t point) {
  std::array<double, 9> A{};
  const auto& parts = points[point].parts;
  if (parts[0].link >= 0 && parts[0].group == parts[1].group) {  // two bodies of one mechanism
    LinksMotion& trial = unmoved();
    for (std::size_t column = 0; column < 3; ++column) {
      double impulse[3] = {}, w[3];
      impulse[column] = 1;
      add(point, impulse, trial);
      all_along(point, trial, w);
      for (std::size_t row = 0; row < 3; ++row) A[3 * row + column] = w[row];
      impulse[column] = -1;
      add(point, impulse, trial);
    }
    return A;
  }
  for (const Part& part : parts) {
    const auto n = static_cast<std::size_t>(part.count);
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 3; ++column)
        A[3 * row + column] += std::inner_product(J.begin() + static_cast<std::ptrdiff_t>(part.at + row * n),
                                                  J.begin() + static_cast<std::ptrdiff_t>(part.at + (row + 1) * n),
                                                  Y.begin() + static_cast<std::ptrdiff_t>(part.at + column * n), 0.0);
  }
  return A;
}

void MovedPoints::forget(std::size_t point, LinksMotion& motion) const {
  for (const Part& part : points[point].parts)
    if (part.link >= 0)
      links.forget(part.group, motion);
    else
      std::fill_n(motion.x.begin() + part.first, part.count, 0.0);
}

double MovedPoints::along(std::size_t point, std::size_t row, LinksMotion& motion) {
  double sum = 0;
  for (const Part& part : points[point].parts) {
    if (part.link >= 0) links.walk(motion, part.link);
    const double* const j = J.data() + part.at + row * static_cast<std::size_t>(part.count);
    const double* const of = motion.x.data() + part.first;
    for (int k = 0; k < part.count; ++k) sum += j[k] * of[k];
  }
  return sum;
}

// All three rows in one pass: most of the time of the sweeps is spent here.
void MovedPoints::all_along(std::size_t point, LinksMotion& motion, double* w) {
  double sum[3] = {};
  for (const Part& part : points[point].parts) {
    if (part.link >= 0) links.walk(motion, part.link);
    const double *const j = J.data() + part.at, *const x = motion.x.data() + part.first;
    sized(at(part.count), [&](auto n) {
      double s0 = 0, s1 = 0, s2 = 0;
      for (std::size_t k = 0; k < n; ++k) s0 += j[k] * x[k], s1 += j[n + k] * x[k], s2 += j[2 * n + k] * x[k];
      sum[0] += s0, sum[1] += s1, sum[2] += s2;
    });
  }
  w[0] = sum[0], w[1] = sum[1], w[2] = sum[2];
}

void MovedPoints::add(std::size_t point, const double* impulse, LinksMotion& motion) {
  for (const Part& part : points[point].parts) {
    if (part.link >= 0) {
      links.walk(motion, part.link);
      add_rows(std::integral_constant<std::size_t, 6>{}, J.data() + part.at, impulse[0], impulse[1], impulse[2],
               motion.sum.data() + 6 * static_cast<std::size_t>(part.link));
    }
    const double* const y = Y.data() + part.at;
    double* const of = motion.x.data() + part.first;
    sized(at(part.count), [&](auto n) { add_rows(n, y, impulse[0], impulse[1], impulse[2], of); });
  }
}

// The law at one point, for the present impulses of all others. Returns the largest change as a velocity.
double ManyPoints::relax(std::size_t point, const std::vector<double>& start, std::vector<double>& impulses) {
  double* const own = impulses.data() + 3 * point;
  if (const int by = points[point].pressed_by; by >= 0)
    return relax_moments(point, start, std::max(0.0, impulses[3 * at(by)]), own);
  const std::array<double, 9>& A = blocks_[point];
  const double least = least_[point];
  if (!(A[0] > 0) || points[point].slack == HUGE_VAL) {  // nothing presses them together
    const double none[3] = {-own[0], -own[1], -own[2]};
    if (own[0] != 0 || own[1] != 0 || own[2] != 0) add(point, none, change_);
    own[0] = own[1] = own[2] = 0;
    return 0;
  }
  double w[3], before[3] = {own[0], own[1], own[2]};
  all_along(point, change_, w);
  for (std::size_t k = 0; k < 3; ++k) w[k] += start[3 * point + k];
  w[0] += points[point].slack;
  const double friction = points[point].friction, size = tangential_[point];
  // Open, if it then separates: friction must not wedge what no load presses.
  if (least == 0 && w[0] - A[0] * own[0] - A[1] * own[1] - A[2] * own[2] >= 0) {
    const double opened[3] = {-own[0], -own[1], -own[2]};
    own[0] = own[1] = own[2] = 0;
    if (opened[0] == 0 && opened[1] == 0 && opened[2] == 0) return 0;
    add(point, opened, change_);
    return std::max({-opened[0] * A[0], std::fabs(opened[1]) * size, std::fabs(opened[2]) * size});
  }
  // Then as if it stuck.
  const std::array<double, 9>& inverse = inverses_[point];
  const double stick[3] = {own[0] - inverse[0] * w[0] - inverse[1] * w[1] - inverse[2] * w[2],
                           own[1] - inverse[3] * w[0] - inverse[4] * w[1] - inverse[5] * w[2],
                           own[2] - inverse[6] * w[0] - inverse[7] * w[1] - inverse[8] * w[2]};
  if (inverse[0] > 0 && stick[0] >= least &&
      stick[1] * stick[1] + stick[2] * stick[2] <= friction * friction * stick[0] * stick[0]) {
    const double to_stick[3] = {stick[0] - own[0], stick[1] - own[1], stick[2] - own[2]};
    std::copy_n(stick, 3, own);
    add(point, to_stick, change_);
    return std::max({std::fabs(to_stick[0]) * A[0], std::fabs(to_stick[1]) * size, std::fabs(to_stick[2]) * size});
  }
  for (int inner = 0; inner < 2; ++inner) {
    double moved[3] = {own[0], own[1], own[2]};
    own[0] = std::max(least, own[0] - w[0] / A[0]);
    for (std::size_t k = 1; k < 3; ++k) w[k] += A[3 * k] * (own[0] - moved[0]);
    w[0] += A[0] * (own[0] - moved[0]);
    const double most = friction * own[0];
    if (const double speed = length_of(w[1], w[2]); most > 0 && !(size > 0) && speed > 0) {
      own[1] = -most * w[1] / speed, own[2] = -most * w[2] / speed;  // against a prescribed motion
    } else if (!(most > 0) || !(size > 0)) {
      own[1] = own[2] = 0;
    } else {
      const double t1 = own[1] - w[1] / size, t2 = own[2] - w[2] / size, square = t1 * t1 + t2 * t2;
      const double shorten = square > most * most ? most / std::sqrt(square) : 1;
      own[1] = shorten * t1, own[2] = shorten * t2;
    }
    const double d1 = own[1] - moved[1], d2 = own[2] - moved[2];
    for (std::size_t k = 0; k < 3; ++k) w[k] += A[3 * k + 1] * d1 + A[3 * k + 2] * d2;
    if (friction == 0) break;
  }
  const double change[3] = {own[0] - before[0], own[1] - before[1], own[2] - before[2]};
  add(point, change, change_);
  // The normal force and friction may press against each other, so that they change no more and yet don't obey the law.
  const double normal = own[0] > least ? std::fabs(w[0]) : -w[0];
  const double t1 = own[1] - w[1] / size, t2 = own[2] - w[2] / size, most = friction * own[0], length = length_of(t1, t2);
  const double shorten = length > most ? most / length : 1;
  const double tangential = size > 0 ? length_of(own[1] - shorten * t1, own[2] - shorten * t2) * size : 0;
  return std::max({std::fabs(change[0]) * A[0], std::fabs(change[1]) * size, std::fabs(change[2]) * size, normal, tangential});
}

// (C7) at one point, for a normal impulse N. Returns the largest change as a velocity.
double ManyPoints::relax_moments(std::size_t point, const std::vector<double>& start, double N, double* own) {
  const double twists = blocks_[point][0], rolls = tangential_[point];
  const double twist = points[point].torsion * N, most = points[point].friction * N;
  double w[3], change[3];
  all_along(point, change_, w);
  for (std::size_t k = 0; k < 3; ++k) w[k] += start[3 * point + k], change[k] = -own[k];
  own[0] = twists > 0 ? std::clamp(own[0] - w[0] / twists, -twist, twist) : 0;
  const double t1 = rolls > 0 ? own[1] - w[1] / rolls : 0, t2 = rolls > 0 ? own[2] - w[2] / rolls : 0, size = length_of(t1, t2);
  const double shorten = size > most ? most / size : 1;
  own[1] = shorten * t1, own[2] = shorten * t2;
  for (std::size_t k = 0; k < 3; ++k) change[k] += own[k];
  add(point, change, change_);
  return std::max(std::fabs(change[0]) * twists, length_of(change[1], change[2]) * rolls);
}

// Sweeps in both directions carry loads down and up a pile, from the impulses of the last step. Where they do not converge at
// once, Newton's method goes on. What rests must not move: what had no impulses before is exact at once, and otherwise the
// residual of the guess is squared. Returns the residual.
double ManyPoints::find_impulses(Island island, const std::vector<double>& start, std::vector<double>& impulses) {
  double scale = 0, change = 0, wanted = at_rest;
  const bool fresh = std::ranges::all_of(island, [&](std::size_t i) { return impulses[3 * i] == 0; });
  for (const std::size_t p : island)
    for (std::size_t k = 0; k < 3; ++k) scale = std::max(scale, std::fabs(start[3 * p + k]));
  const auto visit = [&](std::size_t i) {
    const double own = relax(i, start, impulses);
    change = std::max(change, own - LawNewton::round_off * blocks_[i][0] * std::fabs(impulses[3 * i]));
  };
  for (int k = 1;; ++k) {
    change = 0;
    if (k % 2 == 1)
      std::ranges::for_each(island, visit);
    else
      std::for_each(island.rbegin(), island.rend(), visit);
    if (!(scale > 0)) return 0;
    if (k == 1 && !fresh) wanted = std::clamp(change * change / (scale * scale), at_rest, accuracy_);
    if (!(change > wanted * scale) || k == most_sweeps) return change / scale;
    if (k != first_sweeps || !newton_.begin(*this, island, blocks_, tangential_, start, &least_)) continue;
    const double residual = newton_.solve(impulses, 3, wanted, fresh ? wanted : accuracy_);
    restart(island, impulses);
    return residual;
  }
}

double ManyPoints::energy_change(Island island, const std::vector<double>& start, const std::vector<double>& impulses) {
  double sum = 0;
  for (const std::size_t p : island)
    for (std::size_t k = 0; k < 3; ++k) sum += impulses[3 * p + k] * (start[3 * p + k] + 0.5 * along(p, k, change_));
  return sum;
}

// change_ of the points of an island.
void ManyPoints::restart(Island island, const std::vector<double>& impulses) {
  for (const std::size_t p : island) forget(p, change_);
  for (const std::size_t p : island) add(p, impulses.data() + 3 * p, change_);
}

// Impulses that were not found exactly may add energy: then less of them is applied. Returns the largest velocity that is left
// out, relative to the largest one before.
double ManyPoints::lose_energy(Island island, const std::vector<double>& start, std::vector<double>& impulses) {
  if (!(energy_change(island, start, impulses) > 0)) return 0;
  double rate = 0, size = 0, fastest = 0, scale = 0;
  for (const std::size_t p : island)
    for (std::size_t k = 0; k < 3; ++k) {
      const double before = start[3 * p + k], gained = along(p, k, change_);
      rate += impulses[3 * p + k] * before, size += impulses[3 * p + k] * gained;
      scale = std::max(scale, std::fabs(before)), fastest = std::max(fastest, std::fabs(gained));
    }
  const double part = rate < 0 && size > 0 ? std::min(1.0, -rate / size) : 0.0;
  for (const std::size_t p : island)
    for (std::size_t k = 0; k < 3; ++k) impulses[3 * p + k] *= part;
  restart(island, impulses);
  return scale > 0 ? (1 - part) * fastest / scale : 1 - part;
}

void ManyPoints::velocities(std::vector<double>& w) {
  w.resize(b.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) w[3 * i + k] = b[3 * i + k] + along(i, k, change_);
}

LinksMotion& ManyPoints::displacement(const std::vector<double>& factors) {
  start(moved_);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double scaled[3] = {factors[i] * r[3 * i], factors[i] * r[3 * i + 1], factors[i] * r[3 * i + 2]};
    add(i, scaled, moved_);
  }
  return moved_;
}

// What stops a body in a step also carries its weight, where points that carry the body below press the two together. It is not
// returned: otherwise bodies that bounce on others would never come to rest.
void ManyPoints::return_no_weight(Island island) {
  const auto same_bodies = [this](std::size_t i, std::size_t j) {
    for (std::size_t side = 0; side < 2; ++side)
      if (points[i].parts[side].group != points[j].parts[side].group || points[i].parts[side].link != points[j].parts[side].link)
        return false;
    return true;
  };
  const auto add_all = [this](Island same, double sign) {
    for (const std::size_t p : same) {
      const double impulse[3] = {sign * r[3 * p], sign * r[3 * p + 1], sign * r[3 * p + 2]};
      add(p, impulse, change_);
    }
  };
  while (!island.empty()) {
    const auto end = std::ranges::find_if(island, [&](std::size_t i) { return !same_bodies(i, island.front()); });
    const Island same = island.first(static_cast<std::size_t>(end - island.begin()));
    island = island.subspan(same.size());
    if (std::ranges::none_of(same, [this](std::size_t i) { return returns_[i] > 0; })) continue;
    add_all(same, -1);
    for (const std::size_t p : same) {
      const double pressed = -along(p, 0, change_), approach = pressed - b[3 * p];  // by others; with its own
      if (pressed > 0 && approach > 0) returns_[p] *= std::max(0.0, 1 - std::min(pressed, points[p].carried) / approach);
    }
    add_all(same, 1);
  }
}

// Of each normal impulse the restitution returns a part; see ImpactLaw.
void ManyPoints::expand(Island island) {
  double most_work = 0;
  bool elastic = false;
  for (const std::size_t p : island) {
    const std::size_t n = 3 * p;
    for (std::size_t k = 0; k < 3; ++k) after_[n + k] = b[n + k] + along(p, k, change_);
    const double e = returns_[p] = points[p].restitution;
    most_work -= e * e * 0.5 * r[n] * (b[n] + after_[n]);
    elastic = elastic || e * r[n] > 0;
  }
  if (!elastic) return;
  return_no_weight(island);
  const double lost = -energy_change(island, b, r), tolerance = 1e-12 * (std::fabs(lost) + std::fabs(most_work));
  const auto expanded = [&](double part) {
    for (const std::size_t p : island) {
      least_[p] = part * returns_[p] * r[3 * p];
      for (std::size_t k = 0; k < 3; ++k) rebound_[3 * p + k] = 0;
      rebound_[3 * p] = least_[p];
    }
    restart(island, rebound_);
    const double residual = find_impulses(island, after_, rebound_);
    double work = 0;
    for (const std::size_t p : island)
      if (points[p].pressed_by < 0) work += rebound_[3 * p] * (after_[3 * p] + 0.5 * along(p, 0, change_));
    if (!(work <= std::max(most_work, 0.0) + tolerance && energy_change(island, after_, rebound_) <= lost + tolerance))
      return false;
    residual_ = std::max(residual_, residual);
    return true;
  };
  const auto keep = [&] {
    for (const std::size_t p : island)
      std::copy_n(rebound_.begin() + static_cast<std::ptrdiff_t>(3 * p), 3, best_.begin() + static_cast<std::ptrdiff_t>(3 * p));
  };
  if (expanded(1)) {
    keep();
  } else {
    double low = 0, high = 1;
    for (int k = 0; k < bisections; ++k) {
      const double part = 0.5 * (low + high);
      if (expanded(part))
        low = part, keep();
      else
        high = part;
    }
  }
  for (const std::size_t p : island)
    for (std::size_t k = 0; k < 3; ++k) r[3 * p + k] += best_[3 * p + k];
  restart(island, r);
}

void ManyPoints::solve(double accuracy) {
  accuracy_ = accuracy, residual_ = 0;
  r.resize(3 * points.size());
  prepare();
  start(change_);
  least_.assign(points.size(), 0.0), returns_.assign(points.size(), 0.0);
  after_.assign(b.size(), 0.0), rebound_.assign(b.size(), 0.0), best_.assign(b.size(), 0.0);
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    restart(island(i), r);
    residual_ = std::max(residual_, find_impulses(island(i), b, r));
    residual_ = std::max(residual_, lose_energy(island(i), b, r));
    expand(island(i));
  }
}

// The displacements along the normals obey the law of impulses without friction, with gaps for velocities.
LinksMotion& ManyPoints::separate(const std::vector<double>& gaps, std::vector<double>& pushes, double accuracy) {
  if (blocks_.size() != points.size()) prepare();
  start(moved_);
  pushes.assign(points.size(), 0.0);
  double push[3] = {};
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    double deepest = 0, most = HUGE_VAL;
    for (const std::size_t p : island(i)) deepest = std::max(deepest, -gaps[p]);
    for (int k = 0; k < most_sweeps && most > accuracy * deepest; ++k) {
      if (k == first_sweeps && newton_.begin(*this, island(i), blocks_, tangential_, gaps, nullptr)) {
        newton_.solve(pushes, 1, accuracy, accuracy);
        for (const std::size_t p : island(i)) forget(p, moved_);
        for (const std::size_t p : island(i)) push[0] = pushes[p], add(p, push, moved_);
        break;
      }
      most = 0;
      for (const std::size_t p : island(i)) {
        const double a = blocks_[p][0];
        if (!(a > 0) || points[p].pressed_by >= 0) continue;
        const double after = std::max(0.0, pushes[p] - (gaps[p] + along(p, 0, moved_)) / a);
        push[0] = after - std::exchange(pushes[p], after);
        if (push[0] != 0) add(p, push, moved_), most = std::max(most, std::fabs(push[0]) * a);
      }
    }
  }
  return moved_;
}

}  // namespace momentree::contact
