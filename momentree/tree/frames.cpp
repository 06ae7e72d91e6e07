// Placement of the kernel frames in the bodies, and the links between them: functions of the topology, not of its history.
#include <algorithm>
#include <cmath>
#include <iterator>

#include <momentree/joint/dispatch.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

namespace {

Mat3 joint_axes(const Joint& joint, double* geometry) {
  return dispatch(joint.kind, [&](auto tag) { return decltype(tag)::type::Kernels::frame(spec_of(joint), geometry); });
}

bool rotates_about_z(Kind kind) { return shape(kind).rotates_about_z; }

Mat3 turned_z(const Mat3& R, double c, double s) {
  return {R.xx * c + R.xy * s, R.xy * c - R.xx * s, R.xz, R.yx * c + R.yy * s, R.yy * c - R.yx * s, R.yz,
          R.zx * c + R.zy * s, R.zy * c - R.zx * s, R.zz};
}

// Removes rounding of 90° and the like: values meant to be 0 or ±1 become exact, far below the round-off of later computations.
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

// R = Rz(β) Rx(α) Rz(θ0), stable for small α: β is found from the tilt, θ0 from the remaining rotation.
void factorise(const Mat3& R, LinkConstants& k) {
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

// A joint as carried by body b: the side fixed in b, the side fixed in b's parent, and the joint's axes C on both. For a reversed
// joint the sides are exchanged; a kind that rotates about z then uses flipped axes (z, and with it the sense of its angle and
// displacement, is reversed), other kinds have reversed kernels.
struct Carried {
  Pose own, outer;
  Mat3 C;
};
Carried carried(const Joint& joint, bool reversed, double* geometry) {
  const Mat3 C = joint_axes(joint, geometry);
  if (!reversed) return {joint.child_at, joint.at, C};
  if (!rotates_about_z(joint.kind)) return {joint.at, joint.child_at, C};
  return {joint.at, joint.child_at, {C.xx, -C.xy, -C.xz, C.yx, -C.yy, -C.yz, C.zx, -C.zy, -C.zz}};
}

// Pose of a welded body's user frame in its parent's user frame.
KernelFrame welded_at(const Joint& joint, bool reversed) {
  const Pose &own = reversed ? joint.at : joint.child_at, &outer = reversed ? joint.child_at : joint.at;
  const Mat3 R = rotation_matrix(outer.rotation) * transpose(rotation_matrix(own.rotation));
  return {R, outer.position - R * own.position};
}
KernelFrame operator*(const KernelFrame& a, const KernelFrame& b) { return {a.R * b.R, a.r + a.R * b.r}; }

// Coordinate, along the own axis z, of the foot of the common normal with the next axis, which passes through r in the direction
// d: with the frame there, the link to the next joint has only two lengths. If the foot is far away, because the axes are nearly
// parallel, the frame stays at the joint.
double foot(const Vec3& d, const Vec3& r) {
  const double across = d.x * d.x + d.y * d.y;
  const double z = across < 1e-18 ? r.z : r.z - d.z * (r.x * d.x + r.y * d.y) / across;
  return z * z <= 9 * dot(r, r) ? z : 0;
}

// Finds what follows from the rotation, zeroes lengths that are zero up to rounding, and finds the shape of the link.
void find_shape(LinkConstants& k, bool rotates, double scale) {
  const double smallest = 8e-16 * scale;
  const auto zero = [smallest](double x) { return std::fabs(x) <= smallest; };
  find_rotation(k);
  k.d = 0;
  k.shape = PlacementShape::general;
  if (k.sin_b != 0 || k.cos_b != 1) return;
  k.shape = PlacementShape::tilted;
  if (!rotates) return;
  // The child's axis is (0, −sin α, cos α).
  const double d = k.cos_a * k.r.z - k.sin_a * k.r.y;
  if (!zero(k.r.y + d * k.sin_a) || !zero(k.r.z - d * k.cos_a)) return;
  if (zero(k.r.x)) k.r.x = 0;
  k.d = zero(d) ? 0 : d;
  k.r.y = -k.d * k.sin_a, k.r.z = k.d * k.cos_a;
  const bool has_a = k.r.x != 0, has_d = k.d != 0;
  // Test both, because the cosine of 1e-8 is 1.
  if (k.sin_a == 1 && k.cos_a == 0)
    k.shape = has_a   ? (has_d ? PlacementShape::right : PlacementShape::right_a)
              : has_d ? PlacementShape::right_d
                      : PlacementShape::right_meeting;
  else if (k.cos_a == 1 && k.sin_a == 0 && has_a)
    k.shape = has_d ? PlacementShape::parallel : PlacementShape::parallel_a;
  else
    k.shape = !has_a ? PlacementShape::screw_d : has_d ? PlacementShape::screw : PlacementShape::screw_a;
}

}  // namespace

void Tree::make_frame(int b) {
  LinkConstants& link = tables_.links.own(at(b));
  if (is_welded(b)) {
    // The frame of the body that carries it, so that the weld needs no transform.
    const KernelFrame outer = tables_.parent[at(b)] < 0 ? KernelFrame{} : frame(tables_.parent[at(b)]),
                      place = welded_at(joint(b), reversed(b));
    tables_.links.own_frame(at(b)) = {transpose(place.R) * outer.R, transpose_times(place.R, outer.r - place.r)};
    const LinkConstants none;
    const unsigned char locked = link.locked, driven = link.driven;
    link = none;
    link.locked = locked, link.driven = driven;
    set_mass_properties(b, link);
    classify(b);
    return;
  }
  std::fill(std::begin(link.geometry), std::end(link.geometry), 0.0);
  Carried mine = carried(joint(b), reversed(b), link.geometry);
  const Mat3 side = rotation_matrix(mine.own.rotation);
  double shift_z = 0;
  if (rotates_about_z(joint(b).kind)) {
    // x is free: choose it so that the first child's link needs no rotation about z (β = 0) or, if the axes are parallel, so that
    // it points to the child's axis. A welded child has no axis: use the first joint on it instead.
    int c = first_child_[at(b)];
    KernelFrame carrier;
    for (; c >= 0 && is_welded(c); c = first_child_[at(c)]) carrier = carrier * welded_at(joint(c), reversed(c));
    if (c >= 0) {
      double geometry[2];
      Carried next = carried(joint(c), reversed(c), geometry);
      const Mat3 own = side * mine.C;
      Mat3 axes = rotation_matrix(next.outer.rotation) * next.C;
      if (tables_.parent[at(c)] != b) axes = carrier.R * axes, next.outer.position = carrier.r + carrier.R * next.outer.position;
      const Vec3 d = transpose_times(own, Vec3{axes.xz, axes.yz, axes.zz});
      const Vec3 r = transpose_times(own, next.outer.position - mine.own.position);
      double cosine = -d.y, sine = d.x;
      if (cosine * cosine + sine * sine < 1e-18) cosine = r.x, sine = r.y;
      if (cosine * cosine + sine * sine > 1e-18) {
        unit_pair(cosine, sine);
        mine.C = turned_z(mine.C, cosine, sine);
      }
      if (rotates_about_z(joint(c).kind)) shift_z = foot(d, r);
    }
  }
  const Mat3 R = side * mine.C;
  if (momentree::at_centre_of_mass(*this, b)) {
    const Vec3 origin = mass(b).com, c = transpose_times(R, origin - mine.own.position);
    tables_.links.own_frame(at(b)) = {R, origin};
    link.geometry[0] = c.x, link.geometry[1] = c.y, link.geometry[2] = c.z;
  } else {
    tables_.links.own_frame(at(b)) = {R, mine.own.position + shift_z * Vec3{R.xz, R.yz, R.zz}};
  }
  set_mass_properties(b, link);
}

// Sets the mass properties of b in its kernel frame.
void Tree::set_mass_properties(int b, LinkConstants& link) const {
  const KernelFrame& own = frame(b);
  const MassProperties& m = mass(b);
  const Vec3 r = transpose_times(own.R, m.com - own.r);
  const double rr = dot(r, r);
  link.body.m = m.mass;
  link.body.mc = m.mass * r;
  link.body.J =
      rotate(transpose(own.R), m.inertia) + Sym3{m.mass * (rr - r.x * r.x), m.mass * (rr - r.y * r.y), m.mass * (rr - r.z * r.z),
                                                 -m.mass * r.x * r.y,       -m.mass * r.x * r.z,       -m.mass * r.y * r.z};
}

void Tree::make_link(int b) {
  if (is_welded(b)) return;  // the frames coincide
  double geometry[2];
  const Carried mine = carried(joint(b), reversed(b), geometry);
  const KernelFrame own = frame(b);
  const KernelFrame outer = tables_.parent[at(b)] < 0 ? KernelFrame{} : frame(tables_.parent[at(b)]);
  LinkConstants& k = tables_.links.own(at(b));
  // C, the joint's axes: the rotation of the kernel frame relative to the joint's side, including the choice of x.
  const Mat3 C = transpose(rotation_matrix(mine.own.rotation)) * own.R;
  const Mat3 axes = rotation_matrix(mine.outer.rotation) * C;
  factorise(transpose(outer.R) * axes, k);
  // The frame of a joint that rotates about z is shifted by `shift_z` along the axis.
  const Vec3 off = own.r - mine.own.position, at_joint = mine.outer.position;
  const double shift_z = rotates_about_z(joint(b).kind) ? dot(off, Vec3{own.R.xz, own.R.yz, own.R.zz}) : 0;
  k.r = transpose_times(outer.R, at_joint + shift_z * Vec3{axes.xz, axes.yz, axes.zz} - outer.r);
  find_shape(k, rotates_about_z(joint(b).kind), norm(at_joint) + norm(outer.r) + std::fabs(shift_z));
  classify(b);
  if (rotates_about_z(joint(b).kind))
    for (int i = 0; i < shape(joint(b).kind).angles; ++i) tables_.angle_offset[at(tables_.offsets[at(b)].angle + i)] = k.angle_0;
}

// The properties of the link that separate kernel runs and set node flags.
void Tree::classify(int b) {
  const LinkConstants& k = tables_.links[at(b)];
  tables_.classes[at(b)].parallel = k.cos_a == 1 && k.sin_a == 0;
  tables_.classes[at(b)].aligned = aligned(k);
}

bool Tree::joint_as_declared(int b) const { return joint_of_[at(b)] == b && reversed_[at(b)] == 0 && joint_at_[at(b)] >= 0; }
// True if everything that determines the frame of b is as declared; the answer for the parent is already stored.
bool Tree::frame_as_declared(int b) const {
  if (at(b) >= declared_bodies() || !joint_as_declared(b)) return false;
  if (joint(b).kind == Kind::weld) {
    const int outer = tables_.parent[at(b)];
    return outer == declared_->bodies[at(b)].parent && (outer < 0 || tables_.classes[at(outer)].as_declared);
  }
  for (int x = b;;) {  // all joints on which the frame can depend
    const int c = first_child_[at(x)];
    if (c != declared_->bodies[at(x)].first_child || (c >= 0 && !joint_as_declared(c))) return false;
    if (c < 0 || joint(c).kind != Kind::weld) return true;
    x = c;
  }
}

// Calls f for b and all bodies welded to it, each after the body that it is welded to.
template <class F>
void Tree::for_rigid(int b, const F& f) const {
  f(b);
  for (int x = b, c = first_child_[at(b)];;) {
    while (c >= 0 && !is_welded(c)) c = next_sibling_[at(c)];
    if (c >= 0) {
      f(c);
      x = c;
      c = first_child_[at(c)];
    } else if (x == b) {
      return;
    } else {
      c = next_sibling_[at(x)];
      x = tables_.parent[at(x)];
    }
  }
}

// Renews the frames of b and all bodies welded to it.
void Tree::make_frames(int b) {
  for_rigid(b, [this](int x) { make_frame(x); });
}
// Renews the links of all joints on b and on bodies welded to it, except one.
void Tree::make_outboard_links(int b, int but) {
  for_rigid(b, [this, but](int x) {
    for (int c = first_child_[at(x)]; c >= 0; c = next_sibling_[at(c)])
      if (c != but) make_link(c);
  });
}

// The body that carries b: b itself, or the innermost body to which it is welded.
int Tree::carrier_of(int b) const {
  while (is_welded(b) && tables_.parent[at(b)] >= 0) b = tables_.parent[at(b)];
  return b;
}

// Updates frames and links after a change of b's joint: b's frame may change, that of its parent, whose x depends on the joint of
// its first child, and every link that uses either.
void Tree::update_frames(int b) {
  const int outer = tables_.parent[at(b)];
  if (is_welded(b) && outer >= 0) {
    const int carrier = carrier_of(b);
    make_frames(carrier);
    make_link(carrier);
    return make_outboard_links(carrier);
  }
  make_frames(b);
  if (outer < 0 || first_child_[at(outer)] != b || !renew_child_changed(outer)) make_link(b);
  make_outboard_links(b);
}

// Updates after another child became b's first, or that child's joint changed. Returns false if no frame depends on it.
bool Tree::renew_child_changed(int b) {
  const int carrier = carrier_of(b);
  if (is_welded(carrier) || !rotates_about_z(kind(carrier))) return false;
  make_frames(carrier);
  make_link(carrier);
  make_outboard_links(carrier);
  return true;
}

// Replaces a link that was just made by one in the model's shared list.
void Tree::collect(int b, detail::LinkCollector& collector) {
  tables_.links.give_back(at(b), at(collector.take(b, first_child_[at(b)], tables_.links[at(b)], frame(b))));
}

}  // namespace momentree
