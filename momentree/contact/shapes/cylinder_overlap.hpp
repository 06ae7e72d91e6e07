#pragma once
// The points at which a cylinder touches a polyhedron that it may overlap, for time stepping.
#include <vector>

#include <momentree/contact/candidates.hpp>

namespace momentree::contact {

/// The solids, one of them a polyhedron or a capsule, have a point in common. Exact.
bool cylinder_overlaps(const Solid& cylinder, const Place& of_cylinder, const Solid& other, const Place& of_other);

/// Appends the points in the direction in which a cylinder and such a solid overlap least, or are farthest apart, with a gap
/// below `within` (m). `second`: the cylinder is the second solid of the pair.
void cylinder_overlap_points(const Solid& cylinder, const Place& of_cylinder, const Solid& other, const Place& of_other,
                             bool second, double within, std::vector<Candidate>& out);

}  // namespace momentree::contact
