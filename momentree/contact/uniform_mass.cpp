#include <momentree/contact/uniform_mass.hpp>

#include <momentree/math/point_inertia.hpp>

namespace momentree {

MassProperties mass_properties(const contact::Primitive& shape, const Pose& at, double density) {
  const contact::UniformBody body = contact::uniform(shape);
  const Vec3 moments = density * body.moments;
  return {density * body.volume, at.position, rotate(rotation_matrix(at.rotation), diagonal(moments.x, moments.y, moments.z))};
}

MassProperties mass_properties(std::span<const Vec3> points, std::span<const std::array<std::uint32_t, 3>> triangles,
                               double density) {
  // The tetrahedra between the triangles and a point near them: their signed volumes add up to the body. The integral of x xᵀ
  // over one with corners 0, a, b, c is its volume times (s sᵀ + a aᵀ + b bᵀ + c cᵀ) / 20, with s = a + b + c.
  const Vec3 origin = points.empty() ? Vec3{} : points[0];
  const auto each = [&](const auto& tetrahedron) {
    for (const auto& [i, j, k] : triangles) {
      const Vec3 a = points[i] - origin, b = points[j] - origin, c = points[k] - origin;
      tetrahedron(dot(a, cross(b, c)) / 6, a, b, c);
    }
  };
  double volume = 0;
  Vec3 moment{};
  each([&](double v, const Vec3& a, const Vec3& b, const Vec3& c) { volume += v, moment += v / 4 * (a + b + c); });
  if (volume == 0) return {};
  const Vec3 centre = (1 / volume) * moment;
  const double scale = volume < 0 ? -density : density;
  Sym3 inertia = point_inertia(-scale * volume, centre);
  each([&](double v, const Vec3& a, const Vec3& b, const Vec3& c) {
    for (const Vec3& x : {a + b + c, a, b, c}) inertia = inertia + point_inertia(scale * v / 20, x);
  });
  return {scale * volume, origin + centre, inertia};
}

MassProperties sum_of(std::span<const MassProperties> parts) {
  MassProperties sum;
  Vec3 moment{};
  for (const MassProperties& part : parts) sum.mass += part.mass, moment += part.mass * part.com;
  if (!(sum.mass > 0)) return {};
  sum.com = (1 / sum.mass) * moment;
  for (const MassProperties& part : parts)
    sum.inertia = sum.inertia + part.inertia + point_inertia(part.mass, part.com - sum.com);
  return sum;
}

}  // namespace momentree
