#pragma once
// Links of the models: random ones, and figures whose joints are along the axes of the world when all angles are zero.
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "draw.hpp"
#include "experiment.hpp"

namespace peers {

/// A random link on a revolute joint.
inline Link pin(Draw& draw, int number, int parent, bool planar) {
  Link link;
  link.name = "b" + std::to_string(number);
  link.parent = parent;
  link.mass = draw.between(0.5, 1.5);
  link.at = parent < 0 ? Vector3d::Zero() : Vector3d(0.2, 0, 0);
  if (planar) {
    link.com = {0.1, 0, 0};
    if (parent < 0) link.turn = Eigen::AngleAxisd(1.5707963267948966, Vector3d::UnitX()).toRotationMatrix();  // upright
  } else {
    const Vector3d by = draw.within(1.2);
    link.turn = Eigen::AngleAxisd(by.norm(), by.normalized()).toRotationMatrix();
    link.com = Vector3d(0.1, 0, 0) + draw.within(0.03);
  }
  link.inertia = link.mass * 0.04 * Vector3d(0.2, 0.7, 0.8);
  link.angle = draw.between(-0.6, 0.6);
  link.rate = draw.between(-1, 1);
  return link;
}

/// A tree of revolute joints whose axes are x, y or z of the world at zero angles.
class Figure {
 public:
  explicit Figure(unsigned seed) : draw_(seed) {}
  struct Offset {
    double x = 0, y = 0, z = 0;
  };
  int limb(int last, const char* axes, std::initializer_list<Offset> offsets) {
    for (const Offset& offset : offsets) last = add(last, *axes++, {offset.x, offset.y, offset.z});
    return last;
  }
  /// Axis and offset from the parent's origin, in world axes at zero angles. `floats`: a free root.
  int add(int parent, char axis, const Vector3d& offset, bool floats = false) {
    const int number = static_cast<int>(links.size());
    Link link = pin(draw_, number, parent, false);
    const double right = 1.5707963267948966;
    Matrix3d stands = Matrix3d::Identity();
    if (axis == 'x') stands = Eigen::AngleAxisd(right, Vector3d::UnitY()).toRotationMatrix();
    if (axis == 'y') stands = Eigen::AngleAxisd(-right, Vector3d::UnitX()).toRotationMatrix();
    const Matrix3d parent_stands = parent < 0 ? Matrix3d::Identity() : stands_[parent];
    link.turn = parent_stands.transpose() * stands;
    for (double& x : link.turn.reshaped()) x = std::round(x);  // quarter turns
    link.at = parent_stands.transpose() * offset;
    if (parent < 0 && floats) {
      link.free = true;
      link.turn = Eigen::AngleAxisd(0.7, Vector3d(0.6, 0, 0.8)).toRotationMatrix();
      link.at = {0.1, 0.2, 1};
      link.linear = {0.1, -0.2, 0.3}, link.angular = {0.4, -0.5, 0.6};
    }
    links.push_back(link);
    stands_.push_back(stands);
    return number;
  }
  std::vector<Link> links;

 private:
  Draw draw_;
  std::vector<Matrix3d> stands_;
};

}  // namespace peers
