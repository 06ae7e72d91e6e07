#include <tests/oracle/machine.hpp>

#include <string>
#include <vector>

namespace momentree::oracle {

Column Machine::velocities() const {
  Column V = Column::Zero(6 * size());
  for (int b : tree.order()) {
    const Kinematics<double>& k = workspace.bodies[static_cast<std::size_t>(b)];
    const Vec3 w = k.R * k.velocity.w;
    const Vec3 v = k.R * k.velocity.v + cross(w, pose(b) * model[{b}].com - k.r);
    V.segment(6 * b, 6) << v.x, v.y, v.z, w.x, w.y, w.z;
  }
  return V;
}

Dense Machine::masses() const {
  Dense M = Dense::Identity(6 * size(), 6 * size());  // removed bodies are at rest
  for (int b : tree.order()) {
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
  for (int b : tree.order()) {
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

unsigned some_dofs(Prng& random, int nv) {
  const unsigned all = (1u << nv) - 1;
  const unsigned some = static_cast<unsigned>(random.integer(0, (1 << nv) - 1)) & all;
  return some == 0 ? all : some;
}

namespace {
// A joint of a random kind whose declared child is at `now` in its parent.
void random_placed_joint(Prng& random, const Pose& now, Joint& joint, Values& q) {
  const JointSpec spec = random_joint(random, random_kind(random), {.parameters = false});
  q = random_coordinates(random, spec.kind);  // any q: the offset compensates for it
  joint.kind = spec.kind, joint.axis = normalized(spec.axis), joint.pitch = spec.pitch;
  if (spec.kind == Kind::universal) joint.axis2 = normalized(spec.axis2);
  // at · motion(q) = present pose of the child in the parent
  JointSpec plain;
  plain.kind = joint.kind, plain.axis = joint.axis, plain.axis2 = joint.axis2, plain.pitch = spec.pitch;
  Model single;
  BodySpec body;
  body.name = "x", body.mass = 1, body.inertia = diagonal(1), body.joint = plain, body.q = q;
  single.add(body);
  const Machine alone(single);
  joint.at = now * inverse(alone.pose(0));
}
Pose relative_pose(const Machine& m, int child, int parent) {
  return parent < 0 ? m.pose(child) : inverse(m.pose(parent)) * m.pose(child);
}
}  // namespace

ChangeJoint random_change(Prng& random, const Machine& m, int b, ChangeJoint::Direction direction) {
  using Direction = ChangeJoint::Direction;
  const bool reversed = direction == Direction::keep ? m.tree.reversed(b) : direction == Direction::reversed;
  const int child = reversed ? m.tree.parent(b) : b, parent = reversed ? b : m.tree.parent(b);
  ChangeJoint change;
  change.joint = m.tree.inboard_joint({b}), change.direction = direction;
  random_placed_joint(random, relative_pose(m, child, parent), change.to, change.q);
  return change;
}

Attach random_attach(Prng& random, const Machine& m, int b, int to) {
  Attach attach;
  attach.body = {b}, attach.to = {to}, attach.reversed = to >= 0 && random.chance(0.5);
  random_placed_joint(random, attach.reversed ? relative_pose(m, to, b) : relative_pose(m, b, to), attach.joint, attach.q);
  return attach;
}

int Machine::some_body(Prng& random) const {
  const auto order = tree.order();
  return order[static_cast<std::size_t>(random.integer(0, static_cast<int>(order.size()) - 1))];
}

namespace {
Sym3 some_inertia(double I) { return {I, 1.3 * I, 1.2 * I, 0.1 * I, 0.05 * I, -0.1 * I}; }
}  // namespace

int Machine::add(Prng& random, bool parameters, bool at_rest) {
  BodySpec spec;
  spec.name = "added/" + std::to_string(size());
  spec.mass = random.log_uniform(0.1, 10);
  spec.com = random.vector(0.2);
  spec.inertia = some_inertia(spec.mass * random.uniform(0.01, 0.1));
  spec.parent = {random.chance(0.2) ? -1 : some_body(random)};
  spec.at = {random.vector(0.5), random.rotation()};
  spec.child_at = {random.vector(0.2), random.rotation()};
  const int kind = random.integer(0, static_cast<int>(all_kinds().size()) - 1);
  spec.joint = random_joint(random, all_kinds()[static_cast<std::size_t>(kind)].kind, {.parameters = parameters});
  spec.q = random_coordinates(random, spec.joint.kind);
  if (!at_rest) spec.v = random_velocities(random, spec.joint.kind);
  const BodyId body = model.add(spec);
  apply(Add{&model[body]}, tree, state, workspace);
  workspace = Workspace<double>(tree);
  return body.index;
}

int Machine::part(int b) const {
  int count = 0;
  for (int x : tree.order())
    for (int a = x; a >= 0; a = tree.parent(a)) count += a == b;
  return count;
}

void act(Prng& random, Machine& m) {
  const int b = m.some_body(random);
  const int nv = info(m.tree.joint(b).kind).nv;
  const int living = static_cast<int>(m.tree.order().size());
  switch (random.integer(0, 9)) {
    case 0:
      if (can_break(m.tree, m.tree.inboard_joint({b}))) apply(Break{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace);
      break;
    case 1:
      if (nv > 0) apply(Lock{m.tree.inboard_joint({b}), some_dofs(random, nv)}, m.tree, m.state, m.workspace);
      break;
    case 2: apply(Unlock{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace); break;
    case 3: apply(random_change(random, m, b), m.tree, m.state, m.workspace); break;
    case 4:
      if (floats(m.tree, {b})) apply(Reroot{{b}}, m.tree, m.state, m.workspace);
      break;
    case 5: {
      JointParameters parameters;
      parameters.damping = random.uniform(0, 0.1), parameters.armature = random.uniform(0, 0.1);
      if (m.tree.parent(b) >= 0 && nv > 0)
        apply(SetParameters{m.tree.inboard_joint({b}), parameters}, m.tree, m.state, m.workspace);
      break;
    }
    case 6:
      if (living < 25) m.add(random, true, false);
      break;
    case 7:
      if (m.tree.parent(b) < 0 && floats(m.tree, {b}) && living - m.part(b) > 2) apply(Remove{{b}}, m.tree, m.state, m.workspace);
      break;
    default: {
      const int to = m.some_body(random);
      if (root_of(m.tree, {to}).index == root_of(m.tree, {b}).index || !floats(m.tree, {b})) break;
      if (random.chance(0.3)) {
        apply(Join{{b}, {to}}, m.tree, m.state, m.workspace);
      } else {
        apply(random_attach(random, m, b, to), m.tree, m.state, m.workspace);
      }
    }
  }
  m.evaluate();
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
