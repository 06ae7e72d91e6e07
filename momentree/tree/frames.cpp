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

// Where the user's frame of a body stands in that of its parent, to which it is welded.
KernelFrame welded_at(const Joint& joint, bool reversed) {
  const Pose &own = reversed ? joint.at : joint.child_at, &outer = reversed ? joint.child_at : joint.at;
  const Mat3 R = rotation_matrix(outer.rotation) * transpose(rotation_matrix(own.rotation));
  return {R, outer.position - R * own.position};
}
KernelFrame operator*(const KernelFrame& a, const KernelFrame& b) { return {a.R * b.R, a.r + a.R * b.r}; }

// Where on the own axis, z, the common normal with the next one stands, which goes along d through r: there the link between them
// has but two lengths. Where that is far off, for axes that are nearly parallel, the frame stays where the joint is.
double foot(const Vec3& d, const Vec3& r) {
  const double across = d.x * d.x + d.y * d.y;
  const double z = across < 1e-18 ? r.z : r.z - d.z * (r.x * d.x + r.y * d.y) / across;
  return z * z <= 9 * dot(r, r) ? z : 0;
}

// Lengths that are zero but for rounding, and what the link lacks of a general one.
void find_shape(LinkConstants& k, bool turns, double scale) {
  const double smallest = 8e-16 * scale;
  const auto zero = [smallest](double x) { return std::fabs(x) <= smallest; };
  k.cs_a = k.cos_a * k.sin_a, k.ss_a = k.sin_a * k.sin_a;
  k.d = 0;
  k.shape = PlacementShape::general;
  if (k.sin_b != 0 || k.cos_b != 1) return;
  k.shape = PlacementShape::tilted;
  if (!turns) return;
  // The child's axis is (0, −sin α, cos α).
  const double d = k.cos_a * k.r.z - k.sin_a * k.r.y;
  if (!zero(k.r.y + d * k.sin_a) || !zero(k.r.z - d * k.cos_a)) return;
  if (zero(k.r.x)) k.r.x = 0;
  k.d = zero(d) ? 0 : d;
  k.r.y = -k.d * k.sin_a, k.r.z = k.d * k.cos_a;
  const bool has_a = k.r.x != 0, has_d = k.d != 0;
  // Both, for the cosine of 1e-8 is 1.
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
  LinkConstants& link = links_.own(at(b));
  if (is_welded(b)) {
    // That of the body that it is welded to, so that nothing has to cross the weld.
    const KernelFrame outer = parent_[at(b)] < 0 ? KernelFrame{} : frame(parent_[at(b)]),
                      place = welded_at(joint(b), reversed(b));
    links_.own_frame(at(b)) = {transpose(place.R) * outer.R, transpose_times(place.R, outer.r - place.r)};
    const LinkConstants none;
    const unsigned char locked = link.locked, driven = link.driven;
    link = none;
    link.locked = locked, link.driven = driven;
    set_mass_properties(b, link);
    classify(b);
    return;
  }
  Carried mine = carried(joint(b), reversed(b), link.geometry);
  const Mat3 side = rotation_matrix(mine.own.rotation);
  double slide = 0;
  if (turns_about_z(joint(b).kind)) {
    // x is free: choose it so that the first child's axis needs no turn about z (β = 0), or, if it is parallel, lies along x.
    // A child that is welded has no axis: the first that hangs on it is looked at.
    int c = first_child_[at(b)];
    KernelFrame carrier;
    for (; c >= 0 && is_welded(c); c = first_child_[at(c)]) carrier = carrier * welded_at(joint(c), reversed(c));
    if (c >= 0) {
      double geometry[2];
      Carried next = carried(joint(c), reversed(c), geometry);
      const Mat3 own = side * mine.C;
      Mat3 axes = rotation_matrix(next.outer.rotation) * next.C;
      if (parent_[at(c)] != b) axes = carrier.R * axes, next.outer.position = carrier.r + carrier.R * next.outer.position;
      const Vec3 d = transpose_times(own, Vec3{axes.xz, axes.yz, axes.zz});
      const Vec3 r = transpose_times(own, next.outer.position - mine.own.position);
      double cosine = -d.y, sine = d.x;
      if (cosine * cosine + sine * sine < 1e-18) cosine = r.x, sine = r.y;
      if (cosine * cosine + sine * sine > 1e-18) {
        unit_pair(cosine, sine);
        mine.C = turned_z(mine.C, cosine, sine);
      }
      if (turns_about_z(joint(c).kind)) slide = foot(d, r);
    }
  }
  const Mat3 R = side * mine.C;
  links_.own_frame(at(b)) = {R, mine.own.position + slide * Vec3{R.xz, R.yz, R.zz}};
  set_mass_properties(b, link);
}

// The mass properties of b, in its kernel frame.
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
  if (is_welded(b)) return;  // there is nothing between the frames
  double geometry[2];
  const Carried mine = carried(joint(b), reversed(b), geometry);
  const KernelFrame own = frame(b);
  const KernelFrame outer = parent_[at(b)] < 0 ? KernelFrame{} : frame(parent_[at(b)]);
  LinkConstants& k = links_.own(at(b));
  // The joint's axes C are what the kernel frame has beyond the joint's side: with the choice of x.
  const Mat3 C = transpose(rotation_matrix(mine.own.rotation)) * own.R;
  const Mat3 axes = rotation_matrix(mine.outer.rotation) * C;
  factorise(transpose(outer.R) * axes, k);
  // The frame stands `slide` along the joint's axis from its place.
  const Vec3 off = own.r - mine.own.position, at_joint = mine.outer.position;
  const double slide = dot(off, Vec3{own.R.xz, own.R.yz, own.R.zz});
  k.r = transpose_times(outer.R, at_joint + slide * Vec3{axes.xz, axes.yz, axes.zz} - outer.r);
  find_shape(k, turns_about_z(joint(b).kind), norm(at_joint) + norm(outer.r) + std::fabs(slide));
  classify(b);
  if (turns_about_z(joint(b).kind))
    for (int i = 0; i < shape(joint(b).kind).angles; ++i) angle_offset_[at(offsets_[at(b)].angle + i)] = k.angle_0;
}

// What the order is cut into segments by, of the link.
void Tree::classify(int b) {
  const LinkConstants& k = links_[at(b)];
  class_[at(b)].parallel = k.cos_a == 1 && k.sin_a == 0;
  class_[at(b)].aligned = aligned(k);
}

bool Tree::joint_as_declared(int b) const { return joint_of_[at(b)] == b && reversed_[at(b)] == 0 && joint_at_[at(b)] >= 0; }
// Whether what the frame of b follows from is as the model has it; that of the parent is known.
bool Tree::frame_as_declared(int b) const {
  if (at(b) >= declared_bodies() || !joint_as_declared(b)) return false;
  if (joint(b).kind == Kind::weld) {
    const int outer = parent_[at(b)];
    return outer == declared_->bodies[at(b)].parent && (outer < 0 || class_[at(outer)].as_declared);
  }
  for (int x = b;;) {  // as far as the frame may look
    const int c = first_child_[at(x)];
    if (c != declared_->bodies[at(x)].first_child || (c >= 0 && !joint_as_declared(c))) return false;
    if (c < 0 || joint(c).kind != Kind::weld) return true;
    x = c;
  }
}

// f of b and of all bodies that are welded to it, each after the one that it is welded to.
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
      x = parent_[at(x)];
    }
  }
}

// Of b and all that is welded to it.
void Tree::make_frames(int b) {
  for_rigid(b, [this](int x) { make_frame(x); });
}
// Those of all joints on b and on what is welded to it, but for one.
void Tree::make_outboard_links(int b, int but) {
  for_rigid(b, [this, but](int x) {
    for (int c = first_child_[at(x)]; c >= 0; c = next_sibling_[at(c)])
      if (c != but) make_link(c);
  });
}

// The body that b is welded to, if it is: on a joint that moves, or on the ground.
int Tree::carrier_of(int b) const {
  while (is_welded(b) && parent_[at(b)] >= 0) b = parent_[at(b)];
  return b;
}

// The joint of b changed: so may its frame, and that of its parent, whose x looks to the joint of its first child; and every link
// that touches them.
void Tree::update_frames(int b) {
  const int outer = parent_[at(b)];
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

// Another child of b is the first, or its joint is another. Returns false where nothing looks to it.
bool Tree::renew_child_changed(int b) {
  const int carrier = carrier_of(b);
  if (is_welded(carrier) || !turns_about_z(kind(carrier))) return false;
  make_frames(carrier);
  make_link(carrier);
  make_outboard_links(carrier);
  return true;
}

// A link that was just made becomes one of the model's.
void Tree::collect(int b, LinkCollector& collector) {
  links_.give_back(at(b), at(collector.take(b, first_child_[at(b)], links_[at(b)], frame(b))));
}

}  // namespace momentree
