// Topology changes against an independent projection: in maximal coordinates (velocities of all bodies, mass-weighted), with
// constraints from the oracle's forward kinematics alone.
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Dense>

#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/topology/change.hpp>
#include <tests/oracle/oracle.hpp>
#include <tests/oracle/random_model.hpp>

using namespace momentree;
using oracle::Prng;

namespace {

using Dense = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Column = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

struct Machine {
  Model model;
  Tree tree;
  State state;
  Work<double> work;
  explicit Machine(const Model& m) : model(m), tree(model), state(start_state(model, tree)), work(tree) { evaluate(); }
  void evaluate() { locate_bodies(tree, state, work); }
  int size() const { return tree.bodies(); }

  Pose pose(int b) const { return user_pose(tree, work.bodies[static_cast<std::size_t>(b)], b); }
  // Velocities of the centres of mass and angular velocities, world axes.
  Column velocities() const {
    Column V(6 * size());
    for (int b = 0; b < size(); ++b) {
      const Kinematics<double>& k = work.bodies[static_cast<std::size_t>(b)];
      const Vec3 w = k.R * k.velocity.w;
      const Vec3 v = k.R * k.velocity.v + cross(w, pose(b) * model[{b}].com - k.r);
      V.segment(6 * b, 6) << v.x, v.y, v.z, w.x, w.y, w.z;
    }
    return V;
  }
  Dense masses() const {
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
  // Rows C with C V = 0 for the joints as they are: what the declared child may not do relative to its parent.
  Dense constraints() const {
    std::vector<Column> rows;
    for (int b = 0; b < size(); ++b) {
      const bool reversed = tree.reversed(b);
      const int child = reversed ? tree.parent(b) : b, parent = reversed ? b : tree.parent(b);
      const Joint& joint = tree.joint(b);
      oracle::System one;
      JointSpec spec;
      spec.kind = joint.kind, spec.axis = joint.axis, spec.axis2 = joint.axis2, spec.pitch = joint.pitch;
      one.links.push_back({-1, spec, joint.at, joint.child_at, 1, {}, {}});
      oracle::number(one);
      std::vector<double> q;
      for (int i = 0; i < one.nq(); ++i) q.push_back(state.q()[static_cast<std::size_t>(tree.first_q(b) + i)]);
      const auto columns = oracle::joint_columns(one, q, 0);
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
};

Column projected(const Dense& M, const Dense& C, const Column& V) {
  if (C.rows() == 0) return V;
  const Dense MiC = M.llt().solve(C.transpose());
  return V - MiC * (C * MiC).ldlt().solve(C * V);
}
long double energy(const Dense& M, const Column& V) { return V.dot(M * V) / 2; }

unsigned mask(Prng& random, int nv) {
  const unsigned all = (1u << nv) - 1;
  const unsigned some = static_cast<unsigned>(random.integer(0, (1 << nv) - 1)) & all;
  return some == 0 ? all : some;
}

// A joint of a random kind at the present pose of b, its frame at b's own.
ChangeJoint random_change(Prng& random, const Machine& m, int b) {
  const int child = m.tree.reversed(b) ? m.tree.parent(b) : b, parent = m.tree.reversed(b) ? b : m.tree.parent(b);
  const Kind kinds[] = {Kind::revolute, Kind::prismatic, Kind::helical, Kind::cylindrical, Kind::universal,
                        Kind::ball,     Kind::planar,    Kind::free,    Kind::weld};
  const JointSpec spec = oracle::random_joint(random, kinds[random.integer(0, 9 - 1)], {.parameters = false});
  ChangeJoint change;
  change.body = {b};
  const Values q = oracle::random_coordinates(random, spec.kind);  // any q will do: the offset takes up the rest
  change.joint.kind = spec.kind, change.joint.axis = normalized(spec.axis), change.joint.pitch = spec.pitch;
  if (spec.kind == Kind::universal) change.joint.axis2 = normalized(spec.axis2);
  change.q = q;
  // at · motion(q) = present pose of the child in the parent
  oracle::System one;
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

// Condition of the joint-space mass, in directions of length one that the constraints leave: what velocities can be known to.
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

struct Outcome {
  long double difference = 0, gain = 0, carnot = 0;
  double bound = 0;  ///< for the difference: round-off in the state, carried by the condition of the mass matrix
};

// Runs `act` on the machine and compares with the projection onto the constraints that the machine has afterwards.
template <class Act>
Outcome compare(Machine& m, Act act) {
  m.evaluate();
  const Column before = m.velocities();
  act();
  m.evaluate();
  const Dense M = m.masses(), C = m.constraints();
  const Column expected = projected(M, C, before), after = m.velocities();
  const long double scale = std::max<long double>(before.cwiseAbs().maxCoeff(), 1);
  const Column jump = after - before;
  const long double T0 = energy(M, before), T1 = energy(M, after);
  return {(after - expected).cwiseAbs().maxCoeff() / scale, (T1 - T0) / std::max<long double>(T0, 1e-30L),
          std::fabs(T0 - T1 - energy(M, jump)) / std::max<long double>(T0, 1e-30L),
          std::max(1e-10, 10 * 2.2e-16 * condition(M, C))};
}

}  // namespace

TEST_CASE("(28) every change leaves the velocities that a projection in maximal coordinates leaves") {
  Outcome worst;
  int lossy = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    Prng random(seed * 77 + 5);
    oracle::RandomTreeOptions options;
    options.max_bodies = 10;
    options.parameters = false;
    options.several_mechanisms = true;
    options.all_free = seed % 3 == 0;
    Machine m(oracle::random_tree(seed, options).model);
    for (int action = 0; action < 6; ++action) {
      const int b = random.integer(0, m.size() - 1);
      const int what = random.integer(0, 7 - 1);
      INFO("seed ", seed, " action ", action, " what ", what, " body ", b, " kind ",
           std::string(info(m.tree.joint(b).kind).name));
      const Outcome o = compare(m, [&] {
        const int nv = info(m.tree.joint(b).kind).nv;
        switch (what) {
          case 0:
            if (can_break(m.tree, {b})) apply(Break{{b}}, m.tree, m.state, m.work);
            break;
          case 1:
            if (nv > 0) apply(Lock{{b}, mask(random, nv)}, m.tree, m.state, m.work);
            break;
          case 2: apply(Unlock{{b}, ~0u}, m.tree, m.state, m.work); break;
          case 3:
          case 4: apply(random_change(random, m, b), m.tree, m.state, m.work); break;
          case 5:
            if (floats(m.tree, b)) apply(Reroot{{b}}, m.tree, m.state, m.work);
            break;
          default: {
            const int to = random.integer(0, m.size() - 1);
            if (root_of(m.tree, to) == root_of(m.tree, b) || !floats(m.tree, b)) break;
            apply(Join{{b}, {to}}, m.tree, m.state, m.work);
            m.evaluate();
            apply(random_change(random, m, b), m.tree, m.state, m.work);
          }
        }
      });
      CHECK(o.difference < o.bound);
      CHECK(o.gain < 1e-10L);
      CHECK(o.carnot < 1e-10L);
      worst.difference = std::max(worst.difference, o.difference);
      worst.gain = std::max(worst.gain, o.gain);
      worst.carnot = std::max(worst.carnot, o.carnot);
      lossy += o.gain < -1e-6L;
    }
  }
  MESSAGE("largest difference ", static_cast<double>(worst.difference), ", gain ", static_cast<double>(worst.gain), ", Carnot ",
          static_cast<double>(worst.carnot), ", ", lossy, " lossy impacts");
  CHECK(lossy > 200);
}

TEST_CASE("re-rooting changes no pose, velocity or acceleration of any body; nor does the way back") {
  int turned = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Prng random(seed + 900);
    oracle::RandomTreeOptions options;
    options.max_bodies = 12, options.parameters = seed % 2 == 0, options.conservative = true, options.all_free = true;
    options.several_mechanisms = false;
    const Model model = oracle::random_tree(seed, options).model;
    Machine m(model);
    const int root = m.tree.order()[0];
    const int b = random.integer(0, m.size() - 1);
    if (!floats(m.tree, b) || b == root) continue;
    ++turned;
    INFO("seed ", seed, " body ", b);
    // Accelerations by differences along the rates, of order eight.
    const auto accelerations = [](const Machine& at) {
      const auto moved = [&at](double h) {
        Machine other(at.model);
        other.tree = at.tree;
        other.state = at.state;
        const State::Edit edit = other.state.edit();
        for (int i = 0; i < at.tree.nq(); ++i)
          edit.q[static_cast<std::size_t>(i)] += h * at.work.qdot[static_cast<std::size_t>(i)];
        for (int i = 0; i < at.tree.nv(); ++i)
          edit.p[static_cast<std::size_t>(i)] += h * at.work.pdot[static_cast<std::size_t>(i)];
        other.evaluate();
        return other.velocities();
      };
      const double h = 2e-3;
      Column sum = Column::Zero(6 * at.size());
      const long double weights[4] = {4.0L / 5, -1.0L / 5, 4.0L / 105, -1.0L / 280};
      for (int k = 1; k <= 4; ++k) sum += weights[k - 1] * (moved(k * h) - moved(-k * h));
      return Column(sum / h);
    };
    const Column V = m.velocities(), A = accelerations(m);
    apply(Reroot{{b}}, m.tree, m.state, m.work);
    m.evaluate();
    CHECK(root_of(m.tree, root) == b);
    // 10 ε cond(M), M the joint-space mass of the tree as it was: what its momenta can tell of velocities.
    const auto mass = oracle::mass_matrix(oracle::system_of(model), oracle::start_q(model));
    const double bound = std::max(1e-11, 10 * 2.2e-16 * oracle::spectrum(mass).condition());
    CHECK((m.velocities() - V).cwiseAbs().maxCoeff() / std::max<long double>(1, V.cwiseAbs().maxCoeff()) < bound);
    CHECK((accelerations(m) - A).cwiseAbs().maxCoeff() / std::max<long double>(1, A.cwiseAbs().maxCoeff()) < 1e-7);
    apply(Reroot{{root}}, m.tree, m.state, m.work);
    m.evaluate();
    for (int k = 0; k < m.size(); ++k) CHECK_FALSE(m.tree.reversed(k));
    CHECK((m.velocities() - V).cwiseAbs().maxCoeff() / std::max<long double>(1, V.cwiseAbs().maxCoeff()) < bound);
  }
  CHECK(turned > 100);
}

TEST_CASE("a capture does not depend on which partner is re-rooted") {
  int captures = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    Prng random(seed + 4000);
    oracle::RandomTreeOptions options;
    options.max_bodies = 10, options.parameters = false, options.all_free = true;
    const Model model = oracle::random_tree(seed, options).model;
    Machine one(model), other(model);
    const int cut = random.integer(0, one.size() - 1);
    const int a = random.integer(0, one.size() - 1);
    const int b = random.integer(0, one.size() - 1);
    for (Machine* m : {&one, &other}) {
      if (can_break(m->tree, {cut})) apply(Break{{cut}}, m->tree, m->state, m->work);
      m->evaluate();
    }
    if (root_of(one.tree, a) == root_of(one.tree, b)) continue;
    ++captures;
    const auto weld = [](Machine& m, int child, int parent) {
      apply(Join{{child}, {parent}}, m.tree, m.state, m.work);
      m.evaluate();
      ChangeJoint rigid;
      rigid.body = {child};
      rigid.joint.at = inverse(m.pose(parent)) * m.pose(child);
      apply(rigid, m.tree, m.state, m.work);
      m.evaluate();
    };
    const Totals before = totals(one.tree, one.state, one.work);
    weld(one, b, a);
    weld(other, a, b);
    const Column V = one.velocities();
    const double bound = std::max(1e-10, 10 * 2.2e-16 * condition(one.masses(), one.constraints()));
    CHECK((other.velocities() - V).cwiseAbs().maxCoeff() / std::max<long double>(1, V.cwiseAbs().maxCoeff()) < bound);
    const Totals after = totals(one.tree, one.state, one.work);
    const double scale = 1 + norm(before.linear) + norm(before.angular);
    CHECK(norm(after.linear - before.linear) < 1e-12 * scale);
    CHECK(norm(after.angular - before.angular) < 1e-12 * scale);
  }
  CHECK(captures > 30);
}

TEST_CASE("several joints change in one impact: Pb of all from before, whatever the order") {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Prng random(seed + 77);
    oracle::RandomTreeOptions options;
    options.min_bodies = 3, options.max_bodies = 8, options.parameters = false, options.several_mechanisms = false;
    Machine m(oracle::random_tree(seed, options).model);
    const int a = random.integer(0, m.size() - 1);
    const int b = (a + 1) % m.size();
    const ChangeJoint first = random_change(random, m, a), second = random_change(random, m, b);
    const Outcome o = compare(m, [&] {
      const auto before = [&](int k) { return to_user_frame(m.tree.frame(k), articulated_momentum(m.tree, m.state, m.work, k)); };
      const Force<double> Pa = before(a), Pb = before(b);
      apply(first, Pa, m.tree, m.state, m.work);
      apply(second, Pb, m.tree, m.state, m.work);
    });
    INFO("seed ", seed);
    CHECK(o.difference < o.bound);
    CHECK(o.gain < 1e-10L);
  }
}

TEST_CASE("a hundred thousand changes of one free world: momenta drift by round-off alone, memory stays") {
  oracle::RandomTreeOptions options;
  options.min_bodies = 12, options.max_bodies = 12, options.parameters = false, options.all_free = true, options.gravity = false;
  Machine m(oracle::random_tree(11, options).model);
  Prng random(3);
  const Totals start = totals(m.tree, m.state, m.work);
  const double scale = 1 + norm(start.linear) + norm(start.angular);
  const double* storage = m.state.q().data();
  for (int k = 0; k < 100000; ++k) {
    const int b = random.integer(0, m.size() - 1);
    const int nv = info(m.tree.joint(b).kind).nv;
    forward_dynamics(m.tree, m.state, m.work);
    switch (random.integer(0, 4)) {
      case 0:
        if (can_break(m.tree, {b})) apply(Break{{b}}, m.tree, m.state, m.work);
        break;
      case 1:
        if (nv > 0 && m.tree.parent(b) >= 0) apply(Lock{{b}, mask(random, nv)}, m.tree, m.state, m.work);
        break;
      case 2: apply(Unlock{{b}}, m.tree, m.state, m.work); break;
      case 3:
        if (floats(m.tree, b)) apply(Reroot{{b}}, m.tree, m.state, m.work);
        break;
      default: {
        const int to = random.integer(0, m.size() - 1);
        if (root_of(m.tree, to) != root_of(m.tree, b) && floats(m.tree, b)) apply(Join{{b}, {to}}, m.tree, m.state, m.work);
      }
    }
  }
  m.evaluate();
  const Totals end = totals(m.tree, m.state, m.work);
  CHECK(norm(end.linear - start.linear) / scale < 1e-10);
  CHECK(norm(end.angular - start.angular) / scale < 1e-10);
  CHECK(end.kinetic <= start.kinetic * (1 + 1e-9));
  CHECK(m.state.q().data() == storage);
}
