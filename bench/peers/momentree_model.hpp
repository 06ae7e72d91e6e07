#pragma once
// A model of momentree made from links.
#include <momentree/joint/kinds.hpp>
#include <momentree/model/model.hpp>

#include "experiment.hpp"

namespace peers {

namespace mt = momentree;

inline mt::Vec3 vec(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }
inline Vector3d vec(const mt::Vec3& a) { return {a.x, a.y, a.z}; }
inline mt::Mat3 mat(const Matrix3d& R) {
  return {R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)};
}
inline mt::Sym3 sym(const Matrix3d& I) { return {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)}; }
inline Matrix3d mat(const mt::Mat3& R) { return (Matrix3d() << R.xx, R.xy, R.xz, R.yx, R.yy, R.yz, R.zx, R.zy, R.zz).finished(); }

inline mt::Model model_of(const std::vector<Link>& links, double along_z = 0) {
  mt::Model model({.gravity = {0, 0, along_z}});
  for (const Link& link : links) {
    mt::BodySpec spec{.name = link.name,
                      .mass = link.mass,
                      .com = vec(link.com),
                      .inertia = sym(inertia_of(link)),
                      .parent = mt::BodyId{link.parent},
                      .at = mt::Pose{vec(link.at), mt::quaternion_of(mat(link.turn))}};
    if (link.free) {
      const Vector3d v = link.turn.transpose() * link.linear, w = link.turn.transpose() * link.angular;
      spec.joint = mt::Free{};
      spec.v = {v.x(), v.y(), v.z(), w.x(), w.y(), w.z()};
    } else {
      if (link.slides) spec.joint = mt::Prismatic{.axis = mt::z_axis};
      if (!link.slides) spec.joint = mt::Revolute{.axis = mt::z_axis};
      spec.q = link.angle;
      spec.v = link.rate;
    }
    model.add(spec);
  }
  return model;
}

}  // namespace peers
