#pragma once
// Which features of two solids are nearest.
#include <cstdint>
#include <vector>

#include <momentree/contact/shapes/feature.hpp>
#include <momentree/contact/shapes/solid.hpp>

namespace momentree::contact {

/// Two features of two solids that face each other. `id` stays the same while they do.
struct Candidate {
  Features features;
  bool swapped = false;  ///< body a of `features` is that of the second solid
  std::uint64_t id = 0;
  double gap = 0;  ///< m; of points around the rim of a cylinder that stands on its end, that of the lowest
};

/// A half-space below a plane of the second body's frame: all points of the first solid with a gap below `within`.
void face_plane(const Solid& solid, const Place& place, const Vec3& point, const Vec3& normal, const Place& of_plane,
                double within, std::vector<Candidate>& out);

/// A cylinder whose rim is higher on one side by less than twice this stands on its end (m).
inline constexpr double standing = 1e-9;
/// Then so many points of its rim carry it.
inline constexpr std::size_t points_of_rim = 8;

/// All pairs of features with a gap below `within`: vertices before faces, edges that cross, and for rounded solids also vertices
/// before edges and vertices. The solids overlap by little at most.
void face_each_other(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other, double within,
                     std::vector<Candidate>& out);

/// Edges that cross, with a gap between −deepest and `within`: directions in which the solids can be separated.
void cross_edges(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other, double within,
                 double deepest, std::vector<Candidate>& out);

}  // namespace momentree::contact
