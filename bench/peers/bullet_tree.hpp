#pragma once
// Bullet's worlds and trees in reduced coordinates, made from links.
#include <algorithm>
#include <memory>

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include "experiment.hpp"

namespace peers {

inline btVector3 vec(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }
inline Vector3d vec(const btVector3& a) { return {a.x(), a.y(), a.z()}; }
inline btMatrix3x3 mat(const Matrix3d& R) {
  return {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)};
}
inline Matrix3d mat(const btMatrix3x3& R) { return (Matrix3d() << vec(R[0]), vec(R[1]), vec(R[2])).finished().transpose(); }
inline btQuaternion turn(const Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return {q.x(), q.y(), q.z(), q.w()};
}
/// Bullet's frames are at the centres of mass.
inline Motion from_centre(const Link& link, const Matrix3d& R, const Vector3d& c, const Vector3d& v, const Vector3d& w) {
  const Vector3d arm = R * link.com;
  return {R, c - arm, v - w.cross(arm), w};
}

struct World {
  World() : bullet(&dispatcher, &pairs, &solver, &configuration) { bullet.setGravity(btVector3(0, 0, 0)); }
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase pairs;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld bullet;
};

/// A tree of links on one root, in reduced coordinates.
struct Tree {
  Tree(const std::vector<Link>& links, std::vector<int> bodies) : numbers(std::move(bodies)) {
    const Link& root = links[numbers[0]];
    first = root.free ? 1 : 0;  // a grounded root is link 0 of a fixed base
    const int moving = static_cast<int>(numbers.size()) - first;
    mb = std::make_unique<btMultiBody>(moving, root.free ? root.mass : 0, root.free ? vec(root.inertia) : btVector3(0, 0, 0),
                                       !root.free, false);
    for (int i = 0; i < moving; ++i) {
      const Link& link = links[numbers[i + first]];
      const int parent = link_of(link.parent);
      const bool grounded = link.parent < 0;
      // Its frames are aligned with the principal axes.
      const Matrix3d own = link.axes.transpose(), outer = grounded ? Matrix3d::Identity() : links[link.parent].axes;
      const Vector3d arm = outer.transpose() * (link.at - (grounded ? Vector3d::Zero() : links[link.parent].com));
      const Matrix3d to_own = own * link.turn.transpose() * outer;
      const Vector3d axis = own.col(2), com = own * link.com;
      if (link.slides) {
        mb->setupPrismatic(i, link.mass, vec(link.inertia), parent, turn(to_own), vec(axis), vec(arm), vec(com), true);
      } else {
        mb->setupRevolute(i, link.mass, vec(link.inertia), parent, turn(to_own), vec(axis), vec(arm), vec(com), true);
      }
    }
    mb->finalizeMultiDof();
    mb->setLinearDamping(0);
    mb->setAngularDamping(0);
  }
  /// Number of a body in Bullet; −1: the base.
  int link_of(int body) const {
    const auto at = std::find(numbers.begin(), numbers.end(), body);
    return at == numbers.end() ? -1 : static_cast<int>(at - numbers.begin()) - first;
  }
  void set_base(const Motion& motion, const Link& link) {
    mb->setBaseWorldTransform(btTransform(turn(motion.R * link.axes), vec(centre(link, motion))));
    mb->setBaseVel(vec(centre_velocity(link, motion)));
    mb->setBaseOmega(vec(motion.w));
  }
  /// Updates link transforms and all cached data after positions were set.
  void refresh() {
    btAlignedObjectArray<btQuaternion> turns;
    btAlignedObjectArray<btVector3> places;
    mb->forwardKinematics(turns, places);
  }
  void read(const std::vector<Link>& links, std::vector<Motion>& all) const {
    std::vector<btVector3> w(numbers.size() + 1), v(numbers.size() + 1);
    mb->compTreeLinkVelocities(w.data(), v.data());  // of base and links, in their axes
    for (const int body : numbers) {
      const int i = link_of(body);
      const btTransform pose = i < 0 ? mb->getBaseWorldTransform() : mb->getLink(i).m_cachedWorldTransform;
      const Matrix3d P = mat(pose.getBasis());
      all[body] =
          from_centre(links[body], P * links[body].axes.transpose(), vec(pose.getOrigin()), P * vec(v[i + 1]), P * vec(w[i + 1]));
    }
  }
  std::vector<int> numbers;
  int first;
  std::unique_ptr<btMultiBody> mb;
};

}  // namespace peers
