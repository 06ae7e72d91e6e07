#pragma once
// The motion of a single joint in its own frame: pose of the child, directions of motion, and the coordinates for a given pose.
// For joint changes and file readers; the recursions use the kernels instead.
#include <optional>
#include <vector>

#include <momentree/joint/closure.hpp>
#include <momentree/joint/joint.hpp>
#include <momentree/joint/turns.hpp>
#include <momentree/math/spatial.hpp>

namespace momentree {

/// Pose of the joint's child-side frame in its parent-side frame, at coordinates q (nq numbers).
Pose joint_motion(const JointSpec& joint, const double* q);

/// Columns of E, (6): a spatial velocity per DoF, in the joint's child-side frame.
std::vector<Motion<double>> joint_dofs(const JointSpec& joint, const double* q);

/// Coordinates at which the joint has that motion; empty if the joint cannot represent it. Of angles that differ by full turns,
/// the one nearest to `hint` is returned.
std::optional<Values> joint_coordinates(const JointSpec& joint, const Pose& motion, const Turns& hint);

/// The angles among coordinates q.
Turns turns_of(Kind kind, const double* q) noexcept;

/// The coordinates that come nearest to a motion that the joint may represent only approximately.
void nearest_coordinates(const JointSpec& joint, const Pose& motion, const Turns& hint, double* q) noexcept;

/// The equations that hold the joint closed if it is not part of the tree.
Closure closure_of(const JointSpec& joint) noexcept;

/// The same for a joint with locked DoFs (a bit each), held at coordinates `held` (nq numbers): the rows, and by how much the
/// frames that they concern are displaced from the joint's own. Empty if the kind has no such rows: it then can only be locked as
/// a whole.
struct LockedForm {
  Closure rows{};
  Pose parent{}, child{};
};
std::optional<LockedForm> locked_form(const JointSpec& joint, unsigned locked, const Values& held) noexcept;

/// joint_dofs without allocation: writes at most 6 columns and returns their number.
int joint_columns(const JointSpec& joint, const double* q, Motion<double>* columns) noexcept;
/// Their rates Ė at velocities u, one per column.
void joint_columns_rate(const JointSpec& joint, const double* q, const double* u, Motion<double>* rates) noexcept;
/// Ė u of these columns at velocities u.
Motion<double> joint_columns_drift(const JointSpec& joint, const double* q, const double* u) noexcept;

/// The wrench on the child, about the origin of the joint's child-side frame and in its axes, by which forces along the DoFs (nv
/// numbers, N m, N) act. `locked`: a bit per DoF without force.
Force<double> joint_wrench(const JointSpec& joint, const double* q, unsigned locked, const double* force) noexcept;

/// Coordinates of zero displacement.
Values joint_zero(Kind kind);

namespace coordinates {

/// Largest deviation of a pose from the motions that a joint can represent (rad; m per m).
inline constexpr double tolerance = 1e-12;

bool negligible(const Vec3& displacement);
bool negligible(const Quat& rotation);
/// The angle nearest to `hint` by which `rotation` turns about the unit vector `axis`; false if it also turns about another axis.
bool about_axis(const Vec3& axis, const Quat& rotation, double hint, double& angle);
/// The length of `displacement` along the unit vector `axis`; false if it also has another direction.
bool along_axis(const Vec3& axis, const Vec3& displacement, double& length);
/// The angle shifted by full turns to the one nearest to `hint`; `hint` itself if they differ by rounding only.
double unwrapped(double angle, double hint);

}  // namespace coordinates
}  // namespace momentree
