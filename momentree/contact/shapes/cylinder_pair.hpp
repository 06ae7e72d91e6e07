#pragma once
// Two cylinders: ends, sides and rims that face each other.
#include <vector>

#include <momentree/contact/candidates.hpp>
#include <momentree/contact/shapes/distance.hpp>

namespace momentree::contact {

/// All pairs of features of two cylinders with a gap below `within`.
void cylinders_face(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other, double within,
                    std::vector<Candidate>& out);

/// Appends the points in the direction in which two cylinders overlap least, or are farthest apart, with a gap below `within`
/// (m).
void cylinders_overlap_points(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other,
                              double within, std::vector<Candidate>& out);

/// Zero, without a normal, if they overlap.
NearestPoints cylinders_distance(const Solid& one, const Place& place_one, const Solid& other, const Place& place_other);

}  // namespace momentree::contact
