#include <momentree/joint/motion.hpp>

#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>

using namespace momentree;

namespace {

JointSpec example(Kind kind) {
  JointSpec joint;
  joint.kind = kind;
  joint.axis = normalized(Vec3{0.3, -0.8, 0.5});
  joint.axis2 = normalized(Vec3{0.9, 0.2, -0.1});
  joint.pitch = 0.02;
  return joint;
}

Values example_coordinates(const KindInfo& kind) {
  Values q = joint_zero(kind.kind);
  double next = 0.7;
  bool turned = false;
  for (int i = 0; i < kind.nq; ++i) {
    if (kind.q_units[i] != 'n') {
      q[i] = next;
      next = -next + 0.25;
    } else if (!turned) {
      const Quat r = exp_rotation({0.4, -1.1, 0.6});
      q[i] = r.w, q[i + 1] = r.x, q[i + 2] = r.y, q[i + 3] = r.z;
      turned = true;
    }
  }
  return q;
}

double distance(const Pose& a, const Pose& b) {
  return norm(a.position - b.position) + norm(log_rotation(conjugate(a.rotation) * b.rotation));
}

}  // namespace

TEST_CASE("every kind recovers its coordinates from the relative pose that they produce") {
  for (const KindInfo& kind : all_kinds()) {
    CAPTURE(kind.name);
    const JointSpec joint = example(kind.kind);
    const Values q = example_coordinates(kind);
    const Pose motion = joint_motion(joint, q.begin());
    const auto back = joint_coordinates(joint, motion, turns_of(kind.kind, q.begin()));
    REQUIRE(back);
    CHECK(distance(joint_motion(joint, back->begin()), motion) < 1e-14);
    for (int i = 0; i < kind.nq; ++i)
      if (kind.q_units[i] != 'n') CHECK((*back)[i] == doctest::Approx(q[i]).epsilon(1e-13));
    CHECK(distance(joint_motion(joint, joint_zero(kind.kind).begin()), Pose{}) < 1e-15);
  }
}

TEST_CASE("a kind refuses relative poses that it can't represent; a free joint represents all of them") {
  const Pose askew{{0.1, 0.2, 0.3}, normalized(Quat{1, 0.2, -0.3, 0.4})};
  for (const KindInfo& kind : all_kinds())
    CHECK_MESSAGE(joint_coordinates(example(kind.kind), askew, {}).has_value() == (kind.kind == Kind::free), kind.name);
}

TEST_CASE("full turns are kept: the recovered angle is the one nearest to the hint") {
  const JointSpec hinge = example(Kind::revolute);
  const double turns = 0.5 + 6 * std::numbers::pi;
  const auto q = joint_coordinates(hinge, joint_motion(hinge, &turns), {turns});
  REQUIRE(q);
  CHECK((*q)[0] == turns);
  JointSpec screw = example(Kind::helical);
  const auto screwed = joint_coordinates(screw, joint_motion(screw, &turns), {turns});
  REQUIRE(screwed);
  CHECK((*screwed)[0] == doctest::Approx(turns).epsilon(1e-14));
  CHECK_FALSE(joint_coordinates(screw, joint_motion(screw, &turns), {}));  // displaced by three turns more
}

TEST_CASE("both angles of a universal joint are those nearest to the hint") {
  const JointSpec cross = example(Kind::universal);
  const double q[] = {0.4 - 4 * std::numbers::pi, 0.7 + 6 * std::numbers::pi};
  const auto back = joint_coordinates(cross, joint_motion(cross, q), {q[0], q[1] - 3});
  REQUIRE(back);
  for (int i = 0; i < 2; ++i) CHECK((*back)[i] == doctest::Approx(q[i]).epsilon(1e-14));
}

TEST_CASE("the columns of DoFs are derivatives of the relative pose") {
  for (const KindInfo& kind : all_kinds()) {
    CAPTURE(kind.name);
    if (kind.nq != kind.nv) continue;  // kinds with quaternions: laws_test
    const JointSpec joint = example(kind.kind);
    const Values q = example_coordinates(kind);
    const auto E = joint_dofs(joint, q.begin());
    REQUIRE(static_cast<int>(E.size()) == kind.nv);
    const Pose at = joint_motion(joint, q.begin());
    for (int i = 0; i < kind.nv; ++i) {
      Values ahead = q, behind = q;
      const double h = 1e-5;
      ahead[i] += h, behind[i] -= h;
      const Pose a = inverse(at) * joint_motion(joint, ahead.begin()), b = inverse(at) * joint_motion(joint, behind.begin());
      const Vec3 v = (0.5 / h) * (a.position - b.position);
      const Vec3 w = (0.5 / h) * (log_rotation(a.rotation) - log_rotation(b.rotation));
      CHECK(norm(v - E[static_cast<std::size_t>(i)].v) < 1e-9);
      CHECK(norm(w - E[static_cast<std::size_t>(i)].w) < 1e-9);
    }
  }
}
