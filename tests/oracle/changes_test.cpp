// Topology changes against the projection in maximal coordinates (machine.hpp), and relations between changes.
#include <string>

#include <doctest/doctest.h>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/topology/new_joint.hpp>
#include <tests/oracle/machine.hpp>

using namespace momentree;
using namespace momentree::oracle;

TEST_CASE("(28) every change leaves the velocities that a projection in maximal coordinates leaves") {
  Outcome worst;
  int lossy = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    Prng random(seed * 77 + 5);
    RandomTreeOptions options;
    options.max_bodies = 10;
    options.parameters = false;
    options.several_mechanisms = true;
    options.all_free = seed % 3 == 0;
    Machine m(random_tree(seed, options).model);
    for (int action = 0; action < 6; ++action) {
      const int b = random.integer(0, m.size() - 1);
      const int what = random.integer(0, 7 - 1);
      INFO("seed ", seed, " action ", action, " what ", what, " body ", b, " kind ",
           std::string(info(m.tree.joint(b).kind).name));
      const Outcome o = compare(m, [&] {
        const int nv = info(m.tree.joint(b).kind).nv;
        switch (what) {
          case 0:
            if (can_break(m.tree, m.tree.inboard_joint({b})))
              apply(Break{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace);
            break;
          case 1:
            if (nv > 0) apply(Lock{m.tree.inboard_joint({b}), some_dofs(random, nv)}, m.tree, m.state, m.workspace);
            break;
          case 2: apply(Unlock{m.tree.inboard_joint({b}), ~0u}, m.tree, m.state, m.workspace); break;
          case 3:
          case 4: apply(random_change(random, m, b), m.tree, m.state, m.workspace); break;
          case 5:
            if (floats(m.tree, {b})) apply(Reroot{{b}}, m.tree, m.state, m.workspace);
            break;
          default: {
            const int to = random.integer(0, m.size() - 1);
            if (root_of(m.tree, {to}).index == root_of(m.tree, {b}).index || !floats(m.tree, {b})) break;
            apply(Join{{b}, {to}}, m.tree, m.state, m.workspace);
            m.evaluate();
            const auto direction = random.chance(0.5) ? ChangeJoint::Direction::reversed : ChangeJoint::Direction::declared;
            apply(random_change(random, m, b, direction), m.tree, m.state, m.workspace);
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

TEST_CASE("re-rooting and its reversal change no pose, velocity or acceleration of any body") {
  int turned = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Prng random(seed + 900);
    RandomTreeOptions options;
    options.max_bodies = 12, options.parameters = seed % 2 == 0, options.conservative = true, options.all_free = true;
    options.several_mechanisms = false;
    const Model model = random_tree(seed, options).model;
    Machine m(model);
    const int root = m.tree.order()[0];
    const int b = random.integer(0, m.size() - 1);
    if (!floats(m.tree, {b}) || b == root) continue;
    ++turned;
    INFO("seed ", seed, " body ", b);
    // Of origins and attitudes; and the wrenches of all joints except free ones, on the declared child.
    const auto accelerations = [](Machine& at) {
      accelerate(at.tree, at.state, at.workspace);
      Column A(6 * at.size());
      for (int k = 0; k < at.size(); ++k) {
        const BodyAcceleration a = body_acceleration(at.tree, at.state, at.workspace, BodyId{k});
        A.segment(6 * k, 6) << a.linear.x, a.linear.y, a.linear.z, a.angular.x, a.angular.y, a.angular.z;
      }
      return A;
    };
    const auto wrenches = [](const Machine& at) {
      Column W = Column::Zero(6 * at.size());
      for (int k = 0; k < at.size(); ++k) {
        const Force<double> f = as_force(reaction(at.tree, at.state, at.workspace, at.tree.inboard_joint({k})));
        if (!is_detached(at.tree, k) && at.tree.parent(k) >= 0)
          W.segment(6 * at.tree.joint_of(k), 6) << f.l.x, f.l.y, f.l.z, f.h.x, f.h.y, f.h.z;
      }
      return W;
    };
    for (int k = 0; k < m.size(); ++k) {  // some joints are locked
      const int nv = info(m.tree.joint(k).kind).nv;
      if (nv == 0 || m.tree.parent(k) < 0 || random.chance(0.8)) continue;
      apply(Lock{m.tree.inboard_joint({k}), some_dofs(random, nv)}, m.tree, m.state, m.workspace);
      m.evaluate();
    }
    const Column V = m.velocities(), A = accelerations(m), W = wrenches(m);
    apply(Reroot{{b}}, m.tree, m.state, m.workspace);
    m.evaluate();
    CHECK(root_of(m.tree, {root}).index == b);
    // 10 ε cond(M), M the joint-space mass of the tree before: the accuracy to which momenta determine velocities.
    const auto mass = mass_matrix(system_of(model), start_q(model));
    const double bound = std::max(1e-11, 10 * 2.2e-16 * spectrum(mass).condition());
    CHECK((m.velocities() - V).cwiseAbs().maxCoeff() / std::max<long double>(1, V.cwiseAbs().maxCoeff()) < bound);
    // Accelerations depend on velocities quadratically.
    const long double whirl = 1 + A.cwiseAbs().maxCoeff() + V.cwiseAbs2().maxCoeff();
    CHECK((accelerations(m) - A).cwiseAbs().maxCoeff() / whirl < bound);
    CHECK((wrenches(m) - W).cwiseAbs().maxCoeff() / std::max<long double>(whirl, W.cwiseAbs().maxCoeff()) < bound);
    apply(Reroot{{root}}, m.tree, m.state, m.workspace);
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
    RandomTreeOptions options;
    options.max_bodies = 10, options.parameters = false, options.all_free = true;
    const Model model = random_tree(seed, options).model;
    Machine one(model), other(model);
    const int cut = random.integer(0, one.size() - 1);
    const int a = random.integer(0, one.size() - 1);
    const int b = random.integer(0, one.size() - 1);
    for (Machine* m : {&one, &other}) {
      if (can_break(m->tree, m->tree.inboard_joint({cut})))
        apply(Break{m->tree.inboard_joint({cut})}, m->tree, m->state, m->workspace);
      m->evaluate();
    }
    if (root_of(one.tree, {a}).index == root_of(one.tree, {b}).index) continue;
    ++captures;
    const auto weld = [](Machine& m, int child, int parent) {
      apply(Join{{child}, {parent}}, m.tree, m.state, m.workspace);
      m.evaluate();
      ChangeJoint rigid;
      rigid.joint = m.tree.inboard_joint({child});
      rigid.to.at = inverse(m.pose(parent)) * m.pose(child);
      apply(rigid, m.tree, m.state, m.workspace);
      m.evaluate();
    };
    const Totals before = totals(one.tree, one.state, one.workspace);
    weld(one, b, a);
    weld(other, a, b);
    const Column V = one.velocities();
    const double bound = std::max(1e-10, 10 * 2.2e-16 * condition(one.masses(), one.constraints()));
    CHECK((other.velocities() - V).cwiseAbs().maxCoeff() / std::max<long double>(1, V.cwiseAbs().maxCoeff()) < bound);
    const Totals after = totals(one.tree, one.state, one.workspace);
    const double scale = 1 + norm(before.linear) + norm(before.angular);
    CHECK(norm(after.linear - before.linear) < 1e-12 * scale);
    CHECK(norm(after.angular - before.angular) < 1e-12 * scale);
  }
  CHECK(captures > 30);
}

TEST_CASE("an attached joint is the same with its declared child on either side: inboard or outboard") {
  int attached = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Prng random(seed + 31000);
    RandomTreeOptions options;
    options.max_bodies = 10, options.parameters = false, options.all_free = true;
    Machine one(random_tree(seed, options).model);
    const int cut = random.integer(0, one.size() - 1);
    const int parent = random.integer(0, one.size() - 1);
    const int child = random.integer(0, one.size() - 1);
    if (can_break(one.tree, one.tree.inboard_joint({cut})))
      apply(Break{one.tree.inboard_joint({cut})}, one.tree, one.state, one.workspace);
    one.evaluate();
    if (root_of(one.tree, {parent}).index == root_of(one.tree, {child}).index) continue;
    ++attached;
    Machine other(one.model);
    other.tree = one.tree, other.state = one.state;
    other.evaluate();
    INFO("seed ", seed);
    Prng same = random;
    const auto attach = [](Machine& m, Prng& draw, int body, int to, ChangeJoint::Direction direction) {
      apply(Join{{body}, {to}}, m.tree, m.state, m.workspace);
      m.evaluate();
      const Outcome o = compare(m, [&] { apply(random_change(draw, m, body, direction), m.tree, m.state, m.workspace); });
      CHECK(o.difference < o.bound);
      CHECK(o.gain < 1e-10L);
      CHECK(o.carnot < 1e-10L);
      return o.bound;
    };
    double bound = attach(one, random, child, parent, ChangeJoint::Direction::declared);
    bound = std::max(bound, attach(other, same, parent, child, ChangeJoint::Direction::reversed));
    CHECK(one.tree.joint(child).kind == other.tree.joint(parent).kind);
    CHECK_FALSE(one.tree.reversed(child));
    CHECK(other.tree.reversed(parent));
    const Column V = one.velocities();
    CHECK((other.velocities() - V).cwiseAbs().maxCoeff() / std::max<long double>(1, V.cwiseAbs().maxCoeff()) < bound);
    // The same coordinates and rates: q and u belong to the joint, not to the body that it carries.
    for (int i = 0; i < info(one.tree.joint(child).kind).nv; ++i) {
      const double u = one.workspace.v[static_cast<std::size_t>(one.tree.first_p(child) + i)];
      CHECK(std::fabs(other.workspace.v[static_cast<std::size_t>(other.tree.first_p(parent) + i)] - u) <
            bound * (1 + std::fabs(u)) * 10);
    }
  }
  CHECK(attached > 50);
}

TEST_CASE("Attach equals Join and ChangeJoint, and the projection, also for the ground") {
  int attached = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Prng random(seed + 52000);
    RandomTreeOptions options;
    options.max_bodies = 10, options.parameters = false, options.all_free = seed % 2 == 0;
    Machine one(random_tree(seed, options).model);
    for (int k = 0; k < 2; ++k) {
      const int cut = random.integer(0, one.size() - 1);
      if (can_break(one.tree, one.tree.inboard_joint({cut})))
        apply(Break{one.tree.inboard_joint({cut})}, one.tree, one.state, one.workspace);
      one.evaluate();
    }
    const int b = random.integer(0, one.size() - 1);
    const int to = random.integer(-1, one.size() - 1);
    if (!floats(one.tree, {b}) || (to >= 0 && root_of(one.tree, {b}).index == root_of(one.tree, {to}).index)) continue;
    ++attached;
    INFO("seed ", seed, " ", b, " to ", to);
    const Attach attach = random_attach(random, one, b, to);
    Machine other(one.model);
    other.tree = one.tree, other.state = one.state;
    other.evaluate();
    const Outcome o = compare(one, [&] { apply(attach, one.tree, one.state, one.workspace); });
    CHECK(o.difference < o.bound);
    CHECK(o.gain < 1e-10L);
    CHECK(o.carnot < 1e-10L);
    apply(Join{{b}, {to}}, other.tree, other.state, other.workspace);
    other.evaluate();
    const auto direction = attach.reversed ? ChangeJoint::Direction::reversed : ChangeJoint::Direction::declared;
    apply(ChangeJoint{other.tree.inboard_joint({b}), attach.joint, attach.q, direction}, other.tree, other.state,
          other.workspace);
    other.evaluate();
    const Column V = one.velocities();
    CHECK((other.velocities() - V).cwiseAbs().maxCoeff() / std::max<long double>(1, V.cwiseAbs().maxCoeff()) < o.bound);
  }
  CHECK(attached > 60);
}

TEST_CASE("several joints change in one impact, from the momenta before it, whatever the order") {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Prng random(seed + 77);
    RandomTreeOptions options;
    options.min_bodies = 3, options.max_bodies = 8, options.parameters = false, options.several_mechanisms = false;
    Machine m(random_tree(seed, options).model);
    const int a = random.integer(0, m.size() - 1);
    const int b = (a + 1) % m.size();
    const ChangeJoint first = random_change(random, m, a), second = random_change(random, m, b);
    const Outcome o = compare(m, [&] {
      const auto before = [&](int k) {
        return to_user_frame(m.tree.frame(k), articulated_momentum(m.tree, m.state, m.workspace, k));
      };
      const Force<double> Pa = before(a), Pb = before(b);
      apply(first, Pa, m.tree, m.state, m.workspace);
      apply(second, Pb, m.tree, m.state, m.workspace);
    });
    INFO("seed ", seed);
    CHECK(o.difference < o.bound);
    CHECK(o.gain < 1e-10L);
  }
}

TEST_CASE("a hundred thousand changes of one free world: momenta drift only by round-off, memory does not grow") {
  RandomTreeOptions options;
  options.min_bodies = 12, options.max_bodies = 12, options.parameters = false, options.all_free = true, options.gravity = false;
  Machine m(random_tree(11, options).model);
  Prng random(3);
  const Totals start = totals(m.tree, m.state, m.workspace);
  const double scale = 1 + norm(start.linear) + norm(start.angular);
  const double* storage = m.state.q().data();
  for (int k = 0; k < 100000; ++k) {
    const int b = random.integer(0, m.size() - 1);
    const int nv = info(m.tree.joint(b).kind).nv;
    forward_dynamics(m.tree, m.state, m.workspace);
    switch (random.integer(0, 4)) {
      case 0:
        if (can_break(m.tree, m.tree.inboard_joint({b}))) apply(Break{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace);
        break;
      case 1:
        if (nv > 0 && m.tree.parent(b) >= 0)
          apply(Lock{m.tree.inboard_joint({b}), some_dofs(random, nv)}, m.tree, m.state, m.workspace);
        break;
      case 2: apply(Unlock{m.tree.inboard_joint({b})}, m.tree, m.state, m.workspace); break;
      case 3:
        if (floats(m.tree, {b})) apply(Reroot{{b}}, m.tree, m.state, m.workspace);
        break;
      default: {
        const int to = random.integer(0, m.size() - 1);
        if (root_of(m.tree, {to}).index != root_of(m.tree, {b}).index && floats(m.tree, {b}))
          apply(Join{{b}, {to}}, m.tree, m.state, m.workspace);
      }
    }
  }
  m.evaluate();
  const Totals end = totals(m.tree, m.state, m.workspace);
  CHECK(norm(end.linear - start.linear) / scale < 1e-10);
  CHECK(norm(end.angular - start.angular) / scale < 1e-10);
  CHECK(end.kinetic <= start.kinetic * (1 + 1e-9));
  CHECK(m.state.q().data() == storage);
}
