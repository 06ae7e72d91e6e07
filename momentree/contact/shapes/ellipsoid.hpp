#pragma once
// Ellipsoids before planes, lines and each other, and before whole solids.
//
// With the rows of M along its semi-axes, an ellipsoid extends by h(n) = |M n| beyond its centre along n, to the point
// x(n) = Mᵀ M n/h, which moves by H = (Mᵀ M − x xᵀ)/h as n turns. Two of them are nearest along the n for which the way from the
// point of b to that of a, g = c_a − x_a(n) − c_b − x_b(n), is parallel to n: there n·g, by which planes separate them, is
// largest. A point is an ellipsoid without extent, the rim of a cylinder a flat one; before a line n is perpendicular to it.
// Other smooth solids have h, x and H of their own.
#include <vector>

#include <momentree/contact/candidates.hpp>
#include <momentree/contact/shapes/distance.hpp>

namespace momentree::contact {

/// Gap, normal, point and rates of the FeaturePairs of ellipsoids, without rounding; `rate`: of the point.
void ellipsoid_before(const Features& features, const Place& a, const Place& b, Touch& out, Vec3& rate) noexcept;

/// Features that are nearest, or overlap least where the ellipsoid is deeper in the other solid than its smallest radius of
/// curvature. `swapped`: the ellipsoid is the second solid.
Candidate nearest_of_ellipsoid(const Solid& ellipsoid, const Place& of_ellipsoid, const Solid& other, const Place& of_other,
                               bool swapped = false);

/// The distance of the same.
NearestPoints ellipsoid_distance(const Solid& ellipsoid, const Place& of_ellipsoid, const Solid& other, const Place& of_other);

}  // namespace momentree::contact
