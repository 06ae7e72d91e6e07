#include <momentree/simulate/actions/change.hpp>

#include <cmath>

#include <momentree/joint/motion.hpp>

namespace momentree::actions {

namespace {

double size(const Motion<double>& m) { return std::sqrt(dot(m.v, m.v) + dot(m.w, m.w)); }

// Whether `outer` spans all motions in `inner` (Gram–Schmidt; two passes are enough).
bool spans(std::vector<Motion<double>> outer, std::vector<Motion<double>> inner) {
  std::vector<Motion<double>> basis;
  const auto remove = [&basis](Motion<double>& m) {
    for (int pass = 0; pass < 2; ++pass) {
      for (const Motion<double>& e : basis) {
        const double along = dot(e.v, m.v) + dot(e.w, m.w);
        m.v -= along * e.v, m.w -= along * e.w;
      }
    }
  };
  for (Motion<double>& m : outer) {
    const double length = size(m);
    remove(m);
    if (size(m) > 1e-9 * length) basis.push_back({(1 / size(m)) * m.v, (1 / size(m)) * m.w});
  }
  for (Motion<double>& m : inner) {
    const double length = size(m);
    remove(m);
    if (size(m) > 1e-9 * length) return false;
  }
  return true;
}

// The present direction of a joint axis in the declared child's axes.
Vec3 axis_in_child(const Joint& joint, const Pose& motion) {
  const Vec3 turned = transpose_times(rotation_matrix(motion.rotation), joint.axis);
  return rotation_matrix(joint.child_at.rotation) * turned;
}

}  // namespace

ActionResult Change::plan(TopologyEditor& editor, JointPlan& plan) const {
  const int number = editor.joint(name);
  if (number < 0) return ActionResult::skipped(joint_is_gone);
  const Joint old = editor.declared(number);
  const Values q = editor.coordinates(number);
  const KindInfo &before = info(old.kind), &now = info(to.spec.kind);
  JointSpec spec = to.spec;
  const Pose motion = joint_motion(spec_of(old), q.begin());
  const bool placed = to.axis_given || to.axis2_given;
  const auto lacks = [&](const char* what) {
    return ActionResult::refused(
        "a " + std::string(before.name) + " joint has no " + what + " for the " + now.name + " to take over",
        std::string("give ") + what + ", in the child's axes");
  };
  if (now.axis && !to.axis_given && !before.axis) return lacks("axis");
  if (now.axis2 && !to.axis2_given && !before.axis2) return lacks("axis2");
  if (now.axis && !to.axis_given) spec.axis = placed ? axis_in_child(old, motion) : old.axis;
  if (now.axis2 && !to.axis2_given) spec.axis2 = placed ? rotation_matrix(old.child_at.rotation) * old.axis2 : old.axis2;
  for (const JointProblem& problem : check_joint(spec))
    return ActionResult::refused(problem.field + ": " + problem.what, problem.hint);
  if (now.axis) spec.axis = normalized(spec.axis);
  if (now.axis2) spec.axis2 = normalized(spec.axis2);

  plan.joint.kind = spec.kind, plan.joint.axis = spec.axis, plan.joint.axis2 = spec.axis2, plan.joint.pitch = spec.pitch;
  if (placed) {
    plan.joint.at = editor.joint_pose(number);
    plan.q = joint_zero(spec.kind);
    return editor.is_within(plan.q, spec.parameters.limits, true);
  }
  plan.joint.at = old.at, plan.joint.child_at = old.child_at;
  if (old.kind == spec.kind && (!now.pitch || old.pitch == spec.pitch)) {
    if (editor.locked(number) == 0) return ActionResult::skipped("it is already that joint");
    const JointParameters* own = editor.parameters(number);
    if (own != nullptr && own->drive != nullptr && own->drive->moves())
      return ActionResult::refused("its prescribed motion is suspended by a lock", "unlock it instead");
    plan.joint.parameters = old.parameters, plan.joint.function = old.function;
    plan.q = q, plan.keeps_parameters = true;
  } else if (const auto kept = joint_coordinates(spec, motion, turns_of(old.kind, q.begin()))) {
    plan.q = *kept;
  } else {
    plan.joint.at = old.at * motion;
    plan.q = joint_zero(spec.kind);
  }
  return editor.is_within(plan.q, spec.parameters.limits);
}

ActionPhase Change::phase(TopologyEditor& editor) const {
  JointPlan found;
  if (plan(editor, found).outcome != ActionResult::Outcome::done) return ActionPhase::release;  // refused in prepare() or apply()
  const int number = editor.joint(name);
  const bool frees = spans(editor.dofs(found.joint, found.q), editor.dofs(editor.declared(number), editor.coordinates(number)));
  return frees ? ActionPhase::release : ActionPhase::impact;
}

// The old constraints take no part in the impact, in whatever order its changes are carried out: they are released first.
ActionResult Change::prepare(TopologyEditor& editor) const {
  JointPlan found;
  const ActionResult result = plan(editor, found);
  if (result.outcome != ActionResult::Outcome::done) return result;
  const int number = editor.joint(name);
  editor.plans[this] = found;
  editor.loosened.insert(number);
  JointPlan loose;
  loose.joint.kind = Kind::free;
  const Joint old = editor.declared(number);
  loose.joint.at = old.at, loose.joint.child_at = old.child_at;
  JointSpec six;
  six.kind = Kind::free;
  loose.q = *joint_coordinates(six, joint_motion(spec_of(old), editor.coordinates(number).begin()), {});
  editor.loosen(number, loose);
  return result;
}

ActionResult Change::apply(TopologyEditor& editor) const {
  JointPlan found;
  const int number = editor.joint(name);
  const auto prepared = editor.plans.find(this);
  if (prepared != editor.plans.end()) {
    found = prepared->second;
    editor.loosened.erase(number);
  } else {
    const ActionResult result = plan(editor, found);
    if (result.outcome != ActionResult::Outcome::done) return result;
  }
  if (prepared == editor.plans.end() && phase(editor) == ActionPhase::release)
    editor.loosen(number, found);
  else
    editor.become(number, found);
  const JointParameters parameters = editor.begun(number, to.spec.parameters);
  if (ActionResult result = editor.supports(number, parameters); result.outcome != ActionResult::Outcome::done) return result;
  const ActionResult follows = editor.can_follow(number, parameters);
  if (follows.outcome != ActionResult::Outcome::done) return follows;
  if (!(parameters == JointParameters{})) editor.set(number, parameters);
  return ActionResult::done();
}

}  // namespace momentree::actions
