#include <momentree/models/mesh/simplify.hpp>

#include <algorithm>
#include <cmath>
#include <queue>
#include <unordered_map>
#include <unordered_set>

namespace momentree::io {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Drops points that no triangle uses.
void drop_unused(MeshPart& part) {
  constexpr std::uint32_t unused = 0xffffffffu;
  std::vector<std::uint32_t> number(part.points.size(), unused);
  std::vector<Vec3> kept;
  for (Triangle& triangle : part.triangles)
    for (std::uint32_t& corner : triangle) {
      if (number[corner] == unused) {
        number[corner] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(part.points[corner]);
      }
      corner = number[corner];
    }
  part.points = std::move(kept);
}

/// Drops triangles with the same corner twice.
void drop_lines(std::vector<Triangle>& triangles) {
  std::erase_if(triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
}

/// Drops triangles with the same corners as an earlier one, whatever their order.
void drop_repeated(std::vector<Triangle>& triangles) {
  struct Hash {
    std::size_t operator()(const Triangle& t) const { return (t[0] * 0x9e3779b97f4a7c15u ^ t[1]) * 0x9e3779b97f4a7c15u ^ t[2]; }
  };
  std::unordered_set<Triangle, Hash> known;
  std::erase_if(triangles, [&](Triangle t) {
    std::sort(t.begin(), t.end());
    return !known.insert(t).second;
  });
}

/// Sum of squared distances from planes, as a symmetric 4 × 4 matrix.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, xw = 0, yy = 0, yz = 0, yw = 0, zz = 0, zw = 0, ww = 0;
  /// `weight` times the squared distance from the plane n·p + d = 0, with n of length 1.
  void add_plane(const Vec3& n, double d, double weight) {
    xx += weight * n.x * n.x, xy += weight * n.x * n.y, xz += weight * n.x * n.z, xw += weight * n.x * d;
    yy += weight * n.y * n.y, yz += weight * n.y * n.z, yw += weight * n.y * d;
    zz += weight * n.z * n.z, zw += weight * n.z * d, ww += weight * d * d;
  }
  void add(const Quadric& q) {
    xx += q.xx, xy += q.xy, xz += q.xz, xw += q.xw, yy += q.yy, yz += q.yz, yw += q.yw, zz += q.zz, zw += q.zw, ww += q.ww;
  }
  double at(const Vec3& p) const {
    const double value = xx * p.x * p.x + yy * p.y * p.y + zz * p.z * p.z + ww +
                         2 * (xy * p.x * p.y + xz * p.x * p.z + yz * p.y * p.z + xw * p.x + yw * p.y + zw * p.z);
    return std::max(value, 0.0);
  }
};

class Simplifier {
 public:
  explicit Simplifier(MeshPart& part) : points_(part.points), triangles_(part.triangles), left_(triangles_.size()) {
    around_.resize(points_.size());
    quadrics_.resize(points_.size());
    version_.resize(points_.size());
    mark_.resize(points_.size());
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      for (const std::uint32_t corner : triangles_[t]) around_[corner].push_back(t);
    std::unordered_map<std::uint64_t, int> sides;  // of edges: triangles at them
    for (const Triangle& t : triangles_)
      for (std::size_t k = 0; k < 3; ++k) ++sides[edge_key(t[k], t[(k + 1) % 3])];
    for (const Triangle& t : triangles_) measure(t, sides);
    for (std::uint32_t p = 0; p < points_.size(); ++p) push_edges(p, false);
  }

  /// False if the mesh is so entangled that this would take too long.
  bool run(std::size_t most) {
    for (const bool careful : {true, false}) {
      while (left_ > most && !queue_.empty()) {
        if (work_ > most_work) return false;
        const Edge edge = queue_.top();
        queue_.pop();
        if (edge.from_version != version_[edge.from] || edge.to_version != version_[edge.to]) continue;
        if (careful && !(keeps_sides(edge) && keeps_surface(edge))) continue;
        collapse(edge);
      }
      if (left_ <= most) break;
      for (std::uint32_t p = 0; p < points_.size(); ++p) push_edges(p, false);
    }
    std::erase_if(triangles_, [](const Triangle& t) { return t[0] == t[1]; });
    return left_ <= most;
  }

 private:
  static constexpr std::uint64_t most_work = 30'000'000;

  struct Edge {
    double cost;
    std::uint32_t from, to, from_version, to_version;
    bool operator<(const Edge& other) const {  // the cheapest first; then in a fixed order
      if (cost != other.cost) return cost > other.cost;
      return from != other.from ? from > other.from : to > other.to;
    }
  };

  Vec3 area_vector(const Triangle& t) const { return cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]); }
  static bool has(const Triangle& t, std::uint32_t p) { return t[0] == p || t[1] == p || t[2] == p; }
  static std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

  /// Adds the plane of a triangle to its corners, and planes across its open edges, which keep a border in its place.
  void measure(const Triangle& triangle, const std::unordered_map<std::uint64_t, int>& sides) {
    const Vec3 twice = area_vector(triangle);
    const double area = norm(twice);
    if (!(area > 0)) return;
    const Vec3 n = (1 / area) * twice;
    for (const std::uint32_t corner : triangle) quadrics_[corner].add_plane(n, -dot(n, points_[corner]), area);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
      const Vec3 along = points_[b] - points_[a];
      if (sides.at(edge_key(a, b)) != 1 || !(norm(along) > 0)) continue;
      const Vec3 across = normalized(cross(along, n));
      for (const std::uint32_t end : {a, b}) quadrics_[end].add_plane(across, -dot(across, points_[end]), 3 * dot(along, along));
    }
  }

  /// Offers the edges at a point; `both`: in both directions, otherwise each edge of the mesh is offered once.
  void push_edges(std::uint32_t p, bool both) {
    work_ += around_[p].size();
    for (const std::uint32_t t : around_[p])
      for (const std::uint32_t other : triangles_[t]) {
        if (other == p || (!both && other < p)) continue;
        Quadric sum = quadrics_[p];
        sum.add(quadrics_[other]);
        const double there = sum.at(points_[other]), here = sum.at(points_[p]);
        const bool towards = there <= here;
        const std::uint32_t from = towards ? p : other, to = towards ? other : p;
        queue_.push({std::min(there, here), from, to, version_[from], version_[to]});
      }
  }

  /// No triangle turns over or becomes a line.
  bool keeps_sides(const Edge& edge) const {
    for (const std::uint32_t t : around_[edge.from]) {
      if (has(triangles_[t], edge.to)) continue;
      Triangle moved = triangles_[t];
      std::replace(moved.begin(), moved.end(), edge.from, edge.to);
      const Vec3 before = area_vector(triangles_[t]), after = area_vector(moved);
      if (dot(before, after) <= 0.2 * norm(before) * norm(after)) return false;
    }
    return true;
  }

  /// The ends have no common neighbours apart from those across the edge: two parts of the surface would be glued together.
  bool keeps_surface(const Edge& edge) {
    std::size_t on_edge = 0, common = 0;
    stamp_ += 2;  // stamp_ − 1: a neighbour of `from`, stamp_: of both
    for (const std::uint32_t t : around_[edge.from]) {
      on_edge += has(triangles_[t], edge.to);
      for (const std::uint32_t p : triangles_[t]) mark_[p] = stamp_ - 1;
    }
    work_ += around_[edge.from].size() + around_[edge.to].size();
    for (const std::uint32_t t : around_[edge.to])
      for (const std::uint32_t p : triangles_[t])
        if (p != edge.from && p != edge.to && mark_[p] == stamp_ - 1) mark_[p] = stamp_, ++common;
    return common <= on_edge;
  }

  void collapse(const Edge& edge) {
    for (const std::uint32_t t : around_[edge.from]) {
      Triangle& triangle = triangles_[t];
      if (has(triangle, edge.to)) {
        for (const std::uint32_t p : triangle)
          if (p != edge.from) work_ += around_[p].size(), std::erase(around_[p], t);
        triangle = {0, 0, 0};
        --left_;
      } else {
        std::replace(triangle.begin(), triangle.end(), edge.from, edge.to);
        around_[edge.to].push_back(t);
      }
    }
    around_[edge.from].clear();
    quadrics_[edge.to].add(quadrics_[edge.from]);
    ++version_[edge.from], ++version_[edge.to];
    push_edges(edge.to, true);
  }

  std::vector<Vec3>& points_;
  std::vector<Triangle>& triangles_;
  std::size_t left_;
  std::vector<std::vector<std::uint32_t>> around_;  ///< by point, the triangles at it
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> version_;  ///< by point; edges offered before its last change are outdated
  std::priority_queue<Edge> queue_;
  std::vector<std::uint64_t> mark_;  ///< by point
  std::uint64_t stamp_ = 1, work_ = 0;
};

}  // namespace

void merge_points(MeshPart& part, double cells) {
  Vec3 low = part.points.empty() ? Vec3{} : part.points.front(), high = low;
  for (const Vec3& p : part.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const double longest = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  const double cell = longest > 0 ? longest / cells : 1;
  std::unordered_map<std::uint64_t, std::uint32_t> found;
  std::vector<std::uint32_t> number(part.points.size());
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < part.points.size(); ++i) {
    const Vec3 d = part.points[i] - low;
    const auto step = [&](double x) { return static_cast<std::uint64_t>(std::lround(x / cell)); };
    const std::uint64_t x = step(d.x), y = step(d.y), z = step(d.z);
    const auto [at, fresh] = found.emplace(x << 42 | y << 21 | z, static_cast<std::uint32_t>(kept.size()));
    if (fresh) kept.push_back(part.points[i]);
    number[i] = at->second;
  }
  part.points = std::move(kept);
  for (Triangle& t : part.triangles)
    for (std::uint32_t& corner : t) corner = number[corner];
  drop_lines(part.triangles);
  drop_repeated(part.triangles);
  drop_unused(part);
}

void simplify(MeshPart& part, std::size_t most) {
  drop_lines(part.triangles);
  if (part.triangles.size() <= most) return;
  MeshPart simplified = part;
  if (Simplifier(simplified).run(most)) {
    part = std::move(simplified);
    drop_unused(part);
    return;
  }
  for (double cells = 512; part.triangles.size() > most && cells >= 1; cells /= 2) merge_points(part, cells);
}

}  // namespace momentree::io
