#include <momentree/contact/shapes/quick_hull.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <momentree/contact/indices.hpp>

namespace momentree::contact {

namespace {

// Four points that are far from lying in a plane, or none.
std::vector<int> first_tetrahedron(std::span<const Vec3> points, double size) {
  const auto farthest = [&](auto distance) {
    int best = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
      if (distance(points[i]) > distance(points[at(best)])) best = static_cast<int>(i);
    return best;
  };
  const int a = farthest([&](const Vec3& p) { return -p.x; });
  const Vec3 pa = points[at(a)];
  const int b = farthest([&](const Vec3& p) { return norm(p - pa); });
  const Vec3 ab = points[at(b)] - pa;
  if (!(norm(ab) > 1e-9 * size)) return {};
  const int c = farthest([&](const Vec3& p) { return norm(cross(p - pa, ab)); });
  const Vec3 normal = cross(ab, points[at(c)] - pa);
  if (!(norm(normal) > 1e-9 * size * size)) return {};
  const int d = farthest([&](const Vec3& p) { return std::fabs(dot(p - pa, normal)); });
  const double height = dot(points[at(d)] - pa, normal);
  if (!(std::fabs(height) > 1e-9 * size * norm(normal))) return {};
  return height > 0 ? std::vector{a, c, b, d} : std::vector{a, b, c, d};
}

class HullBuilder {
 public:
  HullBuilder(std::span<const Vec3> points, double size, double tolerance)
      : points_(points), rounding_(1e-13 * size), tolerance_(std::max(tolerance * size, 4 * rounding_)) {}

  Hull build(const std::vector<int>& start, std::size_t most) {
    const int a = start[0], b = start[1], c = start[2], d = start[3];
    std::vector<int> all(points_.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
    for (const auto& corners : {std::array{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}}) add(corners);
    share(all, {0, 1, 2, 3});
    std::size_t corners = 4;
    Hull hull;
    for (int f = highest(); f >= 0; f = highest()) {
      if (corners >= most) {
        hull.beyond = farthest_outside();
        break;
      }
      raise(f);
      ++corners;
    }
    for (const Facet& facet : facets_)
      if (facet.alive) hull.triangles.push_back(facet.corners);
    return hull;
  }

 private:
  struct Facet {
    std::array<int, 3> corners{};
    Vec3 normal{};
    double offset = 0;
    bool alive = true;
    std::vector<int> outside{};  // points above it, each of them above one facet only
    int farthest = -1;           // the highest of them
    double height = 0;
  };

  double above(const Facet& facet, int point) const { return dot(facet.normal, points_[at(point)]) - facet.offset; }

  int add(const std::array<int, 3>& corners) {
    Facet facet;
    facet.corners = corners;
    const Vec3 &a = points_[at(corners[0])], &b = points_[at(corners[1])], &c = points_[at(corners[2])];
    const Vec3 normal = cross(b - a, c - a);
    if (norm(normal) > 0) facet.normal = normalized(normal);
    facet.offset = dot(facet.normal, a);
    const int number = static_cast<int>(facets_.size());
    for (std::size_t k = 0; k < 3; ++k) beside_[{corners[k], corners[(k + 1) % 3]}] = number;
    facets_.push_back(std::move(facet));
    return number;
  }

  // Gives points to the facets that they are above.
  void share(const std::vector<int>& some, const std::vector<int>& facets) {
    for (const int p : some)
      for (const int f : facets) {
        Facet& facet = facets_[at(f)];
        const double height = above(facet, p);
        if (!(height > tolerance_)) continue;
        facet.outside.push_back(p);
        if (height > facet.height) facet.height = height, facet.farthest = p;
        break;
      }
  }

  int highest() const {
    int best = -1;
    for (std::size_t f = 0; f < facets_.size(); ++f)
      if (facets_[f].alive && facets_[f].farthest >= 0 && (best < 0 || facets_[f].height > facets_[at(best)].height))
        best = static_cast<int>(f);
    return best;
  }

  double farthest_outside() const {
    double farthest = 0;
    for (const Facet& of : facets_)
      for (const int p : of.outside)
        for (const Facet& facet : facets_)
          if (facet.alive) farthest = std::max(farthest, above(facet, p));
    return farthest;
  }

  // Replaces the facets that the farthest point of one of them sees by facets from their outline to the point.
  void raise(int from) {
    const int point = facets_[at(from)].farthest;
    std::vector<int> seen{from}, orphans;
    std::vector<std::pair<int, int>> outline;
    facets_[at(from)].alive = false;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const std::array<int, 3> corners = facets_[at(seen[i])].corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = corners[k], b = corners[(k + 1) % 3], other = beside_.at({b, a});
        if (!facets_[at(other)].alive) continue;
        if (above(facets_[at(other)], point) > -rounding_) {
          facets_[at(other)].alive = false;
          seen.push_back(other);
        }
      }
    }
    for (const int f : seen) {
      const std::array<int, 3>& corners = facets_[at(f)].corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = corners[k], b = corners[(k + 1) % 3];
        if (facets_[at(beside_.at({b, a}))].alive) outline.emplace_back(a, b);
      }
      for (const int p : facets_[at(f)].outside)
        if (p != point) orphans.push_back(p);
      facets_[at(f)].outside = {}, facets_[at(f)].farthest = -1;
    }
    std::vector<int> fresh;
    for (const auto& [a, b] : outline) fresh.push_back(add({a, b, point}));
    share(orphans, fresh);
  }

  std::span<const Vec3> points_;
  double rounding_, tolerance_;
  std::vector<Facet> facets_;
  std::map<std::pair<int, int>, int> beside_;  // the facet to the left of a directed edge
};

}  // namespace

Hull quick_hull(std::span<const Vec3> points, double tolerance, std::size_t most) {
  if (points.size() < 4) return {};
  double size = 0;
  for (const Vec3& p : points) size = std::max(size, norm(p - points[0]));
  const std::vector<int> start = first_tetrahedron(points, size);
  if (start.empty()) return {};
  return HullBuilder(points, size, tolerance).build(start, most);
}

}  // namespace momentree::contact
