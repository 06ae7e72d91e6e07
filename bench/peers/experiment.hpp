#pragma once
// The experiments that every engine is put to, and what is exact in each: found in maximal coordinates, by no engine at all.
// Nothing here allocates through Eigen: engines' packages and ours may be compiled for different CPUs.
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace peers {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A body and its inboard joint: free (a root), or a pin about z (evaluations have slides along z, too) of a frame that stands at
/// (turn, at) in the parent's frame; at angle zero the body's frame is that frame. SI units.
struct Link {
  std::string name;
  int parent = -1;
  bool free = false, slides = false;
  Matrix3d turn = Matrix3d::Identity();
  Vector3d at = Vector3d::Zero();
  double mass = 1;
  Vector3d com = Vector3d::Zero();
  Vector3d inertia = Vector3d::Ones();   ///< principal, about the centre of mass
  Matrix3d axes = Matrix3d::Identity();  ///< the principal axes, in the body's frame: other ones in evaluations alone
  double angle = 0, rate = 0;            ///< of a pin, at the start
  Vector3d linear = Vector3d::Zero();    ///< of a free body at the start, world axes, of its origin
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
  int body;                 ///< whose inboard joint is cut or locked; the root that is captured
  int to = -1;              ///< capture: what it is welded to, where they are
  std::vector<int> judged;  ///< bodies whose momentum is compared: the part cut off, or all
};

std::vector<Experiment> experiments();

/// Bodies' motion at the start, by forward kinematics.
std::vector<Motion> start(const Experiment& experiment);

/// Their motion at once after the change: the start's velocities projected, weighted by mass, onto those that the joints allow
/// then. What an instantaneous change by the forces of ideal joints must give.
std::vector<Motion> exact(const Experiment& experiment);

struct EnergyLedger {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();  ///< of the judged bodies, about the world's origin
  double kinetic = 0;                                              ///< of all bodies
};
EnergyLedger ledger(const Experiment& experiment, const std::vector<Motion>& motions);

/// Inertia about the centre of mass, in the body's frame.
inline Matrix3d inertia_of(const Link& link) { return link.axes * link.inertia.asDiagonal() * link.axes.transpose(); }
inline Vector3d centre(const Link& link, const Motion& motion) { return motion.p + motion.R * link.com; }
inline Vector3d centre_velocity(const Link& link, const Motion& motion) { return motion.v + motion.w.cross(motion.R * link.com); }
/// Bodies of the subtree that hangs on `body`, itself the first.
std::vector<int> subtree(const std::vector<Link>& links, int body);

}  // namespace peers
