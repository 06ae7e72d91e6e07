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

bool turns_about_z(Kind kind) {
  return dispatch(kind, [](auto tag) { return decltype(tag)::type::Kernels::turns_about_z; });
}

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

bool any_armature(const JointParameters* p) { return p != nullptr && p->armature.any(); }

double value_at(const Values& values, int i) { return values.empty() ? 0.0 : values.size() == 1 ? values[0] : values[i]; }

template <class A>
constexpr std::size_t scalars() {
  return sizeof(A) / sizeof(double);
}

}  // namespace

Tree::Tree(const Model& model) : gravity_(model.gravity()) {
  const int n = model.size();
  const auto size = at(n);
  parent_.resize(size), first_child_.assign(size, -1), next_sibling_.assign(size, -1);
  first_q_.resize(size), first_p_.resize(size), first_angle_.resize(size), order_.resize(size), segment_of_.resize(size);
  record_.resize(size), armature_flag_.resize(size), detached_.assign(size, 0);
  links_.resize(size), joints_.resize(size), frames_.resize(size), masses_.resize(size);
  segments_.reserve(size), spring_joints_.reserve(size), quaternion_joints_.reserve(size);
  angle_q_.reserve(2 * size), angle_offset_.reserve(2 * size), armature_.reserve(6 * size), damping_.reserve(6 * size),
      effort_.reserve(6 * size);
  std::size_t largest = 0;
  for (const KindInfo& k : all_kinds())
    for (bool armature : {false, true})
      dispatch_kernels(k.kind, armature, [&](auto tag) {
        largest = std::max(largest, scalars<typename decltype(tag)::type::template Record<double>>());
      });
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
      if (parameters_.empty() || !same(parameters_.back())) parameters_.push_back(p);
      joints_[at(b)].parameters = static_cast<int>(parameters_.size()) - 1;
    }
  }
  for (int b = n - 1; b >= 0; --b) {  // backwards: lists in ascending order
    int& head = parent_[at(b)] < 0 ? first_root_ : first_child_[at(parent_[at(b)])];
    next_sibling_[at(b)] = head;
    head = b;
  }
  for (int b = 0; b < n; ++b) make_frame(b);
  for (int b = 0; b < n; ++b) make_link(b);
  relink();
}

void Tree::make_frame(int b) {
  const Joint& joint = joints_[at(b)];
  Link& link = links_[at(b)];
  Mat3 C = joint_axes(joint, link.geometry);
  const Mat3 child = rotation_matrix(joint.child_at.rotation);
  const int c = first_child_[at(b)];
  if (turns_about_z(joint.kind) && c >= 0) {
    // x is free: choose it so that the first child's axis needs no turn about z (β = 0), or, if it is parallel, lies along x.
    double geometry[2];
    const Joint& next = joints_[at(c)];
    const Mat3 own = child * C;
    const Mat3 axes = rotation_matrix(next.at.rotation) * joint_axes(next, geometry);
    const Vec3 d = transpose_times(own, Vec3{axes.xz, axes.yz, axes.zz});
    const Vec3 r = transpose_times(own, next.at.position - joint.child_at.position);
    double cosine = -d.y, sine = d.x;
    if (std::hypot(cosine, sine) < 1e-9) cosine = r.x, sine = r.y;
    if (std::hypot(cosine, sine) > 1e-9) {
      unit_pair(cosine, sine);
      C = turned_z(C, cosine, sine);
    }
  }
  frames_[at(b)] = {child * C, joint.child_at.position};
}

void Tree::make_link(int b) {
  const Joint& joint = joints_[at(b)];
  const KernelFrame own = frames_[at(b)];
  const KernelFrame outer = parent_[at(b)] < 0 ? KernelFrame{} : frames_[at(parent_[at(b)])];
  Link& k = links_[at(b)];
  // The joint's axes C are what the kernel frame has beyond child_at.
  const Mat3 C = transpose(rotation_matrix(joint.child_at.rotation)) * own.R;
  factorise(transpose(outer.R) * (rotation_matrix(joint.at.rotation) * C), k);
  k.r = transpose_times(outer.R, joint.at.position - outer.r);
  const MassProperties& m = masses_[at(b)];
  const Vec3 c = transpose_times(own.R, m.com - own.r);
  const double cc = dot(c, c);
  k.body.m = m.mass;
  k.body.mc = m.mass * c;
  k.body.J =
      rotate(transpose(own.R), m.inertia) + Sym3{m.mass * (cc - c.x * c.x), m.mass * (cc - c.y * c.y), m.mass * (cc - c.z * c.z),
                                                 -m.mass * c.x * c.y,       -m.mass * c.x * c.z,       -m.mass * c.y * c.z};
}

void Tree::relink() {
  const int n = bodies();
  nq_ = nv_ = 0;
  has_forces_ = false;
  angle_q_.clear(), angle_offset_.clear(), armature_.clear(), damping_.clear(), effort_.clear();
  spring_joints_.clear(), quaternion_joints_.clear(), segments_.clear();
  for (int b = 0; b < n; ++b) {  // packed in the order of body numbers
    const JointParameters* p = parameters(b);
    const bool armature = any_armature(p);
    armature_flag_[at(b)] = armature;
    first_q_[at(b)] = nq_, first_p_[at(b)] = nv_, first_angle_[at(b)] = static_cast<int>(angle_q_.size());
    dispatch(joints_[at(b)].kind, [&](auto tag) {
      using K = typename decltype(tag)::type;
      for (int a : K::Kernels::angles) {
        angle_q_.push_back(nq_ + a);
        angle_offset_.push_back(K::Kernels::turns_about_z ? links_[at(b)].angle_0 : 0.0);
      }
      for (int i = 0; i < K::info.nv; ++i) {
        armature_.push_back(armature ? value_at(p->armature, i) : 0.0);
        damping_.push_back(p != nullptr ? value_at(p->damping, i) : 0.0);
        effort_.push_back(p != nullptr ? value_at(p->effort, i) : 0.0);
      }
      if (K::info.nq > K::info.nv) quaternion_joints_.push_back(b);
      nq_ += K::info.nq, nv_ += K::info.nv;
    });
    if (p != nullptr && p->stiffness.any()) spring_joints_.push_back(b);
    if (p != nullptr && (p->damping.any() || p->effort.any())) has_forces_ = true;
  }

  // Depth first, inboard before outboard, without a stack: a chain of a million bodies is as deep as it is long.
  junctions_ = 0;
  record_scalars_ = 0;
  int place = 0;
  for (int b = first_root_; b >= 0;) {
    order_[at(place)] = b;
    const Joint& joint = joints_[at(b)];
    const Link& link = links_[at(b)];
    const bool armature = armature_flag_[at(b)] != 0, aligned = link.sin_b == 0 && link.cos_b == 1;
    record_[at(b)] = record_scalars_;
    dispatch_kernels(joint.kind, armature,
                     [&](auto tag) { record_scalars_ += scalars<typename decltype(tag)::type::template Record<double>>(); });
    const int p = parent_[at(b)];
    Segment* last = segments_.empty() ? nullptr : &segments_.back();
    const bool goes_on = last != nullptr && place > 0 && p >= 0 && order_[at(place - 1)] == p &&
                         next_sibling_[at(first_child_[at(p)])] < 0 && last->kind == joint.kind && last->armature == armature &&
                         last->aligned == aligned;
    if (goes_on) {
      last->end = place + 1;
    } else {
      Segment s{place, place + 1, -1, -1, joint.kind, armature, aligned, Segment::Deposit::none};
      if (p >= 0) {
        Segment& outer = segments_[at(segment_of_[at(p)])];
        if (outer.junction < 0) outer.junction = junctions_++;
        s.parent = outer.junction;
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
    const int b = order_[at(i)], p = parent_[at(b)];
    if (p >= 0) links_[at(p)].subtree_mass += links_[at(b)].subtree_mass;
  }
}

void Tree::detach(int b) {
  const int p = parent_[at(b)];
  int* head = p < 0 ? &first_root_ : &first_child_[at(p)];
  while (*head != b) head = &next_sibling_[at(*head)];
  *head = next_sibling_[at(b)];
  head = &first_root_;
  while (*head >= 0 && *head < b) head = &next_sibling_[at(*head)];  // roots in ascending order: the order stays stable
  next_sibling_[at(b)] = *head;
  *head = b;
  parent_[at(b)] = -1;
  joints_[at(b)] = {Kind::free, -1, {}, {}, {0, 0, 1}, {}, 0};
  detached_[at(b)] = 1;
  make_frame(b);
  make_link(b);
  for (int c = first_child_[at(b)]; c >= 0; c = next_sibling_[at(c)]) make_link(c);
  ++revision_;
  relink();
}

}  // namespace momentree
