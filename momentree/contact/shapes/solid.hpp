#pragma once
// Convex solids that can touch: a point, a line or a polyhedron, rounded by a radius. A sphere is a rounded point, a capsule a
// rounded line, a box and a convex mesh are polyhedra. A cylinder has a prism for rough tests. Ellipsoids and other smooth solids
// have support functions (smooth.hpp), and a ball in them.
#include <array>
#include <span>
#include <vector>

#include <momentree/contact/shapes/smooth.hpp>

namespace momentree::contact {

struct Solid {
  struct Edge {
    int ends[2];
    int faces[2];  ///< on both sides; −1 for the line of a capsule
  };
  struct Face {
    Vec3 normal;               ///< outward
    double offset = 0;         ///< normal·x of its points
    std::vector<int> corners;  ///< counterclockwise, seen from outside
    int plane = 0;             ///< the first face of the same plane
  };
  std::vector<Vec3> vertices;  ///< in the body's frame (m)
  std::vector<Edge> edges;     ///< without those between faces of one plane
  std::vector<Face> faces;
  std::vector<std::vector<Vec3>> along;  ///< by vertex: unit vectors along its edges
  double radius = 0;                     ///< of the rounding (m)
  Vec3 centre{};                         ///< of a sphere around everything
  double reach = 0;                      ///< and its radius
  double thickness = 0;                  ///< nothing that moves less than this passes through (m)
  double rim = 0;                        ///< radius of a cylinder (m); 0: not a cylinder
  std::array<Vec3, 2> ends{};            ///< of a cylinder: the centres of its ends (m)
  Axes axes{};                           ///< of a smooth solid, whose vertex and radius are those of a ball in it; zero: not one
  unsigned char surface = 0;             ///< of a smooth solid: its number for smooth_surface(); 0: an ellipsoid
  /// Its surface runs around this axis, as that of a conveyor belt, a roller or a track does: where its outward normal is n, with
  /// belt × n relative to the body (m/s).
  Vec3 belt{};

  bool is_smooth() const { return axes[0] != Vec3{}; }
  friend bool operator==(const Solid& a, const Solid& b) {
    return a.vertices == b.vertices && a.radius == b.radius && a.rim == b.rim && a.axes == b.axes && a.surface == b.surface &&
           a.belt == b.belt;
  }
};

/// Solids with their centres at `at` in the body's frame. Sizes must be positive.
Solid sphere(double radius, const Pose& at = {});
/// Along z, of that length between the centres of its caps.
Solid capsule(double radius, double length, const Pose& at = {});
Solid box(const Vec3& size, const Pose& at = {});
Solid ellipsoid(const Vec3& semi_axes, const Pose& at = {});
/// A smooth solid with these sizes along its axes. contact::solid() adds the number of its surface.
Solid smooth_solid(const SmoothSurface& surface, const Vec3& sizes, const Pose& at);
/// Along z. Its polyhedron is a prism of `cylinder_sides` sides, which are as far inside of it as its edges are outside.
Solid cylinder(double radius, double length, const Pose& at = {});
inline constexpr int cylinder_sides = 16;
/// The convex hull of points; without vertices if they lie in a plane.
Solid hull(std::span<const Vec3> points);
/// The hull of some of them: at most so many, and none that is closer to it than `tolerance` times its size. `beyond`: how far
/// points are outside of it (m).
Solid hull_within(std::span<const Vec3> points, std::size_t most, double tolerance, double& beyond);
/// Of a polyhedron (m³).
double volume(const Solid& solid);

}  // namespace momentree::contact
