#include <momentree/tree/tree.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/base/check.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

namespace {

JointSpec spec_of(const Joint& joint) {
  JointSpec spec;
  spec.kind = joint.kind;
  spec.axis = joint.axis;
  spec.axis2 = joint.axis2;
  spec.pitch = joint.pitch;
  return spec;
}

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
  const double n = std::hypot(c, s);
  c = snapped(c / n);
  s = snapped(s / n);
}

// R = Rz(β) Rx(α) Rz(θ0), stable where α is small: β is found from the tilt, θ0 from what then remains.
void factorise(const Mat3& R, Link& k) {
  const double x = std::fabs(R.xz) < 1e-15 ? 0 : R.xz;
  const double tilt = std::hypot(x, R.yz);
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

Variant variant_of(const Joint& joint, bool rotor, bool reversed) {
  const bool turned = reversed && !turns_about_z(joint.kind);  // others are native against their direction
  if (joint.locked != 0) return turned ? Variant::reversed_locked : Variant::locked;
  if (turned) return Variant::reversed;
  return rotor ? Variant::rotor : Variant::plain;
}

}  // namespace

Tree::Tree(const Model& model) : gravity_(model.gravity()) {
  const int n = model.size();
  const auto size = at(n);
  parent_.resize(size), first_child_.assign(size, -1), next_sibling_.assign(size, -1);
  first_q_.resize(size), first_p_.resize(size), first_angle_.resize(size), order_.resize(size), segment_of_.resize(size);
  record_.resize(size), reversed_.assign(size, 0), variant_.resize(size);
  joint_of_.resize(size), carrier_.resize(size);
  for (int b = 0; b < n; ++b) joint_of_[at(b)] = carrier_[at(b)] = b;
  links_.resize(size), joints_.resize(size), frames_.resize(size), masses_.resize(size);
  segments_.reserve(size), spring_joints_.reserve(size), quaternion_joints_.reserve(size);
  angle_q_.resize(2 * size), angle_offset_.resize(2 * size), armature_.resize(6 * size), damping_.resize(6 * size),
      effort_.resize(6 * size);
  std::size_t largest = 0;
  for (const KindInfo& k : all_kinds())
    for (std::size_t record : shape(k.kind).record) largest = std::max(largest, record);
  record_capacity_ = largest * size;

  for (int b = 0; b < n; ++b) {
    const BodySpec& s = model.bodies()[at(b)];
    parent_[at(b)] = s.parent.index;
    joints_[at(b)] = {s.joint.kind, -1, s.at, s.child_at, s.joint.axis, s.joint.axis2, s.joint.pitch};
    masses_[at(b)] = {s.mass, s.com, s.inertia};
    const JointParameters& p = s.joint.parameters;
    if (p.damping.any() || p.stiffness.any() || p.armature.any() || p.effort.any() || !p.rest.empty()) {
      const auto same = [&p](const JointParameters& o) {
        return o.damping == p.damping && o.stiffness == p.stiffness && o.rest == p.rest && o.armature == p.armature &&
               o.effort == p.effort;
      };
      if (parameters_.empty() || !same(parameters_.back())) {
        parameters_.push_back(p);
        per_freedom_.push_back(spread(p));
      }
      joints_[at(b)].parameters = static_cast<int>(parameters_.size()) - 1;
    }
  }
  declared_ = std::make_shared<const std::vector<Joint>>(joints_);
  changed_.assign(size, 0);
  shared_parameters_ = parameters_.size();
  own_parameters_.assign(size, -1);
  parameters_.reserve(parameters_.size() + size), per_freedom_.reserve(parameters_.size() + size);
  link_all();
}

// Everything that follows from parents, joints and their directions.
void Tree::link_all() {
  first_root_ = -1;
  for (int& child : first_child_) child = -1;
  for (int b = bodies() - 1; b >= 0; --b) {  // backwards: lists in ascending order
    int& head = parent_[at(b)] < 0 ? first_root_ : first_child_[at(parent_[at(b)])];
    next_sibling_[at(b)] = head;
    head = b;
  }
  for (int b = 0; b < bodies(); ++b) make_frame(b);
  for (int b = 0; b < bodies(); ++b) make_link(b);
  relink();
}

Topology Tree::topology() const {
  Topology t;
  t.places.resize(parent_.size());
  for (int b = 0; b < bodies(); ++b) t.places[at(b)] = {parent_[at(b)], joint_of_[at(b)], reversed_[at(b)] != 0};
  for (int j = 0; j < bodies(); ++j)
    if (changed_[at(j)] != 0) t.changed.push_back({j, joints_[at(j)]});
  t.own.resize(parameters_.size() - shared_parameters_);
  for (int j = 0; j < bodies(); ++j)
    if (own_parameters_[at(j)] >= 0)
      t.own[at(own_parameters_[at(j)]) - shared_parameters_] = {j, parameters_[at(own_parameters_[at(j)])]};
  return t;
}

void Tree::restore(const Topology& topology) {
  MT_REQUIRE(topology.places.size() == parent_.size(), "the topology is one of this tree's model");
  for (int j = 0; j < bodies(); ++j)
    if (changed_[at(j)] != 0) joints_[at(j)] = (*declared_)[at(j)], changed_[at(j)] = 0;
  for (int b = 0; b < bodies(); ++b) {
    const Topology::Place& place = topology.places[at(b)];
    parent_[at(b)] = place.parent;
    joint_of_[at(b)] = place.joint, carrier_[at(place.joint)] = b;
    reversed_[at(b)] = place.reversed ? 1 : 0;
  }
  for (const Topology::Changed& c : topology.changed) joints_[at(c.joint)] = c.as, changed_[at(c.joint)] = 1;
  parameters_.resize(shared_parameters_), per_freedom_.resize(shared_parameters_);
  for (int& own : own_parameters_) own = -1;
  for (const Topology::Own& own : topology.own) give_parameters(own.joint, own.parameters);
  ++revision_;
  link_all();
}

namespace {

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
  link.locked = joint(b).locked;
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
    if (std::hypot(cosine, sine) < 1e-9) cosine = r.x, sine = r.y;
    if (std::hypot(cosine, sine) > 1e-9) {
      unit_pair(cosine, sine);
      mine.C = turned_z(mine.C, cosine, sine);
    }
  }
  frames_[at(b)] = {side * mine.C, mine.own.position};
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
  const MassProperties& m = masses_[at(b)];
  const Vec3 c = transpose_times(own.R, m.com - own.r);
  const double cc = dot(c, c);
  k.body.m = m.mass;
  k.body.mc = m.mass * c;
  k.body.J =
      rotate(transpose(own.R), m.inertia) + Sym3{m.mass * (cc - c.x * c.x), m.mass * (cc - c.y * c.y), m.mass * (cc - c.z * c.z),
                                                 -m.mass * c.x * c.y,       -m.mass * c.x * c.z,       -m.mass * c.y * c.z};
}

Tree::PerFreedom Tree::spread(const JointParameters& parameters) {
  PerFreedom f;
  for (int i = 0; i < 6; ++i) {
    const auto value = [i](const Values& v) { return v.size() == 1 ? v[0] : i < v.size() ? v[i] : 0.0; };
    f.armature[at(i)] = value(parameters.armature);
    f.damping[at(i)] = value(parameters.damping);
    f.effort[at(i)] = value(parameters.effort);
  }
  f.rotor = parameters.armature.any();
  f.spring = parameters.stiffness.any();
  f.force = parameters.damping.any() || parameters.effort.any();
  return f;
}

void Tree::relink() {
  const int n = bodies();
  has_forces_ = false;
  spring_joints_.clear(), quaternion_joints_.clear(), segments_.clear();
  int q = 0, p = 0, angles = 0;
  for (int j = 0; j < n; ++j) {  // packed in the order of joint numbers: re-rooting moves no coordinate
    const auto b = at(carrier_[at(j)]);
    const Joint& joint = joints_[at(j)];
    const KindShape& kind = shape(joint.kind);
    static constexpr PerFreedom none{};
    const PerFreedom& given = joint.parameters < 0 ? none : per_freedom_[at(joint.parameters)];
    first_q_[b] = q, first_p_[b] = p, first_angle_[b] = angles;
    for (int i = 0; i < kind.angles; ++i) {
      angle_q_[at(angles)] = q + kind.angle[i];
      angle_offset_[at(angles++)] = kind.turns_about_z ? links_[b].angle_0 : 0.0;
    }
    for (int i = 0; i < kind.nv; ++i) {
      const bool moves = (joint.locked >> i & 1u) == 0;  // a locked freedom's forces do nothing
      armature_[at(p + i)] = given.armature[at(i)];
      damping_[at(p + i)] = moves ? given.damping[at(i)] : 0.0;
      effort_[at(p + i)] = moves ? given.effort[at(i)] : 0.0;
    }
    if (given.spring) spring_joints_.push_back(static_cast<int>(b));
    has_forces_ = has_forces_ || given.force;
    const bool rotor = given.rotor;
    variant_[b] = variant_of(joint, rotor, reversed_[b] != 0);
    if (kind.nq > kind.nv) quaternion_joints_.push_back(static_cast<int>(b));
    q += kind.nq, p += kind.nv;
  }
  nq_ = q, nv_ = p, angles_ = angles;

  // Depth first, inboard before outboard, without a stack: a chain of a million bodies is as deep as it is long.
  junctions_ = 0;
  record_scalars_ = 0;
  int place = 0;
  for (int b = first_root_; b >= 0;) {
    order_[at(place)] = b;
    const Kind kind = joint(b).kind;
    const Variant variant = variant_[at(b)];
    const Link& link = links_[at(b)];
    const bool aligned = link.sin_b == 0 && link.cos_b == 1;
    record_[at(b)] = record_scalars_;
    record_scalars_ += shape(kind).record[static_cast<std::size_t>(variant)];
    const int outer = parent_[at(b)];
    Segment* last = segments_.empty() ? nullptr : &segments_.back();
    const bool goes_on = last != nullptr && place > 0 && outer >= 0 && order_[at(place - 1)] == outer &&
                         next_sibling_[at(first_child_[at(outer)])] < 0 && last->kind == kind && last->variant == variant &&
                         last->aligned == aligned;
    if (goes_on) {
      last->end = place + 1;
    } else {
      Segment s{place, place + 1, -1, -1, kind, variant, aligned, Segment::Deposit::none};
      if (outer >= 0) {
        Segment& before = segments_[at(segment_of_[at(outer)])];
        if (before.junction < 0) before.junction = junctions_++;
        s.parent = before.junction;
        // The way in runs through the segments backwards: the last child reaches the junction first.
        s.deposit = next_sibling_[at(b)] < 0 ? Segment::Deposit::assign : Segment::Deposit::add;
      }
      segments_.push_back(s);
    }
    segment_of_[at(b)] = static_cast<int>(segments_.size()) - 1;
    links_[at(b)].subtree_mass = links_[at(b)].body.m;
    ++place;
    if (first_child_[at(b)] >= 0) {
      b = first_child_[at(b)];
    } else {
      while (b >= 0 && next_sibling_[at(b)] < 0) b = parent_[at(b)];
      if (b >= 0) b = next_sibling_[at(b)];
    }
  }
  MT_REQUIRE(place == n, "every body hangs on the ground");
  for (int i = n - 1; i >= 0; --i) {
    const int b = order_[at(i)], outer = parent_[at(b)];
    if (outer >= 0) links_[at(outer)].subtree_mass += links_[at(b)].subtree_mass;
  }
}

void Tree::unlink(int b) {
  const int outer = parent_[at(b)];
  int* head = outer < 0 ? &first_root_ : &first_child_[at(outer)];
  while (*head != b) head = &next_sibling_[at(*head)];
  *head = next_sibling_[at(b)];
}

// Siblings and roots stand in ascending order: the order of evaluation is that of the topology, not of its history.
void Tree::hang(int b, int parent) {
  int* head = parent < 0 ? &first_root_ : &first_child_[at(parent)];
  while (*head >= 0 && *head < b) head = &next_sibling_[at(*head)];
  next_sibling_[at(b)] = *head;
  *head = b;
  parent_[at(b)] = parent;
}

// Frames and links after b's joint changed: b's frame, that of its parent, whose x may look to b's joint, and the links of both
// and of their children. (A frame is a function of the topology, not of its history.)
void Tree::renew(int b) {
  make_frame(b);
  make_link(b);
  for (int c = first_child_[at(b)]; c >= 0; c = next_sibling_[at(c)]) make_link(c);
  const int outer = parent_[at(b)];
  if (outer >= 0 && first_child_[at(outer)] == b) renew_looking_out(outer);
}

// The first child of b changed: its frame looks to that one's joint.
void Tree::renew_looking_out(int b) {
  if (!turns_about_z(joint(b).kind)) return;
  make_frame(b);
  make_link(b);
  for (int c = first_child_[at(b)]; c >= 0; c = next_sibling_[at(c)]) make_link(c);
}

Joint& Tree::change_joint(int b) {
  changed_[at(joint_of_[at(b)])] = 1;
  return joints_[at(joint_of_[at(b)])];
}

namespace {
Joint made_free_joint() {
  Joint joint;
  joint.kind = Kind::free;
  joint.made = true;
  return joint;
}
}  // namespace

void Tree::detach(int b) {
  const int outer = parent_[at(b)];
  const bool was_first = outer >= 0 && first_child_[at(outer)] == b;
  unlink(b);
  hang(b, -1);
  change_joint(b) = made_free_joint();
  reversed_[at(b)] = 0;
  renew(b);
  if (was_first) renew_looking_out(outer);
  ++revision_;
  relink();
}

void Tree::regraft(int b, int parent) {
  MT_REQUIRE(parent_[at(b)] < 0 && joint(b).made && joint(b).kind == Kind::free,
             "the body is a root on a free joint of its own frame");
  unlink(b);
  hang(b, parent);
  if (parent >= 0 && first_child_[at(parent)] == b) renew_looking_out(parent);
  make_link(b);
  ++revision_;
  relink();
}

void Tree::reroot(int b) {
  // Walk from b up to the root, hanging each body's parent below it: joints keep their numbers, carriers move one body inboard.
  int root = b;
  while (parent_[at(root)] >= 0) root = parent_[at(root)];
  MT_REQUIRE(joint(root).kind == Kind::free, "the root hangs on a free joint");
  const int free_joint = joint_of_[at(root)];
  int below = -1, body = b, joint_below = free_joint;
  unsigned char reversed_below = 0;
  while (body >= 0) {
    const int outer = parent_[at(body)];
    const int own_joint = joint_of_[at(body)];
    const unsigned char own_reversed = reversed_[at(body)];
    unlink(body);
    hang(body, below);
    joint_of_[at(body)] = joint_below;
    carrier_[at(joint_below)] = body;
    reversed_[at(body)] = reversed_below;
    joint_below = own_joint;
    reversed_below = own_reversed != 0 ? 0 : 1;
    below = body;
    body = outer;
  }
  change_joint(b) = made_free_joint();
  // Frames stand at the joints carried: renewed from the old root to b's neighbour, then b; then every link that touches them.
  for (int a = root; a >= 0; a = parent_[at(a)]) make_frame(a);
  for (int a = root; a >= 0; a = parent_[at(a)]) {
    make_link(a);
    for (int c = first_child_[at(a)]; c >= 0; c = next_sibling_[at(c)]) make_link(c);
  }
  ++revision_;
  relink();
}

void Tree::set_joint(int b, const Joint& joint, bool reversed) {
  MT_REQUIRE(!reversed || parent_[at(b)] >= 0, "the ground is nobody's child");
  reversed_[at(b)] = reversed ? 1 : 0;
  change_joint(b) = joint;
  renew(b);
  ++revision_;
  relink();
}

void Tree::set_parameters(int b, const JointParameters& parameters) {
  give_parameters(joint_of_[at(b)], parameters);
  change_joint(b).parameters = own_parameters_[at(joint_of_[at(b)])];
  ++revision_;
  relink();
}

void Tree::give_parameters(int joint, const JointParameters& parameters) {
  int& own = own_parameters_[at(joint)];
  if (own < 0) {  // the joint's own place, once and for all: reserved at the start
    own = static_cast<int>(parameters_.size());
    parameters_.emplace_back();
    per_freedom_.emplace_back();
  }
  parameters_[at(own)] = parameters;
  per_freedom_[at(own)] = spread(parameters);
}

}  // namespace momentree
