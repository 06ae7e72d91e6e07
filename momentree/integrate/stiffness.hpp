#pragma once
// Joints that are too stiff for fixed steps: dampers and servos that decay, or springs that oscillate, faster than a method can
// follow.
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <momentree/tree/tree.hpp>

namespace momentree {

/// A DoF whose damper or spring makes steps of some length unstable.
struct StiffJoint {
  int joint = -1;             ///< the joint's number
  bool damper = false;        ///< true: damper; false: spring
  bool servo = false;         ///< the damper or spring of position control: kd or kp
  bool turns = false;         ///< units N m s/rad and kg m²; otherwise N s/m and kg
  double coefficient = 0;     ///< damping or stiffness
  double inertia = 0;         ///< inertia against an effort in this DoF, with all other joints free and loops closed
  double longest_step = 0;    ///< longest stable step (s)
  bool damped_helps = false;  ///< the method "damped" is stable at the given step

  /// "the servo of joint 'arm/wrist' (kd = 80 N m s/rad on 0.0002 kg m^2) is too stiff for steps of 0.001 s".
  std::string what(std::string_view joint_name, double step) const;
  /// "use method = "damped", or a step below 7e-06 s".
  std::string cure() const;
};

/// The joint for which steps of that length (s) by that method are furthest from stable, with the inertia at coordinates q; empty
/// if none is certainly unstable. Checks only linear dampers, springs and position control, each by itself, and only for
/// fixed-step methods. In very large worlds it checks only those with the largest coefficients. Set-up only: allocates.
std::optional<StiffJoint> too_stiff(const Tree& tree, std::span<const double> q, std::string_view method, double step);

/// A spring between two points, or its damper, that makes steps of some length unstable.
struct StiffSpring {
  int spring = -1;
  bool damper = false;      ///< true: its damper
  double coefficient = 0;   ///< damping (N s/m) or stiffness (N/m)
  double mass = 0;          ///< mass against a force along the spring, with all joints free and loops closed (kg)
  double longest_step = 0;  ///< longest stable step (s)

  /// "spring 'rope' (stiffness = 1e+06 N/m on 0.5 kg) is too stiff for steps of 0.01 s".
  std::string what(std::string_view name, double step) const;
  /// "use a step below 0.002 s, or an adaptive method".
  std::string cure() const;
};

/// The same for springs between two points that are not slack at coordinates q; their dampers are explicit in every method.
std::optional<StiffSpring> too_stiff_spring(const Tree& tree, std::span<const double> q, std::string_view method, double step);

}  // namespace momentree
