#include <cmath>

#include <doctest/doctest.h>

#include <momentree/joint/kinds.hpp>
#include <momentree/model/model.hpp>

using namespace momentree;

namespace {

// The first problem as "field: what", or an empty string.
std::string problem(const JointSpec& joint) {
  const std::vector<JointProblem> found = check_joint(joint);
  return found.empty() ? "" : found[0].field + ": " + found[0].what;
}

}  // namespace

TEST_CASE("errors in drives, friction, soft stops and strengths name the key") {
  const auto motion = motion_drive(Signal::sine(1, 2));
  CHECK(problem(Revolute{.friction = {2, 0.1}, .drive = motion, .strength = {.force = 3}}).empty());
  CHECK(problem(Revolute{.limits = {.upper = 1, .stiffness = 3, .damping = 0}, .drive = pd_drive({.kp = 1})}).empty());
  CHECK(problem(Ball{.friction = {{1, 2, 3}, 0.1}, .drive = effort_drive({1, 2, 3})}).empty());
  CHECK(problem(Weld{.strength = {.torque = 1}}).empty());

  CHECK(problem(Revolute{.friction = {2, {}}}) == "friction: needs a 'speed', over which it builds up");
  CHECK(problem(Revolute{.friction = {{}, 1}}) == "friction: 'speed' alone defines no friction");
  CHECK(problem(Revolute{.friction = {-2, 1}}) == "friction: 'coulomb' must not be negative");
  CHECK(problem(Ball{.friction = {{1, 2}, 1}}) == "friction: a ball joint has 3 degrees of freedom, but 'coulomb' has 2 numbers");

  CHECK(
      problem(Revolute{.limits = {.upper = 1, .restitution = 0.5, .stiffness = 1}}).starts_with("limits: a stop is hard, with"));
  CHECK(problem(Revolute{.limits = {.upper = 1, .damping = 1}}).starts_with("limits: 'damping' belongs to a soft stop"));
  CHECK(problem(Revolute{.limits = {.upper = 1, .stiffness = 0}}).starts_with("limits: a stop without 'stiffness'"));
  CHECK(problem(Revolute{.limits = {.upper = 1, .stiffness = -1}}) == "limits: 'stiffness' must not be negative");
  CHECK(problem(Revolute{.limits = {.upper = 1, .stiffness = {1, 2}}})
            .starts_with("limits: a revolute joint has 1 degree of freedom, but"));

  CHECK(problem(Universal{.axis = y_axis, .axis2 = z_axis, .drive = effort_drive({1})}) ==
        "drive: one effort for 2 degrees of freedom is ambiguous");
  CHECK(problem(Ball{.drive = pd_drive({.kp = 1})}).starts_with("drive: position control needs coordinates whose rates"));
  CHECK(problem(Revolute{.drive = pd_drive({.target = {1}})}) == "drive: position control needs 'kp' or 'kd'");
  CHECK(problem(Revolute{.drive = pd_drive({.kp = -1})}) == "drive: 'kp' must not be negative");
  CHECK(problem(Revolute{.drive = pd_drive({.kp = 1, .max_effort = NAN})}) == "drive: 'max_effort' must be finite");
  CHECK(problem(Universal{.axis = y_axis, .axis2 = z_axis, .drive = motion})
            .starts_with("drive: a motion needs a joint with one degree of freedom"));
  CHECK(
      problem(Revolute{.effort = 1, .drive = motion}).starts_with("drive: a joint whose motion is prescribed takes the effort"));
  CHECK(
      problem(Revolute{.limits = {.upper = 1}, .drive = motion}).starts_with("drive: a joint whose motion is prescribed can't"));
  JointDrive both;
  both.motion = motion->motion, both.pd.kp = 1;
  CHECK(problem(Revolute{.drive = std::make_shared<const JointDrive>(both)}).starts_with("drive: a joint whose motion is"));

  CHECK(problem(Revolute{.strength = {.force = 0}}) == "strength: must be positive");
  CHECK(problem(Revolute{.strength = {.torque = -1}}) == "strength: must be positive");
}

TEST_CASE("an initial position may be beyond a soft stop, but not beyond a hard one") {
  Model model;
  model.add(
      {.name = "soft", .mass = 1, .inertia = diagonal(1), .joint = Revolute{.limits = {.upper = 1, .stiffness = 9}}, .q = 2});
  CHECK_THROWS_AS(
      model.add({.name = "hard", .mass = 1, .inertia = diagonal(1), .joint = Revolute{.limits = {.upper = 1}}, .q = 2}), Error);
}
