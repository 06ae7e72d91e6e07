#include <momentree/model/spring.hpp>

#include <algorithm>

#include <momentree/joint/motion.hpp>
#include <momentree/math/unit.hpp>
#include <momentree/model/start.hpp>

namespace momentree {

std::vector<SpringProblem> check_spring(const Spring& spring) {
  std::vector<SpringProblem> problems;
  const auto problem = [&](const char* field, const char* what, const char* hint) { problems.push_back({field, what, hint}); };
  const bool cable = spring.inextensible;
  if (!is_finite(spring.from.point)) problem("from", "the point must be finite", "");
  if (!is_finite(spring.to.point)) problem("to", "the point must be finite", "");
  if (spring.from == spring.to)
    problem("to", "is the same point as 'from'", "it acts along the line between two points");
  else if (spring.from.body == spring.to.body)
    problem("to", "is on the same body as 'from'",
            "a force between two points of one body has no effect: one of them belongs to another body, or to \"ground\"");
  const auto check = [&](const char* field, double value, const char* hint) {
    if (!std::isfinite(value)) problem(field, "must be finite", "");
    if (value < 0) problem(field, "must not be negative", hint);
  };
  check("stiffness", spring.stiffness, "a spring pulls its ends together when it is longer than at rest");
  check("damping", spring.damping, "a damper dissipates energy: it opposes the change of length");
  check(cable ? "length" : "rest", spring.rest.value_or(0), "it is the length at which the spring exerts no force");
  if (!(spring.strength > 0))
    problem("strength", "must be positive", "it breaks when its force exceeds that; without a strength it never breaks");
  if (cable) {
    if (spring.rest == 0.0) problem("length", "must be positive", "a joint holds two points together: a [[loop]] of kind ball");
    if (!(spring.restitution >= 0 && spring.restitution <= 1))
      problem("restitution", "must be from 0 to 1", "0: its ends do not rebound when it becomes taut; 1: no energy is lost");
    if (spring.stiffness != 0 || spring.damping != 0 || spring.tension_only)
      problem("length", "a cable has no stiffness and no damping", "a spring with tension_only is a rope that stretches");
    return problems;
  }
  if (spring.stiffness == 0 && spring.damping == 0)
    problem("stiffness", "neither stiffness nor damping: the spring exerts no force", "for example stiffness = \"1 kN/m\"");
  if (spring.tension_only && spring.stiffness == 0 && spring.damping != 0)
    problem("tension_only", "needs a stiffness", "a damper that only pulls has no length at which it is taut");
  return problems;
}

Vec3 start_place(const std::vector<BodySpec>& bodies, const SpringEnd& end) {
  Vec3 place = end.point;
  for (int b = end.body.index; b >= 0; b = bodies[static_cast<std::size_t>(b)].parent.index) {
    const BodySpec& body = bodies[static_cast<std::size_t>(b)];
    Values q = start_coordinates(body);
    const JointDrive* drive = body.joint.parameters.drive.get();
    if (drive != nullptr && drive->moves()) q[0] = drive->motion.front().at(0).value;
    place = body.at * (joint_motion(body.joint, q.begin()) * (inverse(body.child_at) * place));
  }
  return place;
}

}  // namespace momentree
