#pragma once
// A joint that follows another one through a spring and a damper: [[coupling]] with a stiffness, and `mimic` of model files.
#include <span>

#include <momentree/base/describe.hpp>
#include <momentree/model/ids.hpp>

namespace momentree::elements {

/// With e = q(joint) − multiplier·q(follows) − offset, the effort on the joint is −(stiffness·e + damping·ė), and that on the
/// joint that it follows −multiplier times this.
struct SpringCoupling {
  JointId joint, follows;
  double multiplier = 1;  ///< units of the joint per unit of the other one
  double offset = 0;      ///< rad or m
  double stiffness = 0;   ///< N m/rad or N/m, of the joint
  double damping = 0;     ///< N m s/rad or N s/m
  friend bool operator==(const SpringCoupling&, const SpringCoupling&) = default;

  void efforts(std::span<const double> q, std::span<const double> v, std::span<double> efforts) const noexcept {
    const double apart = q[0] - multiplier * q[1] - offset, rate = v[0] - multiplier * v[1];
    const double effort = -(stiffness * apart + damping * rate);
    efforts[0] = effort, efforts[1] = -multiplier * effort;
  }
};

template <class Visitor, Like<SpringCoupling> S>
void describe(Visitor& visit, S& spring) {
  using namespace dimension;
  visit("joint", spring.joint, Field{"The joint that follows"}.needed(""));
  visit("follows", spring.follows, Field{"The joint that leads"}.needed(""));
  visit("multiplier", spring.multiplier, Field{"The joint is at multiplier·q + offset, where q is its leader's coordinate"});
  visit("offset", spring.offset, Field{"Offset", angle}.or_along(length));
  visit("stiffness", spring.stiffness, Field{"Stiffness", torque / angle, Range::positive}.or_along(force / length));
  visit("damping", spring.damping, Field{"Damping", torque * time / angle, Range::not_negative}.or_along(force / speed));
}

}  // namespace momentree::elements
