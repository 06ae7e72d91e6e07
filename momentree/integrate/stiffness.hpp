#pragma once
// Joints that are too stiff for fixed steps: dampers and servos that die away, springs that swing, faster than a method can
// follow.
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <momentree/tree/tree.hpp>

namespace momentree {

/// One freedom whose damper or spring makes steps of some length unstable.
struct StiffJoint {
  int joint = -1;             ///< by its number
  bool damper = false;        ///< else a spring
  bool servo = false;         ///< that of position control: kd or kp
  bool turns = false;         ///< N m s/rad and kg m², not N s/m and kg
  double coefficient = 0;     ///< damping or stiffness
  double inertia = 0;         ///< that an effort in this freedom meets, all other joints being free
  double longest_step = 0;    ///< above it steps are unstable (s)
  bool damped_helps = false;  ///< the method "damped" is stable at the step that was asked about

  /// "the servo of joint 'arm/wrist' (kd = 80 N m s/rad on 0.0002 kg m^2) is too stiff for steps of 0.001 s".
  std::string what(std::string_view joint_name, double step) const;
  /// "use method = "damped", or a step below 7e-06 s".
  std::string cure() const;
};

/// The joint for which steps of that length by that method are the furthest from stable, by the inertia at coordinates q; nothing
/// where none is unstable for certain: linear dampers, springs and position control alone are looked at, each by itself, and for
/// methods of fixed step. Of very large worlds only those with the largest coefficients are. Set-up only: allocates.
std::optional<StiffJoint> too_stiff(const Tree& tree, std::span<const double> q, std::string_view method, double step);

}  // namespace momentree
