#include <momentree/export/picture/outline.hpp>

#include <map>
#include <utility>

namespace momentree::io {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// Edges with a direction, of which opposite ones cancel.
class Boundary {
 public:
  void add(std::uint32_t from, std::uint32_t to) {
    if (from == to) return;
    const auto opposite = edges_.find({to, from});
    if (opposite == edges_.end())
      ++edges_[{from, to}];
    else if (--opposite->second == 0)
      edges_.erase(opposite);
  }
  bool empty() const { return edges_.empty(); }
  /// As many edges end at a point as begin there: they are closed loops.
  std::vector<std::vector<std::uint32_t>> loops() {
    std::vector<std::vector<std::uint32_t>> all;
    while (!edges_.empty()) {
      const std::uint32_t first = edges_.begin()->first.first;
      std::vector<std::uint32_t>& loop = all.emplace_back();
      for (std::uint32_t at = first;;) {
        const auto next = edges_.lower_bound({at, 0});
        loop.push_back(at);
        at = next->first.second;
        if (--next->second == 0) edges_.erase(next);
        if (at == first) break;
      }
    }
    return all;
  }

 private:
  std::map<Edge, int> edges_;
};

double area(const Point2& a, const Point2& b, const Point2& c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

}  // namespace

// The winding number of a boundary is the sum of those of the triangles. Of a closed mesh those that face the viewer suffice; of
// others all are needed, turned towards the viewer.
std::vector<std::vector<Point2>> outline_of(std::span<const Point2> points,
                                            std::span<const std::array<std::uint32_t, 3>> triangles) {
  Boundary rim;
  for (const auto& [a, b, c] : triangles) rim.add(a, b), rim.add(b, c), rim.add(c, a);
  const bool closed = rim.empty();
  Boundary boundary;
  for (const auto& [a, b, c] : triangles) {
    const double size = area(points[a], points[b], points[c]);
    if (size < 0) {  // y points down: it faces the viewer
      boundary.add(a, b), boundary.add(b, c), boundary.add(c, a);
    } else if (size > 0 && !closed) {
      boundary.add(a, c), boundary.add(c, b), boundary.add(b, a);
    }
  }
  std::vector<std::vector<Point2>> loops;
  for (const std::vector<std::uint32_t>& loop : boundary.loops()) {
    std::vector<Point2>& corners = loops.emplace_back();
    for (const std::uint32_t i : loop) corners.push_back(points[i]);
  }
  return loops;
}

}  // namespace momentree::io
