#pragma once
// The distance of two solids, however far apart they are.
#include <momentree/contact/shapes/feature.hpp>
#include <momentree/contact/shapes/solid.hpp>

namespace momentree::contact {

struct NearestPoints {
  double distance = 0;        ///< m; negative: they overlap by that, at most as deep as they are rounded
  Vec3 on_one{}, on_other{};  ///< the nearest points (m), in the world
  Vec3 normal{};              ///< unit vector from the second solid to the first; zero if polyhedra overlap
};

/// By the algorithm of Gilbert, Johnson and Keerthi on the polyhedra, less the radii: exact to rounding. Cylinders by their
/// features, a ball before a cylinder in closed form.
NearestPoints distance(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other);

/// The same of their polyhedra alone: a cylinder as a prism.
NearestPoints distance_of_polyhedra(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other);

/// Above a plane of the world, in closed form, also of a cylinder.
NearestPoints distance_to_plane(const Solid& solid, const Place& place, const Vec3& point, const Vec3& normal);

}  // namespace momentree::contact
