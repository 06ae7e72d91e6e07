#include <momentree/contact/shapes/height_field.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <momentree/contact/candidates_impl.hpp>

namespace momentree::contact {

namespace {

constexpr double border = 1e-9;           // of a cell: what is so near the outline of a triangle is above it
constexpr double longer = 1e-8;           // of an edge: it is so much longer, so that there is no gap between two of one line
constexpr double least_convex = 1e-6;     // sine of an angle: edges that are less convex are flat
constexpr double most_across = 1e-2;      // sine of the angle by which normals may be beyond those of an edge or corner
constexpr double shallow = 1e-2;          // of a solid's thickness: overlaps of edges that are deeper count only inside of it
constexpr std::size_t parts_of_cell = 6;  // in numbers of features: two triangles, three edges, a corner

struct Range {
  int first, last;  // empty if first > last
};

struct Grid {
  const HeightField& field;
  double dx = field.x / (field.columns - 1), dy = field.y / (field.rows - 1);
  Mat3 R = rotation_matrix(field.at.rotation);
  Vec3 up = R * Vec3{0, 0, 1};

  std::size_t number(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(field.columns) + static_cast<std::size_t>(i);
  }
  double height(int i, int j) const { return field.heights[number(i, j)]; }
  Vec3 own(int i, int j) const { return {dx * i - 0.5 * field.x, dy * j - 0.5 * field.y, height(i, j)}; }
  Vec3 world(int i, int j) const { return field.at.position + R * own(i, j); }
  Vec3 into(const Vec3& world) const { return transpose_times(R, world - field.at.position); }
  bool has(int i, int j) const { return i >= 0 && j >= 0 && i < field.columns && j < field.rows; }

  // Cells, or what begins at them, between two places along an axis.
  static Range between(double low, double high, double extent, double step, int count) {
    const double most = count - 1;
    const double first = std::floor((low + 0.5 * extent) / step - border),
                 last = std::floor((high + 0.5 * extent) / step + border);
    if (!(last >= 0) || !(first <= most)) return {0, -1};
    return {static_cast<int>(std::max(first, 0.0)), static_cast<int>(std::min(last, most))};
  }
  Range columns(double low, double high, int count) const { return between(low, high, field.x, dx, count); }
  Range rows(double low, double high, int count) const { return between(low, high, field.y, dy, count); }

  double highest_of_cell(int i, int j) const {
    return std::max(std::max(height(i, j), height(i + 1, j)), std::max(height(i, j + 1), height(i + 1, j + 1)));
  }
  // A triangle of a cell, counterclockwise seen from above.
  std::array<Vec3, 3> triangle(int i, int j, int which) const {
    if (which == 0) return {world(i, j), world(i + 1, j), world(i, j + 1)};
    return {world(i + 1, j + 1), world(i, j + 1), world(i + 1, j)};
  }
  bool over(int i, int j, int which, const Vec3& own) const {
    const double u = (own.x + 0.5 * field.x) / dx - i, v = (own.y + 0.5 * field.y) / dy - j;
    return which == 0 ? u >= -border && v >= -border && u + v <= 1 + border
                      : u <= 1 + border && v <= 1 + border && u + v >= 1 - border;
  }

  // An edge that begins at a height, 0 to 2, and where the triangles beside it have their third corners.
  struct Edge {
    Vec3 from, to;
    std::array<std::optional<Vec3>, 2> beside;
  };
  std::optional<Edge> edge(int i, int j, int which) const {
    constexpr int places[3][4][2] = {
        {{0, 0}, {1, 0}, {0, 1}, {1, -1}}, {{0, 0}, {0, 1}, {1, 0}, {-1, 1}}, {{1, 0}, {0, 1}, {0, 0}, {1, 1}}};
    const auto place = [&](int k) -> std::optional<Vec3> {
      const int column = i + places[which][k][0], row = j + places[which][k][1];
      return has(column, row) ? std::optional(world(column, row)) : std::nullopt;
    };
    const auto from = place(0), to = place(1);
    if (!from || !to) return std::nullopt;
    return Edge{*from, *to, {place(2), place(3)}};
  }
  // Into the triangles beside an edge, perpendicular to it; at the border downwards.
  std::array<Vec3, 2> inward(const Edge& edge) const {
    const Vec3 along = normalized(edge.to - edge.from);
    std::array<Vec3, 2> all;
    for (std::size_t k = 0; k < 2; ++k) {
      const Vec3 to = edge.beside[k] ? *edge.beside[k] - edge.from : -up;
      all[k] = normalized(to - dot(to, along) * along);
    }
    return all;
  }
  // Along the edges at a height; at the border also downwards.
  void edges_at(int i, int j, std::vector<Vec3>& all) const {
    constexpr int neighbours[6][2] = {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}};
    all.clear();
    for (const auto& [column, row] : neighbours)
      if (has(i + column, j + row)) all.push_back(normalized(world(i + column, j + row) - world(i, j)));
    if (all.size() < 6) all.push_back(-up);
  }
};

void find_convex(HeightField& field) {
  const Grid grid{field};
  field.convex.assign(field.heights.size(), 0);
  std::vector<std::uint8_t> count(field.heights.size(), 0);
  constexpr int ends[3][2][2] = {{{0, 0}, {1, 0}}, {{0, 0}, {0, 1}}, {{1, 0}, {0, 1}}};
  for (int j = 0; j < field.rows; ++j)
    for (int i = 0; i < field.columns; ++i) {
      if (i == 0 || j == 0 || i == field.columns - 1 || j == field.rows - 1) ++count[grid.number(i, j)];
      for (int which = 0; which < 3; ++which) {
        const auto edge = grid.edge(i, j, which);
        if (!edge) continue;
        const auto [one, other] = grid.inward(*edge);
        if (!(dot(one + other, grid.up) < -least_convex)) continue;
        field.convex[grid.number(i, j)] |= static_cast<std::uint8_t>(1 << which);
        for (const auto& [column, row] : ends[which]) ++count[grid.number(i + column, j + row)];
      }
    }
  for (std::size_t k = 0; k < count.size(); ++k)
    if (count[k] >= 3) field.convex[k] |= 8;
}

struct FieldSearch {
  const Solid& solid;
  const Place& place;
  const HeightField& field;
  double within;
  std::vector<Candidate>& out;
  Grid grid{field};
  Vec3 middle = grid.into(out_of(place, solid.centre));
  double near = solid.reach + within;
  std::vector<Candidate> found{};

  bool is_round() const { return solid.rim > 0 || solid.is_smooth(); }

  void find() {
    if (middle.z - near > field.highest) return;
    if (is_round()) {
      each_cell(middle, near, [&](int i, int j, int which) { surface(i, j, which); });
    } else {
      for (std::size_t v = 0; v < solid.vertices.size(); ++v) {
        const Vec3 p = grid.into(out_of(place, solid.vertices[v]));
        each_cell(p, solid.radius, [&](int i, int j, int which) { vertex(v, p, i, j, which); });
      }
    }
    convex_parts();
  }

  void each_cell(const Vec3& centre, double reach, const auto& visit) const {
    const Range columns = grid.columns(centre.x - reach, centre.x + reach, field.columns - 1),
                rows = grid.rows(centre.y - reach, centre.y + reach, field.rows - 1);
    for (int j = rows.first; j <= rows.last; ++j)
      for (int i = columns.first; i <= columns.last; ++i) {
        if (centre.z - reach - within > grid.highest_of_cell(i, j)) continue;
        visit(i, j, 0), visit(i, j, 1);
      }
  }

  std::uint64_t part(int i, int j, std::size_t which) const { return parts_of_cell * grid.number(i, j) + which; }
  void add(Candidate c, std::uint64_t number) const {
    c.id += number << (c.swapped ? 4 : 34);
    out.push_back(c);
  }

  // A point that is rounded faces a triangle from where it is above it, others and those that are deep from where they are over
  // it.
  void vertex(std::size_t v, const Vec3& p, int i, int j, int which) const {
    if (solid.radius == 0 && !grid.over(i, j, which, p)) return;
    const auto [a, b, c] = grid.triangle(i, j, which);
    const Features f{FeaturePair::point_plane, solid.vertices[v], {}, a, normalized(cross(b - a, c - a)), solid.radius, 0};
    const Touch t = touch(f, place, {});
    const double above = t.gap + solid.radius;
    if (t.gap < within && grid.over(i, j, which, solid.radius > 0 && above > 0 ? grid.into(t.point - t.gap * t.normal) : p))
      add({f, false, id_of(f.pair, false, v, 0), t.gap}, part(i, j, static_cast<std::size_t>(which)));
  }

  void surface(int i, int j, int which) {
    const auto [a, b, c] = grid.triangle(i, j, which);
    const Vec3 normal = normalized(cross(b - a, c - a));
    const bool above = dot(normal, out_of(place, solid.centre) - a) > 0;
    found.clear();
    face_plane(solid, place, a, normal, {}, within, found);
    for (const Candidate& each : found) {
      const Touch t = touch(each.features, place, {});
      if (grid.over(i, j, which, grid.into(above ? t.point - t.gap * normal : t.point)))
        add(each, part(i, j, static_cast<std::size_t>(which)));
    }
  }

  // From the field to the solid, where features touch.
  struct Meeting {
    Vec3 normal, point;  // of the field
  };
  Meeting meeting(const Candidate& c) const {
    const Touch t = c.swapped ? touch(c.features, {}, place) : touch(c.features, place, {});
    if (c.swapped) return {-t.normal, t.point};
    return {t.normal, t.point - t.gap * t.normal};
  }
  // Points without extent before points, lines and circles: what is beside them is nearer.
  static bool is_thin(const Features& f) {
    return f.radius_a + f.radius_b == 0 &&
           (f.pair == FeaturePair::point_point || f.pair == FeaturePair::point_line || f.pair == FeaturePair::point_circle);
  }

  void convex_parts() {
    const Range columns = grid.columns(middle.x - near, middle.x + near, field.columns),
                rows = grid.rows(middle.y - near, middle.y + near, field.rows);
    Solid line = capsule(1, 1), corner = sphere(1);
    line.radius = corner.radius = corner.reach = 0;
    for (int j = rows.first; j <= rows.last; ++j)
      for (int i = columns.first; i <= columns.last; ++i) {
        const std::uint8_t convex = field.convex[grid.number(i, j)];
        for (int which = 0; which < 3; ++which)
          if ((convex & 1 << which) != 0) edge(i, j, which, line);
        if ((convex & 8) != 0 && grid.height(i, j) > middle.z - near) apex(i, j, corner);
      }
  }

  void edge(int i, int j, int which, Solid& line) {
    const Grid::Edge edge = *grid.edge(i, j, which);
    const double length = norm(edge.to - edge.from), more = longer * length;
    const Vec3 along = (1 / length) * (edge.to - edge.from);
    line.centre = 0.5 * (edge.from + edge.to), line.reach = 0.5 * length + more;
    if (norm(out_of(place, solid.centre) - line.centre) > near + line.reach) return;
    line.vertices = {edge.from - more * along, edge.to + more * along};
    line.along = {{along}, {-along}};
    found.clear();
    if (solid.radius == 0 && !is_round())
      cross_edges(solid, place, line, {}, within, 0.5 * solid.thickness, found);
    else
      face_each_other(solid, place, line, {}, within, found);
    const auto inward = grid.inward(edge);
    for (const Candidate& c : found) {
      const auto [normal, point] = meeting(c);
      const double s = dot(along, point - edge.from);
      const bool inside = s > -0.9 * more && s < length + 0.9 * more;  // its ends are corners
      const bool deep = c.gap < -shallow * solid.thickness && !solid.faces.empty() && !is_round();
      if (deep && over_faces(solid, into(place, point), {}).above > edge_slack * solid.reach)
        continue;  // beyond the other side of the solid
      if (inside && !is_thin(c.features) && dot(normal, inward[0]) <= most_across && dot(normal, inward[1]) <= most_across)
        add(c, part(i, j, static_cast<std::size_t>(2 + which)));
    }
  }

  void apex(int i, int j, Solid& corner) {
    const Vec3 p = grid.world(i, j);
    if (norm(out_of(place, solid.centre) - p) > near) return;
    corner.vertices[0] = corner.centre = p;
    grid.edges_at(i, j, corner.along[0]);
    found.clear();
    face_each_other(solid, place, corner, {}, within, found);
    for (const Candidate& c : found)
      if (!is_thin(c.features) && is_before(meeting(c).normal, corner.along[0])) add(c, part(i, j, 5));
  }
  // A normal of a corner leads away from all of its edges, and is not that of a face or an edge through it.
  static bool is_before(const Vec3& normal, const std::vector<Vec3>& edges) {
    for (std::size_t a = 0; a < edges.size(); ++a) {
      if (dot(normal, edges[a]) > most_across) return false;
      if (dot(normal, edges[a]) < -least_convex) continue;
      for (std::size_t b = 0; b < a; ++b)
        if (dot(normal, edges[b]) >= -least_convex && norm(edges[a] + edges[b]) < least_convex) return false;
    }
    return true;
  }
};

}  // namespace

HeightField height_field(double x, double y, int columns, int rows, std::vector<double> heights, const Pose& at) {
  HeightField field{.at = at, .x = x, .y = y, .columns = columns, .rows = rows, .heights = std::move(heights)};
  const auto [low, high] = std::minmax_element(field.heights.begin(), field.heights.end());
  field.lowest = *low, field.highest = *high;
  find_convex(field);
  return field;
}

void face_field(const Solid& solid, const Place& place, const HeightField& field, double within, std::vector<Candidate>& out) {
  FieldSearch{solid, place, field, within, out}.find();
}

double clearance(const HeightField& field, const Vec3& centre, double radius) {
  const Grid grid{field};
  const Vec3 own = grid.into(centre);
  const double beside =
      std::hypot(std::max(std::fabs(own.x) - 0.5 * field.x, 0.0), std::max(std::fabs(own.y) - 0.5 * field.y, 0.0));
  const double sure = std::max(beside, own.z - field.highest) - radius;
  if (sure > 0) return sure;
  // What is farther away than `around` does not matter.
  const double around = 2 * radius;
  const Range columns = grid.columns(own.x - radius - around, own.x + radius + around, field.columns - 1),
              rows = grid.rows(own.y - radius - around, own.y + radius + around, field.rows - 1);
  double highest = -HUGE_VAL;
  for (int j = rows.first; j <= rows.last; ++j)
    for (int i = columns.first; i <= columns.last; ++i) highest = std::max(highest, grid.highest_of_cell(i, j));
  return std::max(sure, std::min(around, own.z - radius - highest));
}

NearestPoints distance_to_field(const Solid& solid, const Place& place, const HeightField& field) {
  std::vector<Candidate> touching;
  FieldSearch search{solid, place, field, 0, touching};
  search.find();
  NearestPoints nearest;
  nearest.distance = HUGE_VAL;
  for (const Candidate& c : touching) {
    if (!(c.gap < nearest.distance)) continue;
    const auto [normal, point] = search.meeting(c);
    nearest = {c.gap, point + c.gap * normal, point, normal};
  }
  if (nearest.distance <= 0) return nearest;
  const Grid& grid = search.grid;
  const auto look = [&](int i, int j) {
    for (int which = 0; which < 2; ++which) {
      const auto corners = grid.triangle(i, j, which);
      const double deep = norm(corners[1] - corners[2]);
      std::array<Vec3, 6> prism;
      for (std::size_t k = 0; k < 3; ++k) prism[k] = corners[k], prism[k + 3] = corners[k] - deep * grid.up;
      const NearestPoints there = distance(solid, place, hull(prism), {});
      if (there.distance < nearest.distance) nearest = there;
    }
  };
  const auto nearest_to = [](double x, double extent, double step, int count) {
    return static_cast<int>(std::clamp(std::floor((x + 0.5 * extent) / step), 0.0, count - 1.0));
  };
  const Vec3& p = search.middle;
  look(nearest_to(p.x, field.x, grid.dx, field.columns - 1), nearest_to(p.y, field.y, grid.dy, field.rows - 1));
  const double reach = solid.reach + nearest.distance;
  const Range columns = grid.columns(p.x - reach, p.x + reach, field.columns - 1),
              rows = grid.rows(p.y - reach, p.y + reach, field.rows - 1);
  for (int j = rows.first; j <= rows.last; ++j)
    for (int i = columns.first; i <= columns.last; ++i) {
      const Vec3 low = grid.own(i, j);
      const Vec3 apart{std::max({low.x - p.x, p.x - low.x - grid.dx, 0.0}), std::max({low.y - p.y, p.y - low.y - grid.dy, 0.0}),
                       std::max(p.z - grid.highest_of_cell(i, j), 0.0)};
      if (norm(apart) - solid.reach < nearest.distance) look(i, j);
    }
  return nearest;
}

}  // namespace momentree::contact
