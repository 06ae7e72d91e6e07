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

// The end in the order of the mechanism whose root has that place, if it can move in a plane without being grounded in it: plain
// revolute joints with parallel axes on a root with a planar joint, whose normal they have, or with a free joint. In the latter
// case nothing but symmetry keeps it in the plane: the plane contains the root's origin, its normal is an axis of the root's
// frame, and every body is symmetrical about it. 0 otherwise.
int Tree::floating_plane_end(int place) const {
  const int count = static_cast<int>(order_.size()), root = order_[at(place)];
  const Class base = class_[at(root)];
  const bool free = base.kind == Kind::free;
  if (!(free || base.kind == Kind::planar) || base.variant != Variant::plain || first_child_[at(root)] < 0) return 0;
  const LinkConstants& plane = links_[at(order_[at(place + 1)])];
  int i = place + 1;
  for (; i < count; ++i) {
    const int b = order_[at(i)];
    if (parent_[at(b)] < 0) break;
    const Class own = class_[at(b)];
    if (own.kind != Kind::revolute || own.variant != Variant::plain) return 0;
    if (!(!free ? own.parallel : parent_[at(b)] == root ? is_flat_on(b, plane) : own.flat)) return 0;
  }
  if (free && !(is_quarter_turn(plane.cos_a, plane.sin_a) && is_quarter_turn(plane.cos_b, plane.sin_b) &&
                is_symmetrical(links_[at(root)].body, tilt_rotation(plane))))
    return 0;
  return i;
}

// The same as Class::flat for a body on a free root, in the plane through the root's origin.
bool Tree::is_flat_on(int b, const LinkConstants& plane) const {
  const LinkConstants& k = links_[at(b)];
  return same_axis(k, plane) && transpose_times(tilt_rotation(plane), k.r).z == 0 && is_symmetrical(k.body, identity3<double>());
}

}  // namespace momentree
