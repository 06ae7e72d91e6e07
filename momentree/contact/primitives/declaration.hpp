#pragma once
// What the file of a primitive shape has: a struct with
//   static constexpr PrimitiveInfo info;                              // what documents call it
//   its sizes (m), and a describe() of them (base/describe.hpp)
//   Solid solid(const Pose& at) const;                                // what it touches with
//   static std::optional<Placed<…>> from(const Solid&);               // the inverse, for solids that have no document
//   UniformBody uniform() const;                                      // for masses by density
//   StandardSolid standard() const;                                   // only if other programs have that shape
//   static Vec3 farthest(…), farthest_rate(…);                        // only if solid() is a smooth one: see SmoothSurface
// in axes with its centre of mass at the origin. A document has the only member of a shape as its value, several as a table.
// Without standard() it is drawn by the triangles of its solid.
#include <momentree/base/describe.hpp>
#include <momentree/contact/shapes/solid.hpp>

namespace momentree::contact {

struct PrimitiveInfo {
  const char* key;
  const char* plural;
  const char* about;  ///< in one line, as "A box"; the only member's text follows
};

/// Volume and principal moments of inertia at a density of 1, about the centre of mass.
struct UniformBody {
  double volume = 0;
  Vec3 moments{};
};

/// A shape of viewers and of file formats for pictures.
struct StandardSolid {
  enum class Kind { box, ellipsoid, cylinder, capsule };
  Kind kind = Kind::box;
  /// m. box: its edges; ellipsoid: its diameters; cylinder and capsule: the diameter twice, and the length along z, of a capsule
  /// between the centres of its caps
  Vec3 size{};
};

template <class Shape>
struct Placed {
  Shape shape{};
  Pose at{};
};

inline Quat rotation_from_axes(const Vec3& x, const Vec3& y, const Vec3& z) {
  return quaternion_of({x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z});
}
/// In the middle between two points, with z from one to the other.
Pose placed_along_z(const Vec3& from, const Vec3& to);

}  // namespace momentree::contact
