#include <momentree/model/coupling.hpp>

#include <momentree/model/forced_stop.hpp>
#include <momentree/model/model.hpp>

namespace momentree {

std::vector<CouplingProblem> check_coupling(const Coupling& coupling, const Model& model) {
  std::vector<CouplingProblem> problems;
  const auto problem = [&](const char* field, std::string what, std::string hint) {
    problems.push_back({field, std::move(what), std::move(hint)});
  };
  const auto known = [&model](JointId joint) { return joint.index >= 0 && joint.index < model.size(); };
  const auto check = [&](const char* field, JointId joint) {
    if (is_loop(joint))
      return problem(field, "a joint that closes a loop can't be coupled",
                     "let another joint of the loop be the one that closes it");
    if (!known(joint)) return problem(field, "is not a joint of this model", "give the joint of a body that was added before");
    const BodySpec& spec = model[joint];
    if (info(spec.joint.kind).nv != 1)
      problem(field,
              "joint '" + spec.joint_name + "' is " + std::string(info(spec.joint.kind).name) +
                  ", and does not have one degree of freedom",
              "couple revolute, prismatic and helical joints");
  };
  check("joint", coupling.joint);
  if (coupling.leads()) check("follows", coupling.follows);
  if (known(coupling.joint) && coupling.joint == coupling.follows)
    problem("follows", "a joint cannot follow itself", "name another one of the same world");
  if (!std::isfinite(coupling.multiplier)) problem("multiplier", "must be finite", "");
  if (!std::isfinite(coupling.offset)) problem("offset", "must be finite", "");
  for (const double a : coupling.higher)
    if (!std::isfinite(a)) problem("polynomial", "must be finite", "");
  if (!problems.empty()) return problems;
  const auto prescribed = [&model](JointId joint) {
    const auto& drive = model[joint].joint.parameters.drive;
    return drive != nullptr && drive->moves();
  };
  if (prescribed(coupling.joint) && (!coupling.leads() || prescribed(coupling.follows)))
    problem(
        "joint",
        coupling.leads() ? "the motions of both joints are prescribed" : "the motion of the joint is prescribed, and it is held",
        "prescribe the motion of one of them, and let the other one follow");
  std::vector<Coupling> all = model.couplings();
  all.push_back(coupling);
  if (const auto forced = forced_stop(all, [&](JointId joint) { return &model[joint].joint.parameters; }))
    problems.push_back(problem_of(*forced, [&](JointId joint) { return model[joint].joint_name; }));
  return problems;
}

std::string coupling_text(const Coupling& coupling, const std::string& joint, const std::string& follows) {
  return coupling.leads() ? "'" + joint + "' with '" + follows + "'" : "'" + joint + "' at its place";
}

}  // namespace momentree
