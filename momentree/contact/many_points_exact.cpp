#include <algorithm>
#include <cmath>

#include <momentree/contact/indices.hpp>
#include <momentree/contact/many_points.hpp>

namespace momentree::contact {

void MovedPoints::find_responses(const std::vector<int>& touched, std::vector<double>& responses) {
  const std::size_t n = 6 * touched.size();
  responses.resize(n * n);
  LinksMotion& trial = unmoved();
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const Link& link = links.all[at(touched[i])];
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t own = 6 * at(touched[i]);
      links.forget(link.group, trial);
      links.walk(trial, touched[i]);
      trial.sum[own + k] = 1;
      std::copy_n(link.whole.data() + 6 * k, 6, trial.x.data() + own);
      for (std::size_t j = 0; j < touched.size(); ++j) {
        links.walk(trial, touched[j]);
        std::copy_n(trial.x.data() + 6 * touched[j], 6, responses.data() + (6 * i + k) * n + 6 * j);
      }
    }
    links.forget(link.group, trial);
  }
}

bool IslandNewton::begin(MovedPoints& of, std::span<const std::size_t> island, const std::vector<std::array<double, 9>>& A,
                         const std::vector<double>& tangential, const std::vector<double>& start,
                         const std::vector<double>* least) {
  const std::vector<MovedPoints::Point>& points = of.points;
  const bool gaps = least == nullptr;
  place_of_.resize(of.links.all.size());
  pressing_.clear();
  const auto place_of = [&](int point) { return std::ranges::lower_bound(pressing_, at(point)); };
  for (const std::size_t p : island) {
    const int by = points[p].pressed_by;
    if (by < 0 && (!(A[p][0] > 0) || (!gaps && points[p].slack == HUGE_VAL))) continue;
    if (by >= 0 && (gaps || !(std::max(A[p][0], tangential[p]) > 0))) continue;
    if (by >= 0 && (place_of(by) == pressing_.end() || *place_of(by) != at(by))) continue;
    pressing_.push_back(p);
    for (const MovedPoints::Part& part : points[p].parts) {
      if (part.group >= 0 && at(part.group) >= block_of_.size()) block_of_.resize(at(part.group) + 1);
      if (part.group >= 0) block_of_[at(part.group)] = -1;
      if (part.link >= 0) place_of_[at(part.link)] = -1;
    }
  }
  sizes_.clear();
  for (const std::size_t p : pressing_)
    for (const MovedPoints::Part& part : points[p].parts) {
      if (part.group < 0) continue;
      int& block = block_of_[at(part.group)];
      if (block < 0) {
        block = static_cast<int>(sizes_.size());
        sizes_.push_back(part.link < 0 ? part.count : 0);
        if (touched_.size() < sizes_.size()) touched_.emplace_back(), responses_.emplace_back();
        touched_[at(block)].clear();
      }
      if (part.link < 0 || place_of_[at(part.link)] >= 0) continue;
      place_of_[at(part.link)] = sizes_[at(block)];
      sizes_[at(block)] += 6, touched_[at(block)].push_back(part.link);
    }
  constexpr int most_unknowns = 600;  // of a tree: then its factors take 10 ms
  for (std::size_t i = 0; i < sizes_.size(); ++i)
    if (!touched_[i].empty() && sizes_[i] > most_unknowns) return false;
  std::size_t wide = 0;  // rows of Y that act on several links
  for (const std::size_t p : pressing_)
    for (const MovedPoints::Part& part : points[p].parts)
      if (part.link >= 0) wide += 3 * at(sizes_[at(block_of_[at(part.group)])]);
  wide_.assign(wide, 0.0);
  for (std::size_t i = 0; i < sizes_.size(); ++i)
    if (!touched_[i].empty()) of.find_responses(touched_[i], responses_[i]);
  newton_.clear(sizes_);
  double* next = wide_.data();
  for (const std::size_t p : pressing_) {
    LawNewton::Point point;
    if (gaps) {
      point.b[0] = start[p];
    } else {
      point.friction = points[p].friction, point.least = (*least)[p], point.torsion = points[p].torsion;
      if (points[p].pressed_by >= 0) point.pressed_by = static_cast<int>(place_of(points[p].pressed_by) - pressing_.begin());
      point.b = {start[3 * p] + points[p].slack, start[3 * p + 1], start[3 * p + 2]};
    }
    for (std::size_t side = 0; side < 2; ++side) {
      const MovedPoints::Part& part = points[p].parts[side];
      if (part.group < 0) continue;
      const int block = block_of_[at(part.group)];
      LawNewton::Part& to = point.parts[side];
      to = {block, 0, part.count, of.J.data() + part.at, of.Y.data() + part.at};
      if (part.link < 0) continue;
      const std::size_t n = at(sizes_[at(block)]);
      to.first = place_of_[at(part.link)], to.Y = next;
      const double* const response = responses_[at(block)].data() + at(to.first) * n;
      for (std::size_t row = 0; row < 3; ++row, next += n)
        for (std::size_t k = 0; k < 6; ++k)
          for (std::size_t i = 0; i < n; ++i) next[i] += to.J[6 * row + k] * response[k * n + i];
    }
    newton_.add(point);
  }
  return true;
}

double IslandNewton::solve(std::vector<double>& impulses, std::size_t rows, double accuracy, double enough) {
  exact_.clear();
  for (const std::size_t p : pressing_)
    for (std::size_t row = 0; row < 3; ++row) exact_.push_back(row < rows ? impulses[rows * p + row] : 0);
  const double residual = newton_.solve(exact_.data(), accuracy, enough);
  for (std::size_t k = 0; k < pressing_.size(); ++k)
    for (std::size_t row = 0; row < rows; ++row) impulses[rows * pressing_[k] + row] = exact_[3 * k + row];
  return residual;
}

}  // namespace momentree::contact
