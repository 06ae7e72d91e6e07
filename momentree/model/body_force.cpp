#include <momentree/model/body_force.hpp>

#include <cmath>

namespace momentree {

namespace {

// Tables and sines are checked for finite numbers when they are made.
bool finite(const std::array<Signal, 3>& signals) {
  for (const Signal& s : signals)
    if (!std::isfinite(s.offset())) return false;
  return true;
}

}  // namespace

std::vector<ForceProblem> check_force(const BodyForce& force) {
  std::vector<ForceProblem> problems;
  if (!std::isfinite(force.point.x) || !std::isfinite(force.point.y) || !std::isfinite(force.point.z))
    problems.push_back({"point", "must be finite", ""});
  if (!finite(force.force)) problems.push_back({"force", "must be finite", ""});
  if (!finite(force.torque)) problems.push_back({"torque", "must be finite", ""});
  const Drag& drag = force.drag;
  for (const auto& [name, value] : {std::pair{"linear", drag.linear}, {"quadratic", drag.quadratic}, {"area", drag.area}}) {
    if (!std::isfinite(value)) problems.push_back({"drag", std::string("'") + name + "' must be finite", ""});
    if (value < 0)
      problems.push_back(
          {"drag", std::string("'") + name + "' must not be negative", "drag dissipates energy: it opposes the velocity"});
  }
  return problems;
}

}  // namespace momentree
