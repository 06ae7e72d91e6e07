#pragma once
// The experiments carried out with every engine, and their exact results: found in maximal coordinates, without any engine.
// Nothing here allocates through Eigen: the engines' packages and momentree may be compiled for different CPUs.
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace peers {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A body and its inboard joint: free (a root), or revolute about z (in evaluations also prismatic along z) of a frame at (turn,
/// at) in the parent's frame; at angle zero the body's frame is that frame. SI units.
struct Link {
  std::string name;
  int parent = -1;
  bool free = false, slides = false;
  Matrix3d turn = Matrix3d::Identity();
  Vector3d at = Vector3d::Zero();
  double mass = 1;
  Vector3d com = Vector3d::Zero();
  Vector3d inertia = Vector3d::Ones();   ///< principal, about the centre of mass
  Matrix3d axes = Matrix3d::Identity();  ///< the principal axes, in the body's frame: nontrivial only in evaluations
  double angle = 0, rate = 0;            ///< of a revolute joint, at the start
  Vector3d linear = Vector3d::Zero();    ///< of a free body's origin at the start, world axes
  Vector3d angular = Vector3d::Zero();
};

/// Pose of a body's frame, velocity of its origin, angular velocity: world axes.
struct Motion {
  Matrix3d R;
  Vector3d p, v, w;
};

enum class Change { cut, lock, capture };

struct Experiment {
  std::string name;
  std::vector<Link> links;  ///< parents before children
  Change change;
  int body;                 ///< the body whose inboard joint is cut or locked, or the root that is captured
  int to = -1;              ///< capture: the body to which it is welded, in the present poses
  std::vector<int> judged;  ///< bodies whose momentum is compared: the part cut off, or all
};

std::vector<Experiment> experiments();

/// Motion of the bodies at the start, by forward kinematics.
std::vector<Motion> start(const Experiment& experiment);

/// Their motion immediately after the change: the initial velocities projected, in the mass metric, onto those that the joints
/// allow afterwards. This is the result of any instantaneous change caused by the forces of ideal joints.
std::vector<Motion> exact(const Experiment& experiment);

struct EnergyLedger {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();  ///< of the compared bodies, about the world's origin
  double kinetic = 0;                                              ///< of all bodies
};
EnergyLedger ledger(const Experiment& experiment, const std::vector<Motion>& motions);

/// Inertia about the centre of mass, in the body's frame.
inline Matrix3d inertia_of(const Link& link) { return link.axes * link.inertia.asDiagonal() * link.axes.transpose(); }
inline Vector3d centre(const Link& link, const Motion& motion) { return motion.p + motion.R * link.com; }
inline Vector3d centre_velocity(const Link& link, const Motion& motion) { return motion.v + motion.w.cross(motion.R * link.com); }
/// Bodies of the subtree rooted at `body`, starting with it.
std::vector<int> subtree(const std::vector<Link>& links, int body);

}  // namespace peers
