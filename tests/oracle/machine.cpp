#include <tests/oracle/machine.hpp>

#include <vector>

namespace momentree::oracle {

Column Machine::velocities() const {
  Column V(6 * size());
  for (int b = 0; b < size(); ++b) {
    const Kinematics<double>& k = work.bodies[static_cast<std::size_t>(b)];
    const Vec3 w = k.R * k.velocity.w;
    const Vec3 v = k.R * k.velocity.v + cross(w, pose(b) * model[{b}].com - k.r);
    V.segment(6 * b, 6) << v.x, v.y, v.z, w.x, w.y, w.z;
  }
  return V;
}

Dense Machine::masses() const {
  Dense M = Dense::Zero(6 * size(), 6 * size());
  for (int b = 0; b < size(); ++b) {
    const BodySpec& body = model[{b}];
    const Sym3 I = rotate(rotation_matrix(pose(b).rotation), body.inertia);
    for (int i = 0; i < 3; ++i) M(6 * b + i, 6 * b + i) = body.mass;
    Dense J(3, 3);
    J << I.xx, I.xy, I.xz, I.xy, I.yy, I.yz, I.xz, I.yz, I.zz;
    M.block(6 * b + 3, 6 * b + 3, 3, 3) = J;
  }
  return M;
}

Dense Machine::constraints() const {
  std::vector<Column> rows;
  for (int b = 0; b < size(); ++b) {
    const bool reversed = tree.reversed(b);
    const int child = reversed ? tree.parent(b) : b, parent = reversed ? b : tree.parent(b);
    const Joint& joint = tree.joint(b);
    System one;
    JointSpec spec;
    spec.kind = joint.kind, spec.axis = joint.axis, spec.axis2 = joint.axis2, spec.pitch = joint.pitch;
    one.links.push_back({-1, spec, joint.at, joint.child_at, 1, {}, {}});
    number(one);
    std::vector<double> q;
    for (int i = 0; i < one.nq(); ++i) q.push_back(state.q()[static_cast<std::size_t>(tree.first_q(b) + i)]);
    const auto columns = joint_columns(one, q, 0);
    Dense E(6, 6);
    E.setZero();
    int used = 0;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if ((joint.locked >> i & 1u) != 0) continue;
      for (int k = 0; k < 6; ++k) E(k, used) = columns[i][static_cast<std::size_t>(k)];
      ++used;
    }
    // Twist of the child relative to the parent at the child's origin, child axes: linear in the world velocities.
    Dense T = Dense::Zero(6, 6 * size());
    const Pose at = pose(child);
    const Mat3 R = rotation_matrix(at.rotation);
    const auto add = [&](int body, long double sign) {
      if (body < 0) return;
      const Vec3 arm = at.position - pose(body) * model[{body}].com;
      const double r[3][3] = {{R.xx, R.xy, R.xz}, {R.yx, R.yy, R.yz}, {R.zx, R.zy, R.zz}};
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 n{r[0][axis], r[1][axis], r[2][axis]};
        const Vec3 m = cross(arm, n);  // n·(ω × arm) = ω·(arm × n)
        const double linear[3] = {n.x, n.y, n.z}, angular[3] = {m.x, m.y, m.z};
        for (int k = 0; k < 3; ++k) {
          T(axis, 6 * body + k) += sign * linear[k];
          T(axis, 6 * body + 3 + k) += sign * angular[k];
          T(axis + 3, 6 * body + 3 + k) += sign * linear[k];
        }
      }
    };
    add(child, 1);
    add(parent, -1);
    // The complement of span E.
    const Eigen::FullPivHouseholderQR<Dense> qr(E.leftCols(used));
    Dense Q = Dense::Identity(6, 6);
    if (used > 0) Q = qr.matrixQ();
    for (int k = used; k < 6; ++k) rows.push_back((Q.col(k).transpose() * T).transpose());
  }
  Dense C(static_cast<int>(rows.size()), 6 * size());
  for (std::size_t i = 0; i < rows.size(); ++i) C.row(static_cast<int>(i)) = rows[i].transpose();
  return C;
}

Column projected(const Dense& M, const Dense& C, const Column& V) {
  if (C.rows() == 0) return V;
  const Dense MiC = M.llt().solve(C.transpose());
  return V - MiC * (C * MiC).ldlt().solve(C * V);
}

unsigned some_freedoms(Prng& random, int nv) {
  const unsigned all = (1u << nv) - 1;
  const unsigned some = static_cast<unsigned>(random.integer(0, (1 << nv) - 1)) & all;
  return some == 0 ? all : some;
}

ChangeJoint random_change(Prng& random, const Machine& m, int b, ChangeJoint::Direction direction) {
  using Direction = ChangeJoint::Direction;
  const bool reversed = direction == Direction::keep ? m.tree.reversed(b) : direction == Direction::reversed;
  const int child = reversed ? m.tree.parent(b) : b, parent = reversed ? b : m.tree.parent(b);
  const Kind kinds[] = {Kind::revolute, Kind::prismatic, Kind::helical, Kind::cylindrical, Kind::universal,
                        Kind::ball,     Kind::planar,    Kind::free,    Kind::weld};
  const JointSpec spec = random_joint(random, kinds[random.integer(0, 9 - 1)], {.parameters = false});
  ChangeJoint change;
  change.body = {b}, change.direction = direction;
  const Values q = random_coordinates(random, spec.kind);  // any q will do: the offset takes up the rest
  change.joint.kind = spec.kind, change.joint.axis = normalized(spec.axis), change.joint.pitch = spec.pitch;
  if (spec.kind == Kind::universal) change.joint.axis2 = normalized(spec.axis2);
  change.q = q;
  // at · motion(q) = present pose of the child in the parent
  System one;
  JointSpec plain;
  plain.kind = change.joint.kind, plain.axis = change.joint.axis, plain.axis2 = change.joint.axis2, plain.pitch = spec.pitch;
  Model single;
  BodySpec body;
  body.name = "x", body.mass = 1, body.inertia = diagonal(1), body.joint = plain, body.q = q;
  single.add(body);
  const Machine alone(single);
  const Pose now = parent < 0 ? m.pose(child) : inverse(m.pose(parent)) * m.pose(child);
  change.joint.at = now * inverse(alone.pose(0));
  return change;
}

double condition(const Dense& M, const Dense& C) {
  Dense N = Dense::Identity(M.rows(), M.cols());
  if (C.rows() > 0) {
    const Dense Q = Eigen::HouseholderQR<Dense>(C.transpose()).householderQ();
    N = Q.rightCols(C.cols() - C.rows());
  }
  if (N.cols() == 0) return 1;
  const Eigen::MatrixXd H = (N.transpose() * M * N).cast<double>();
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly).eigenvalues();
  return eigenvalues.maxCoeff() / std::max(eigenvalues.minCoeff(), 1e-300);
}

}  // namespace momentree::oracle
