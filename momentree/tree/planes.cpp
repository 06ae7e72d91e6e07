// Finds plane mechanisms, from what the tree stores: numbers meant to be 0 or ±1 are exactly that in links (frames.cpp).
#include <cmath>

#include <momentree/joint/joint_transforms.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

namespace {

bool is_quarter_turn(double c, double s) { return (c == 0 && std::fabs(s) == 1) || (s == 0 && std::fabs(c) == 1); }

bool same_axis(const LinkConstants& a, const LinkConstants& b) {
  return a.cos_a == b.cos_a && a.sin_a == b.sin_a && a.cos_b == b.cos_b && a.sin_b == b.sin_b;
}

// True if a body's mass is symmetrical about the plane through its origin whose axes are those of `tilt`.
bool is_symmetrical(const RigidMass& body, const Mat3& tilt) {
  const Sym3 J = rotate(transpose(tilt), body.J);
  return transpose_times(tilt, body.mc).z == 0 && J.xz == 0 && J.yz == 0;
}

}  // namespace

// True if the mechanism whose root has that place is grounded and plane: plain revolute joints with parallel axes. Its joints
// keep it in the plane, whatever its masses.
bool Tree::in_a_plane(int place) const {
  const int count = static_cast<int>(order_.size());
  for (int i = place; i < count; ++i) {
    const int b = order_[at(i)];
    if (i > place && parent_[at(b)] < 0) return true;
    const Class own = class_[at(b)];
    if (own.kind != Kind::revolute || own.variant != Variant::plain || !(own.parallel || i == place)) return false;
  }
  return true;
}

// A mechanism on a floating root moves in a plane if its other joints are plain revolute ones with parallel axes. A planar joint
// holds it in the plane that is normal to them. On a free joint nothing but symmetry keeps it there: the plane contains the
// root's origin and centre of mass, its normal is an axis of the root's frame, and every body is symmetrical about it.

// What this requires of the root at that place and of the direction of the first axis.
bool Tree::may_float_in_plane(int place) const {
  const int root = order_[at(place)], first = first_child_[at(root)];
  const Class base = class_[at(root)];
  if (base.variant != Variant::plain || first < 0) return false;
  if (base.kind != Kind::free) return base.kind == Kind::planar;
  const LinkConstants& plane = links_[at(first)];
  const LinkConstants& own = links_[at(root)];
  const Mat3 tilt = tilt_rotation(plane);
  return is_quarter_turn(plane.cos_a, plane.sin_a) && is_quarter_turn(plane.cos_b, plane.sin_b) &&
         is_symmetrical(own.body, tilt) && transpose_times(tilt, Vec3{own.geometry[0], own.geometry[1], own.geometry[2]}).z == 0;
}

// What it requires of a body on such a root, or outboard of one.
bool Tree::floats_in_plane(int root, int b) const {
  const Class own = class_[at(b)];
  if (own.kind != Kind::revolute || own.variant != Variant::plain) return false;
  if (class_[at(root)].kind != Kind::free) return own.parallel;
  if (parent_[at(b)] != root) return own.flat;
  const LinkConstants &k = links_[at(b)], &plane = links_[at(first_child_[at(root)])];
  return same_axis(k, plane) && transpose_times(tilt_rotation(plane), k.r).z == 0 && is_symmetrical(k.body, identity3<double>());
}

// The end of the mechanism whose root has that place, if it floats and may move in a plane; 0 otherwise.
int Tree::floating_plane_end(int place) const {
  if (!may_float_in_plane(place)) return 0;
  const int count = static_cast<int>(order_.size()), root = order_[at(place)];
  int i = place + 1;
  for (; i < count && parent_[at(order_[at(i)])] >= 0; ++i)
    if (!floats_in_plane(root, order_[at(i)])) return 0;
  return i;
}

}  // namespace momentree
