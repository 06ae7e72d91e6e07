#pragma once
// A joint by itself, in its own frame: where it puts the child, which way it lets it move, and back from a pose to coordinates.
// For changes of joints and for reading files; the sweeps have their kernels.
#include <optional>
#include <vector>

#include <momentree/joint/joint.hpp>
#include <momentree/math/spatial.hpp>

namespace momentree {

/// Pose of the joint's frame after its motion in its frame before, at coordinates q (nq numbers).
Pose joint_motion(const JointSpec& joint, const double* q);

/// Columns of E, (6): a spatial velocity per freedom, in the joint's frame after its motion.
std::vector<Motion<double>> joint_dofs(const JointSpec& joint, const double* q);

/// Coordinates at which the joint has that motion; nothing where it can't. Of angles that differ by turns the one nearest to
/// `hint` is taken.
std::optional<Values> joint_coordinates(const JointSpec& joint, const Pose& motion, double hint);

/// Coordinates of no motion.
Values joint_zero(Kind kind);

namespace coordinates {

/// How far a pose may be from what a joint can represent (rad; m per m).
inline constexpr double tolerance = 1e-12;

bool negligible(const Vec3& displacement);
bool negligible(const Quat& rotation);
/// The angle nearest to `hint` by which `rotation` turns about the unit vector `axis`; false where it turns about another.
bool about_axis(const Vec3& axis, const Quat& rotation, double hint, double& angle);
/// The length of `displacement` along the unit vector `axis`; false where it goes elsewhere.
bool along_axis(const Vec3& axis, const Vec3& displacement, double& length);
/// The angle, turned by full turns to the one nearest to `hint`, and `hint` itself where only rounding is between them.
double unwrapped(double angle, double hint);

}  // namespace coordinates
}  // namespace momentree
