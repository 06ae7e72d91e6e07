#pragma once
// Constants of a body's inboard link, in the frames that the kernels use.
//
// The kernel frame of a body has its origin at the inboard joint (child side) and its z axis along the joint's axis if the kind
// has one. A body that floats on the ground has it at its own centre of mass, so that the joint-space mass of a free joint is
// well conditioned wherever the user's frame is. The frame is fixed in the body; `Tree` stores its pose in the user's frame of
// the body (KernelFrame).
#include <momentree/joint/variant.hpp>
#include <momentree/math/spatial.hpp>

namespace momentree {

/// The terms that a link's placement has; kernels omit the others. Found when a topology is compiled.
enum class PlacementShape : unsigned char {
  general,        ///< any rotation, any offset
  tilted,         ///< β = 0: the parent's x axis is perpendicular to both joint axes
  screw,          ///< in addition, the offset is r.x along that x axis and d along the joint's own axis (Denavit–Hartenberg)
  screw_a,        ///< d = 0
  screw_d,        ///< r.x = 0: the axes intersect
  right,          ///< α = 90°, both offsets
  right_a,        ///< α = 90°, d = 0
  right_d,        ///< α = 90°, r.x = 0
  right_meeting,  ///< α = 90°, no offset
  parallel,       ///< α = 0, both offsets
  parallel_a,     ///< α = 0, d = 0: a link in a plane
};

/// Placement of the joint in the parent's frame: R = Rz(β) Rx(α) Rz(θ0), where kinds that rotate about z add θ0 to their own
/// angle; origin at r (m); mass properties in the body's kernel frame. Rotations about one axis at a time cost half of a general
/// one, and β = 0 if the parent's x axis could be chosen for this link. Links that are made and placed alike have equal
/// constants, and a tree stores equal links once.
struct LinkConstants {
  double cos_a = 1, sin_a = 0;
  double cs_a = 0, ss_a = 0;  ///< cos α sin α, sin² α
  Vec3 r{};
  double d = 0;  ///< if the shape has it: r = r.x along the parent's x, plus d along the joint's axis
  double cos_b = 1, sin_b = 0;
  RigidMass body{};
  Mat3 R0 = identity3<double>();  ///< Rz(β) Rx(α) Rz(θ0)
  PlacementShape shape{};
  unsigned char locked = 0;  ///< a bit per DoF without a momentum of its own: frozen or driven
  unsigned char driven = 0;  ///< a bit per DoF among these whose rate is prescribed: p holds the rate
  double cos_0 = 1, sin_0 = 0;
  double angle_0 = 0;  ///< θ0
  /// Helical: metres per radian. Universal: x and z components of the first axis. Free: vector from the joint's child-side origin
  /// to that of the kernel frame (m), in the latter's axes.
  double geometry[3] = {0, 0, 0};
};
/// True if the link needs no rotation about the parent's z axis (β = 0).
inline bool aligned(const LinkConstants& link) { return link.sin_b == 0 && link.cos_b == 1; }
/// Sets what follows from α, β and θ0: cs_a, ss_a and R0.
void find_rotation(LinkConstants& link);
/// Rz(β) Rx(α) Rz(θ0).
Mat3 placement_rotation(const LinkConstants& link);
/// Rz(β) Rx(α): for kinds that add θ0 to their own angle.
Mat3 tilt_rotation(const LinkConstants& link);

}  // namespace momentree
