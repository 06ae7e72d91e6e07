#pragma once
// Derivatives of accelerations. The derivative of the second recursion along a direction of the state is that recursion with
// another right side: with the displacement η = E δq of a joint in the child's axes,
//
//   outward   δΩ = X δΩ_parent − η × (Ω − E u) + δE u + E δu
//             b = −η × X Ω̇_parent + δ(Ω × E u + Ė u) + δE u̇,   W = δ(Ω × M Ω) − δT
//   inward    δŴ of W + Σ Xᵀ (δŴ + M̂ b + η × Tr), with δτ − δEᵀ Tr for the joint forces
//   outward   δΩ̇ = X δΩ̇_parent + b + E δu̇
//
// so that M̂, G and the factors of Mj serve every direction. What depends on a single joint or force law is derived with Duals
// from the functions that the recursions use.
//
// Directions have nv numbers δq and nv numbers δv, in the order of p. δq is a displacement like v·dt: of ball and free joints a
// rotation (rad) and a translation (m) in child axes. Locked DoFs and those with a prescribed motion do not move.
#include <memory>
#include <span>

#include <momentree/dynamics/workspace.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// A part of a model whose derivatives are not available.
struct NotDifferentiable {
  enum class Part : unsigned char {
    none,
    loop_joint,  ///< a joint that closes a loop with forces, a motion, an armature or a lock of its own
    contact,
    joint_function,
    body_function
  } part = Part::none;
  int number = -1;  ///< of the loop by its place, of the joint's carrier, or of the body
};
/// The first such part that acts in the evaluated state.
[[nodiscard]] NotDifferentiable not_differentiable(const Tree& tree, const Workspace<double>& workspace) noexcept;

/// Memory for one tree, also after changes of its topology.
class AccelerationTangent {
 public:
  explicit AccelerationTangent(const Tree& tree);
  AccelerationTangent(AccelerationTangent&&) noexcept;
  AccelerationTangent& operator=(AccelerationTangent&&) noexcept;
  ~AccelerationTangent();

  /// Evaluates the accelerations of a state, of which nothing may be `not_differentiable`; the workspace then belongs to this
  /// state until the last call of `along`. With loops it allocates.
  void prepare(const Tree& tree, const State& state, Workspace<double>& workspace);
  /// Changes directions (as of `along`) to the nearest ones that locks and closed loops allow: J δq = 0 and δ(J v) = 0.
  void allow(int count, double* dq, double* dv) noexcept;
  /// δv̇ along each of `count` directions: δq, δv and the results have nv numbers for each, one direction after the other. A null
  /// pointer: zeros. With loops, the directions are those that `allow` leaves unchanged. Does not allocate.
  void along(int count, const double* dq, const double* dv, double* da) noexcept;

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

/// The rate of a displacement: d(δq)/dt of each direction for δv, at the velocities of the state: δv, and for ball and free
/// joints δv − v × δq.
void displacement_rates(const Tree& tree, const double* v, const double* dq, const double* dv, double* rate) noexcept;
/// q moved by a displacement of nv numbers.
void displace(const Tree& tree, const double* dq, double* q) noexcept;

}  // namespace momentree
