#pragma once
// Cylinders before solids with corners and edges: boxes, hulls and capsules.
#include <vector>

#include <momentree/contact/candidates.hpp>

namespace momentree::contact {

/// All pairs of features of a cylinder and another solid, which is no cylinder and no ball, with a gap below `within`: corners
/// before the side and the ends, edges that cross the side or a rim, rims before faces. `second`: the cylinder is the second
/// solid of the pair.
void cylinder_faces(const Solid& cylinder, const Place& of_cylinder, const Solid& other, const Place& of_other, bool second,
                    double within, std::vector<Candidate>& out);

/// How far a rim is from lying in a plane, or an edge from lying in the plane of a rim: the sine of the angle, and its rate
/// (1/s). There the nearest point of the rim jumps to the other side. Infinite for other features.
struct Tilt {
  double sine = HUGE_VAL, rate = 0;
};
Tilt tilt_of(const Features& features, const Place& a, const Place& b);

}  // namespace momentree::contact
