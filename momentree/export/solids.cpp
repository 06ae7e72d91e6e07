#include <momentree/export/solids.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <momentree/text/colour.hpp>

namespace momentree::io {

namespace {

/// Principal moments and axes (columns of a rotation) of a symmetric matrix; Jacobi's method.
struct Principal {
  std::array<double, 3> moments{};
  Mat3 axes{};
};

Principal principal_of(const Sym3& I) {
  std::array<std::array<double, 3>, 3> a{{{I.xx, I.xy, I.xz}, {I.xy, I.yy, I.yz}, {I.xz, I.yz, I.zz}}};
  std::array<std::array<double, 3>, 3> v{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int sweep = 0; sweep < 30; ++sweep) {
    const double off = std::abs(a[0][1]) + std::abs(a[0][2]) + std::abs(a[1][2]);
    if (off <= 1e-15 * (std::abs(a[0][0]) + std::abs(a[1][1]) + std::abs(a[2][2]))) break;
    for (const auto& [p, q] : {std::pair<std::size_t, std::size_t>{0, 1}, {0, 2}, {1, 2}}) {
      if (a[p][q] == 0) continue;
      const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
      const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::hypot(theta, 1.0));
      const double c = 1 / std::hypot(t, 1.0), s = t * c;
      const auto mix = [c, s](double& x, double& y) {
        const double before = x;
        x = c * before - s * y, y = s * before + c * y;
      };
      for (std::size_t k = 0; k < 3; ++k) mix(a[k][p], a[k][q]);
      for (std::size_t k = 0; k < 3; ++k) mix(a[p][k], a[q][k]);
      for (std::size_t k = 0; k < 3; ++k) mix(v[k][p], v[k][q]);
    }
  }
  return {{a[0][0], a[1][1], a[2][2]}, {v[0][0], v[0][1], v[0][2], v[1][0], v[1][1], v[1][2], v[2][0], v[2][1], v[2][2]}};
}

/// The ellipsoid of uniform density with the body's mass and inertia, as the report draws it; nothing for a point mass, and for a
/// body that its lines show.
std::optional<Solid> ellipsoid_of(const RecordedBody& body) {
  if (!body.inertia || !(body.mass > 0) || !body.extent.empty()) return std::nullopt;
  const auto [moments, axes] = principal_of(*body.inertia);
  if (!(*std::ranges::max_element(moments) > 0)) return std::nullopt;
  const double sum = moments[0] + moments[1] + moments[2];
  std::array<double, 3> half{};
  for (std::size_t k = 0; k < 3; ++k) half[k] = std::sqrt(std::max(2.5 / body.mass * (sum - 2 * moments[k]), 0.0));
  const double longest = *std::ranges::max_element(half);
  for (double& length : half) length = std::max(length, 0.12 * longest);  // of inertias that are not those of any body, too
  return Solid{
      .kind = Solid::Kind::ellipsoid, .size = {2 * half[0], 2 * half[1], 2 * half[2]}, .at = {body.com, quaternion_of(axes)}};
}

class SolidBuilder {
 public:
  SolidBuilder(Recording& run, double length) : run_(run), radius_(0.045 * length), all_(run.bodies.size()) {}

  std::vector<std::vector<Solid>> build() {
    for (std::size_t b = 0; b < run_.bodies.size(); ++b) add_shapes(b);
    for (std::size_t b = 0; b < run_.bodies.size(); ++b) shaped_.push_back(!all_[b].empty());
    for (std::size_t b = 0; b < run_.bodies.size(); ++b) add_lines(b);
    return std::move(all_);
  }

 private:
  void add_shapes(std::size_t b) {
    const RecordedBody& body = run_.bodies[b];
    mesh_.push_back(0), reach_.push_back(0);
    add_shape(b, body.shape, run_.parts_of(body, 0));
    for (std::size_t i = 0; i < body.shape.more.size(); ++i) add_shape(b, body.shape.more[i], run_.parts_of(body, i + 1));
    if (all_[b].empty())
      if (const std::optional<Solid> ellipsoid = ellipsoid_of(body)) ellipsoids_.emplace_back(b, *ellipsoid);
  }

  void add_shape(std::size_t b, const Shape& shape, MeshParts mesh) {
    Solid solid{.at = {shape.at.position, normalized(shape.at.rotation)}, .colour = hex_colour(shape.colour)};
    if (shape.kind == Shape::Kind::mesh) return add_mesh(b, shape, std::move(solid), mesh);
    if (shape.kind != Shape::Kind::primitive || !contact::has_volume(shape.primitive)) return;
    const std::optional<contact::StandardSolid> standard = contact::standard(shape.primitive);
    if (!standard) {
      run_.mesh_parts.push_back(surface_of(contact::solid(shape.primitive, {})));
      return add_mesh(b, shape, std::move(solid), {run_.mesh_parts.size() - 1, 1});
    }
    const Vec3 &s = solid.size = standard->size, half = 0.5 * s;
    solid.kind = static_cast<Solid::Kind>(standard->kind);
    const double reach = solid.kind == Solid::Kind::box         ? norm(half)
                         : solid.kind == Solid::Kind::ellipsoid ? std::max({half.x, half.y, half.z})
                         : solid.kind == Solid::Kind::cylinder  ? std::hypot(half.x, half.z)
                                                                : half.x + half.z;
    reach_[b] = std::max(reach_[b], norm(shape.at.position) + reach);
    all_[b].push_back(std::move(solid));
  }

  void add_mesh(std::size_t b, const Shape& shape, Solid solid, MeshParts mesh) {
    const Vec3& s = shape.scale;
    if (s.x == 0 || s.y == 0 || s.z == 0) return;
    solid.kind = Solid::Kind::mesh, solid.size = s;
    const std::string own = solid.colour;
    for (std::size_t i = mesh.first; i < mesh.first + mesh.count; ++i) {
      const MeshPart& part = run_.mesh_parts[i];
      if (part.triangles.empty()) continue;
      solid.mesh = static_cast<int>(i), solid.colour = own.empty() ? part.colour : own;
      for (const Vec3& p : part.points) reach_[b] = std::max(reach_[b], norm(solid.at * Vec3{s.x * p.x, s.y * p.y, s.z * p.z}));
      mesh_[b] = 1, some_mesh_ = true;
      all_[b].push_back(solid);
    }
  }

  void add_lines(std::size_t b) {
    const RecordedBody& body = run_.bodies[b];
    const auto own = std::find_if(ellipsoids_.begin(), ellipsoids_.end(), [b](const auto& each) { return each.first == b; });
    const bool has_ellipsoid = own != ellipsoids_.end();
    if (has_ellipsoid) all_[b].push_back(own->second);
    const double reach = shaped_[b] ? 1.2 * reach_[b] : 0;
    for (const auto& [from, to] : body.extent)
      if ((reach == 0 || norm(from) > reach || norm(to) > reach) && shows(b, to)) add_rod(b, from, to);
    const bool only_a_frame = some_mesh_ && body.mass == 0;
    if (body.extent.empty() && !shaped_[b] && !has_ellipsoid && !only_a_frame) {
      const double d = 5 * radius_;
      all_[b].push_back({.kind = Solid::Kind::ellipsoid, .size = {d, d, d}, .at = body.com});
    }
  }

  /// Whether a line is drawn although there are meshes: the meshes of its ends show what it would.
  bool shows(std::size_t b, const Vec3& end) const {
    if (!some_mesh_ || (mesh_[b] == 0 && run_.bodies[b].mass > 0)) return true;
    for (std::size_t c = 0; c < run_.bodies.size(); ++c)
      if (run_.bodies[c].parent == static_cast<int>(b) && mesh_[c] == 0 && run_.bodies[c].mass > 0 &&
          norm(run_.bodies[c].at - end) < 1e-9)
        return true;
    return false;
  }

  void add_rod(std::size_t b, const Vec3& from, const Vec3& to) {
    const double length = norm(to - from), d = 2 * radius_;
    if (length > 0)
      all_[b].push_back({.kind = Solid::Kind::capsule, .size = {d, d, length}, .at = {0.5 * (from + to), along_z(to - from)}});
  }

  Recording& run_;
  const double radius_;
  std::vector<std::vector<Solid>> all_;
  std::vector<std::pair<std::size_t, Solid>> ellipsoids_;
  std::vector<double> reach_;  // by body: the distance that its shapes reach from its origin (m)
  std::vector<char> mesh_;     // by body: it has a mesh
  std::vector<bool> shaped_;
  bool some_mesh_ = false;
};

}  // namespace

double typical_length(const Recording& run) {
  std::vector<double> lengths;
  for (const RecordedBody& body : run.bodies)
    for (const auto& [from, to] : body.extent)
      if (const double length = norm(to - from); length > 0) lengths.push_back(length);
  if (lengths.empty()) return 0.2;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

std::vector<std::vector<Solid>> solids_of(Recording& run, double typical_length) {
  return SolidBuilder(run, typical_length).build();
}

Quat shortest_turn(const Vec3& from, const Vec3& to) {
  const double cosine = dot(from, to);
  if (cosine < -1 + 1e-12) {  // half a turn about any axis across
    const Vec3 across = cross(std::abs(from.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, from);
    const Vec3 axis = normalized(across);
    return {0, axis.x, axis.y, axis.z};
  }
  const Vec3 axis = cross(from, to);
  return normalized(Quat{1 + cosine, axis.x, axis.y, axis.z});
}

Pose BarPoses::next(const Vec3& from, const Vec3& to) {
  const double length = norm(to - from);
  if (length > 1e-12) {
    const Vec3 now = (1 / length) * (to - from);
    rotation_ = normalized(shortest_turn(direction_, now) * rotation_);
    direction_ = now;
  }
  return {0.5 * (from + to), rotation_};
}

Vec3 bar_scale(double radius, const Vec3& from, const Vec3& to) {
  return {2 * radius, 2 * radius, std::max(norm(to - from), 1e-6)};
}

Quat along_z(const Vec3& direction) { return shortest_turn({0, 0, 1}, normalized(direction)); }

}  // namespace momentree::io
