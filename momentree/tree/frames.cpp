// Where the kernels' frames stand in the bodies, and the links between them: functions of the topology, not of its history.
#include <cmath>

#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

namespace {

Mat3 joint_axes(const Joint& joint, double* geometry) {
  return dispatch(joint.kind, [&](auto tag) { return decltype(tag)::type::Kernels::frame(spec_of(joint), geometry); });
}

bool turns_about_z(Kind kind) { return shape(kind).turns_about_z; }

Mat3 turned_z(const Mat3& R, double c, double s) {
  return {R.xx * c + R.xy * s, R.xy * c - R.xx * s, R.xz, R.yx * c + R.yy * s, R.yy * c - R.yx * s, R.yz,
          R.zx * c + R.zy * s, R.zy * c - R.zx * s, R.zz};
}

// Rounding of 90° and the like: what is meant to be 0 or ±1 is made so, far below the round-off of what follows.
double snapped(double x) {
  if (std::fabs(x) < 1e-15) return 0;
  if (std::fabs(std::fabs(x) - 1) < 1e-15) return x < 0 ? -1 : 1;
  return x;
}

void unit_pair(double& c, double& s) {
  const double n = std::sqrt(c * c + s * s);
  c = snapped(c / n);
  s = snapped(s / n);
}

// R = Rz(β) Rx(α) Rz(θ0), stable where α is small: β is found from the tilt, θ0 from what then remains.
void factorise(const Mat3& R, Link& k) {
  const double x = std::fabs(R.xz) < 1e-15 ? 0 : R.xz;
  const double tilt = std::sqrt(x * x + R.yz * R.yz);
  if (x == 0 || tilt < 1e-15) {
    k.cos_b = 1, k.sin_b = 0;
    k.sin_a = -R.yz;
  } else {
    k.cos_b = -R.yz / tilt, k.sin_b = x / tilt;
    unit_pair(k.cos_b, k.sin_b);
    k.sin_a = tilt;
  }
  k.cos_a = R.zz;
  unit_pair(k.cos_a, k.sin_a);
  const Mat3 Rb{k.cos_b, k.sin_b, 0, -k.sin_b, k.cos_b, 0, 0, 0, 1};
  const Mat3 Ra{1, 0, 0, 0, k.cos_a, k.sin_a, 0, -k.sin_a, k.cos_a};
  const Mat3 rest = Ra * (Rb * R);
  k.cos_0 = rest.xx + rest.yy, k.sin_0 = rest.yx - rest.xy;
  unit_pair(k.cos_0, k.sin_0);
  k.angle_0 = std::atan2(k.sin_0, k.cos_0);
}

// A joint as body b carries it: the side that is fixed in b, the side fixed in its parent, and the joint's axes C on both.
// Against its declared direction the sides change places; a kind that turns about z is then native in axes turned over (z, and
// with it the sense of its angle and displacement, reversed), others have kernels for it.
struct Carried {
  Pose own, outer;
  Mat3 C;
};
Carried carried(const Joint& joint, bool reversed, double* geometry) {
  const Mat3 C = joint_axes(joint, geometry);
  if (!reversed) return {joint.child_at, joint.at, C};
  if (!turns_about_z(joint.kind)) return {joint.at, joint.child_at, C};
  return {joint.at, joint.child_at, {C.xx, -C.xy, -C.xz, C.yx, -C.yy, -C.yz, C.zx, -C.zy, -C.zz}};
}

}  // namespace

void Tree::make_frame(int b) {
  Link& link = links_[at(b)];
  Carried mine = carried(joint(b), reversed(b), link.geometry);
  const Mat3 side = rotation_matrix(mine.own.rotation);
  const int c = first_child_[at(b)];
  if (turns_about_z(joint(b).kind) && c >= 0) {
    // x is free: choose it so that the first child's axis needs no turn about z (β = 0), or, if it is parallel, lies along x.
    double geometry[2];
    const Carried next = carried(joint(c), reversed(c), geometry);
    const Mat3 own = side * mine.C;
    const Mat3 axes = rotation_matrix(next.outer.rotation) * next.C;
    const Vec3 d = transpose_times(own, Vec3{axes.xz, axes.yz, axes.zz});
    const Vec3 r = transpose_times(own, next.outer.position - mine.own.position);
    double cosine = -d.y, sine = d.x;
    if (cosine * cosine + sine * sine < 1e-18) cosine = r.x, sine = r.y;
    if (cosine * cosine + sine * sine > 1e-18) {
      unit_pair(cosine, sine);
      mine.C = turned_z(mine.C, cosine, sine);
    }
  }
  const KernelFrame& own = frames_[at(b)] = {side * mine.C, mine.own.position};
  const MassProperties& m = masses_[at(b)];
  const Vec3 r = transpose_times(own.R, m.com - own.r);
  const double rr = dot(r, r);
  link.body.m = m.mass;
  link.body.mc = m.mass * r;
  link.body.J =
      rotate(transpose(own.R), m.inertia) + Sym3{m.mass * (rr - r.x * r.x), m.mass * (rr - r.y * r.y), m.mass * (rr - r.z * r.z),
                                                 -m.mass * r.x * r.y,       -m.mass * r.x * r.z,       -m.mass * r.y * r.z};
}

void Tree::make_link(int b) {
  double geometry[2];
  const Carried mine = carried(joint(b), reversed(b), geometry);
  const KernelFrame own = frames_[at(b)];
  const KernelFrame outer = parent_[at(b)] < 0 ? KernelFrame{} : frames_[at(parent_[at(b)])];
  Link& k = links_[at(b)];
  // The joint's axes C are what the kernel frame has beyond the joint's side: with the choice of x.
  const Mat3 C = transpose(rotation_matrix(mine.own.rotation)) * own.R;
  factorise(transpose(outer.R) * (rotation_matrix(mine.outer.rotation) * C), k);
  k.r = transpose_times(outer.R, mine.outer.position - outer.r);
  class_[at(b)].aligned = k.sin_b == 0 && k.cos_b == 1;
  if (turns_about_z(joint(b).kind))
    for (int i = 0; i < shape(joint(b).kind).angles; ++i) angle_offset_[at(first_angle_[at(b)] + i)] = k.angle_0;
}

// The joint of b changed: so may its frame, and that of its parent, whose x looks to the joint of its first child; and every link
// that touches them.
void Tree::renew(int b) {
  make_frame(b);
  const int outer = parent_[at(b)];
  if (outer >= 0 && first_child_[at(outer)] == b && turns_about_z(joint(outer).kind)) {
    renew_child_changed(outer);
  } else {
    make_link(b);
  }
  for (int c = first_child_[at(b)]; c >= 0; c = next_sibling_[at(c)]) make_link(c);
}

// Another child of b is the first.
void Tree::renew_child_changed(int b) {
  if (!turns_about_z(joint(b).kind)) return;
  make_frame(b);
  make_link(b);
  for (int c = first_child_[at(b)]; c >= 0; c = next_sibling_[at(c)]) make_link(c);
}

}  // namespace momentree
