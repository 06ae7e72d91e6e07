#include <tests/oracle/maximal.hpp>

#include <numbers>

namespace momentree::oracle {

namespace {

using Wide3 = Eigen::Matrix<long double, 3, 1>;
using Wide33 = Eigen::Matrix<long double, 3, 3>;

Wide3 wide(const Vec3& a) { return {a.x, a.y, a.z}; }
Wide33 wide(const Quat& q) { return Eigen::Quaternion<long double>(q.w, q.x, q.y, q.z).normalized().toRotationMatrix(); }
Wide33 cross_matrix(const Wide3& a) {
  Wide33 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

struct Frame3 {
  Wide33 R = Wide33::Identity();
  Wide3 r = Wide3::Zero();
};
Frame3 frame_of(const World& world, BodyId body) {
  if (body == ground) return {};
  const Pose& pose = world.motions()[static_cast<std::size_t>(body.index)].pose;
  return {wide(pose.rotation), wide(pose.position)};
}
Frame3 inside(const Frame3& outer, const Pose& at) {
  return {outer.R * wide(at.rotation), outer.r + outer.R * wide(at.position)};
}

// The relative motions that a joint allows: of its child-side origin, and the relative angular velocity; world axes. `a`, `b`:
// parent-side and child-side frames.
WideMatrix allowed(const JointView& joint, const Frame3& a, const Frame3& b) {
  WideMatrix all(6, 0);
  const auto add = [&](const Wide3& v, const Wide3& w) {
    all.conservativeResize(Eigen::NoChange, all.cols() + 1);
    all.col(all.cols() - 1) << v, w;
  };
  const Wide3 zero = Wide3::Zero(), n = a.R * wide(joint.axis);
  switch (joint.kind) {
    case Kind::weld: break;
    case Kind::revolute: add(zero, n); break;
    case Kind::prismatic: add(n, zero); break;
    case Kind::helical: add(static_cast<long double>(joint.pitch) / (2 * std::numbers::pi_v<long double>)*n, n); break;
    case Kind::cylindrical: add(zero, n), add(n, zero); break;
    case Kind::universal: add(zero, n), add(zero, b.R * wide(joint.axis2)); break;
    case Kind::ball:
      for (int i = 0; i < 3; ++i) add(zero, b.R.col(i));
      break;
    case Kind::planar: add(a.R.col(0), zero), add(a.R.col(1), zero), add(zero, a.R.col(2)); break;
    case Kind::free:
      for (int i = 0; i < 3; ++i) add(b.R.col(i), zero);
      for (int i = 0; i < 3; ++i) add(zero, b.R.col(i));
      break;
  }
  int kept = 0;
  for (int i = 0; i < static_cast<int>(all.cols()); ++i)
    if ((joint.locked >> i & 1u) == 0) all.col(kept++) = all.col(i).eval();
  return all.leftCols(kept);
}

}  // namespace

std::vector<JointId> all_joints(const World& world) {
  std::vector<JointId> all;
  for (const int b : world.tree().order()) all.push_back(world.tree().inboard_joint({b}));
  for (const JointId loop : world.loops()) all.push_back(loop);
  return all;
}

WideVector body_velocities(const World& world) {
  WideVector V = WideVector::Zero(6 * world.model().size());
  for (const int b : world.tree().order()) {
    const BodyMotion& motion = world.motions()[static_cast<std::size_t>(b)];
    const Wide3 w = wide(motion.angular), arm = wide(motion.pose.rotation) * wide(world.model()[BodyId{b}].com);
    V.segment<3>(6 * b) = wide(motion.linear) + w.cross(arm);
    V.segment<3>(6 * b + 3) = w;
  }
  return V;
}

WideMatrix joint_rows(const World& world, JointId id) {
  const JointView joint = world.joint(id);
  const Frame3 a = inside(frame_of(world, joint.parent), joint.at), b = inside(frame_of(world, joint.child), joint.child_at);
  // Velocity of the child at the joint's child-side origin relative to the parent there, as a function of all velocities.
  WideMatrix relative = WideMatrix::Zero(6, 6 * world.model().size());
  const auto add = [&](BodyId body, long double sign) {
    if (body == ground) return;
    const Frame3 own = frame_of(world, body);
    const Wide3 arm = b.r - (own.r + own.R * wide(world.model()[body].com));
    relative.block<3, 3>(0, 6 * body.index) += sign * Wide33::Identity();
    relative.block<3, 3>(0, 6 * body.index + 3) -= sign * cross_matrix(arm);
    relative.block<3, 3>(3, 6 * body.index + 3) += sign * Wide33::Identity();
  };
  add(joint.child, 1), add(joint.parent, -1);
  const WideMatrix free = allowed(joint, a, b);
  WideMatrix complement = WideMatrix::Identity(6, 6);
  if (free.cols() > 0) complement = Eigen::HouseholderQR<WideMatrix>(free).householderQ();
  return complement.rightCols(6 - free.cols()).transpose() * relative;
}

Projection::Projection(const World& world) {
  const int n = 6 * world.model().size();
  mass_ = WideMatrix::Identity(n, n);
  for (const int b : world.tree().order()) {
    const BodySpec& body = world.model()[BodyId{b}];
    const Wide33 R = frame_of(world, {b}).R;
    Wide33 I;
    I << body.inertia.xx, body.inertia.xy, body.inertia.xz, body.inertia.xy, body.inertia.yy, body.inertia.yz, body.inertia.xz,
        body.inertia.yz, body.inertia.zz;
    mass_.block<3, 3>(6 * b, 6 * b) *= body.mass;
    mass_.block<3, 3>(6 * b + 3, 6 * b + 3) = R * I * R.transpose();
  }
  root_ = mass_.llt().matrixL();
  const auto columns = [&](std::span<const JointId> joints) {  // L⁻¹ Cᵀ, of unit length
    WideMatrix all(n, 0);
    for (const JointId joint : joints) {
      const WideMatrix C = joint_rows(world, joint);
      WideMatrix more(n, all.cols() + C.rows());
      more << all, root_.triangularView<Eigen::Lower>().solve(C.transpose());
      all = more;
    }
    for (int i = 0; i < static_cast<int>(all.cols()); ++i) all.col(i).normalize();
    return all;
  };
  const std::vector<JointId> joints = all_joints(world);
  const std::size_t of_tree = world.tree().order().size();
  const WideMatrix tree = columns({joints.data(), of_tree}), loops = columns({joints.data() + of_tree, joints.size() - of_tree});
  WideMatrix basis(n, 0);
  if (tree.cols() > 0) {
    const Eigen::HouseholderQR<WideMatrix> qr(tree);
    basis = qr.householderQ() * WideMatrix::Identity(n, tree.cols());
  }
  if (loops.cols() > 0) {
    WideMatrix left = loops;
    for (int pass = 0; pass < 2; ++pass) left -= basis * (basis.transpose() * left);
    const Eigen::ColPivHouseholderQR<WideMatrix> qr(left);
    const int most = static_cast<int>(std::min(left.rows(), left.cols()));
    pivots_.assign(static_cast<std::size_t>(left.cols()), 0);
    for (int i = 0; i < most; ++i) pivots_[static_cast<std::size_t>(i)] = qr.matrixR()(i, i) * qr.matrixR()(i, i);
    while (rank_ < most && pivots_[static_cast<std::size_t>(rank_)] > 1e-9L) ++rank_;
    const WideMatrix more = qr.householderQ() * WideMatrix::Identity(n, rank_);
    WideMatrix both(n, basis.cols() + rank_);
    both << basis, more;
    basis = both;
  }
  constrained_ = basis;
}

bool Projection::undecided() const {
  return std::any_of(pivots_.begin(), pivots_.end(), [](long double x) { return x > 1e-20L && x < 1e-6L; });
}

WideVector Projection::operator()(const WideVector& velocities) const {
  WideVector x = root_.transpose() * velocities;
  for (int pass = 0; pass < 2; ++pass) x -= constrained_ * (constrained_.transpose() * x);
  return root_.transpose().triangularView<Eigen::Upper>().solve(x);
}

}  // namespace momentree::oracle
