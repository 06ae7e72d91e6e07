#pragma once
// A world in maximal coordinates: six velocities per body, and every joint, of the tree or closing a loop, only as equations
// between them. The equations are written down from the poses of the bodies and the declaration of the joint; they share no code
// with the engine.
#include <Eigen/Dense>

#include <momentree/simulate/simulation.hpp>

namespace momentree::oracle {

using WideMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using WideVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// The numbers of all joints of a world, those that close loops last.
std::vector<JointId> all_joints(const World& world);

/// Velocity of the centre of mass and angular velocity of every body, world axes.
WideVector body_velocities(const World& world);

/// Rows C of one joint: C V = 0 for velocities V that it allows. At most six.
WideMatrix joint_rows(const World& world, JointId joint);

/// The projection of velocities onto those that all joints of the world allow, which is the least change as measured by the
/// masses: the velocities after a plastic impact.
class Projection {
 public:
  /// Bodies must not have armatures at their joints.
  explicit Projection(const World& world);

  WideVector operator()(const WideVector& velocities) const;
  long double energy(const WideVector& velocities) const { return 0.5L * velocities.dot(mass_ * velocities); }
  const WideMatrix& mass() const { return mass_; }
  /// Number of the loops' rows, and how many are independent of each other and of the tree's joints.
  int rows() const { return static_cast<int>(pivots_.size()); }
  int rank() const { return rank_; }
  /// What remains of a unit row, squared, once those before it and the tree's are removed; largest first. Redundant rows have
  /// round-off.
  const std::vector<long double>& pivots() const { return pivots_; }
  /// Whether a pivot leaves open which rows are independent.
  bool undecided() const;
  /// The smallest pivot of an independent row; 1 without loops.
  double smallest() const { return rank_ == 0 ? 1 : static_cast<double>(pivots_[static_cast<std::size_t>(rank_ - 1)]); }

 private:
  WideMatrix mass_, root_;  // M = L Lᵀ
  WideMatrix constrained_;  // orthonormal: directions of Lᵀ V that joints block
  std::vector<long double> pivots_;
  int rank_ = 0;
};

}  // namespace momentree::oracle
