#include <momentree/simulate/action_list.hpp>  // generated from the files in actions/
#include <momentree/simulate/all_actions.hpp>  // generated: includes these files
#include <momentree/simulate/events/action.hpp>

namespace momentree {

std::shared_ptr<ActionBase> make_action(std::string_view key) {
#define MOMENTREE_ACTION(name, Type) \
  if (key == #name) return std::make_shared<actions::Type>();
  MOMENTREE_ACTIONS(MOMENTREE_ACTION)
#undef MOMENTREE_ACTION
  return nullptr;
}

std::vector<std::string> action_keys() {
  return {
#define MOMENTREE_ACTION(name, Type) #name,
      MOMENTREE_ACTIONS(MOMENTREE_ACTION)
#undef MOMENTREE_ACTION
  };
}

Action break_joint(std::string joint) {
  actions::Break action;
  action.name = std::move(joint);
  return action;
}

Action free_joint(std::string joint) {
  actions::Free action;
  action.name = std::move(joint);
  return action;
}

Action change_joint(std::string joint, Kind kind) {
  actions::Change action;
  action.name = std::move(joint);
  action.to.spec.kind = kind;
  return action;
}

Action change_joint(std::string joint, JointSpec to) {
  actions::Change action;
  action.name = std::move(joint);
  action.to = {std::move(to), info(to.kind).axis, info(to.kind).axis2};
  return action;
}

Action lock(std::string joint, std::vector<int> dofs) {
  actions::Lock action;
  action.name = std::move(joint);
  action.dofs = std::move(dofs);
  return action;
}

Action unlock(std::string joint, std::vector<int> dofs) {
  actions::Unlock action;
  action.name = std::move(joint);
  action.dofs = std::move(dofs);
  return action;
}

Action weld(std::string body, std::string to, std::string name) {
  actions::Weld action;
  action.body = std::move(body);
  action.to = std::move(to);
  action.name = std::move(name);
  return action;
}

Action attach(std::string body, std::string to, JointSpec joint, std::optional<Pose> at, std::string name) {
  actions::Attach action;
  action.body = std::move(body);
  action.to = std::move(to);
  action.joint.spec = std::move(joint);
  action.at = at;
  action.name = std::move(name);
  return action;
}

Action impulse(std::string body, Vec3 force, Vec3 torque, Vec3 point) {
  actions::Impulse action;
  action.body = std::move(body);
  action.force = force, action.torque = torque, action.point = point;
  return action;
}

Action set_length(std::string cable, double length) {
  actions::SetLength action;
  action.name = std::move(cable);
  action.length = length;
  return action;
}

Action set_parameters(std::string joint, JointParameters parameters) {
  actions::Set action;
  action.name = std::move(joint);
  action.parameters = std::move(parameters);
  return action;
}

Action reroot(std::string body) {
  actions::Reroot action;
  action.body = std::move(body);
  return action;
}

}  // namespace momentree
