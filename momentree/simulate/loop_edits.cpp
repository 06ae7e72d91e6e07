// Loop joints in topology changes.
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/simulate/topology_editor_impl.hpp>

namespace momentree {

JointId TopologyEditor::loop(std::string_view name) const {
  const JointId found{world_.names_.find_joint(name)};
  return is_loop(found) ? found : JointId{-1};
}

const JointParameters* TopologyEditor::parameters(std::string_view name) const {
  if (const JointId found = loop(name); found.index >= 0) return &tree().find_loop(found.index - first_loop)->parameters;
  const int found = joint(name);
  return found < 0 ? nullptr : tree().parameters(tree().carrier(found));
}

ActionResult TopologyEditor::missing(std::string_view name) const {
  if (loop(name).index < 0) return ActionResult::skipped("the joint no longer exists");
  return ActionResult::refused("joint '" + std::string(name) + "' closes a loop, where this action is not supported yet",
                               "break it, or let another joint of the loop be the one that closes it");
}

ActionResult TopologyEditor::close_loop(int body, int to, const JointSpec& spec, const std::optional<Pose>& at) {
  if (!world_.loops_allowed_)
    return ActionResult::refused("joining '" + body_name(body) + "' to '" + body_name(to) +
                                     "' would close a loop, and closed loops are integrated in velocities",
                                 "leave 'variables' out, and use rk4, midpoint, dopri5 or dop853");
  if (world_.find_joint(made_name_) >= 0)
    return ActionResult::refused("there is already a joint '" + made_name_ + "'", "give the event another name");
  if (spec.kind == Kind::free) return ActionResult::skipped("a free joint between them constrains nothing");
  const Pose present = inverse(pose(to)) * pose(body);
  LoopSpec whole;
  whole.name = made_name_, whole.body = {body}, whole.to = {to}, whole.joint = spec;
  whole.at = at ? *at : Pose{present.position, Quat{}};
  whole.child_at = inverse(present) * whole.at;
  for (const BodyProblem& problem : check_loop(whole, world_.model().size()))
    return ActionResult::refused(problem.field + ": " + problem.what, problem.hint);
  MakeLoop change;
  change.loop.body = body, change.loop.to = to;
  change.loop.joint = detail::joint_of(whole);
  change.loop.parameters = spec.parameters;
  const int made = world_.names_.loops_end();
  change.loop.number = made - first_loop;
  world_.names_.add_loop(made, made_name_);
  touch(made);
  carry_out(change, Nature::impact);
  return ActionResult::done();
}

void TopologyEditor::break_loop(JointId loop) {
  touch(loop.index);
  carry_out(BreakLoop{loop}, Nature::workless);
  world_.names_.remove_joint(loop.index);
}

void TopologyEditor::set_loop(JointId loop, const JointParameters& parameters) { carry_out(SetLoop{loop, parameters}, Nature::outside); }

// The part whose root `body` has come off may still be held by a loop: its joint becomes the part's inboard joint.
void TopologyEditor::hold_by_loop(int body) {
  const auto inside = [&](int b) { return b >= 0 && root_of(tree(), {b}).index == body; };
  for (const Loop& each : tree().loops()) {
    if (inside(each.body) == inside(each.to)) continue;
    const Loop loop = each;
    const std::string name = joint_name(loop.id().index);
    const bool reversed = !inside(loop.body);
    const int own = reversed ? loop.to : loop.body, other = reversed ? loop.body : loop.to;
    if (reversed && other < 0) continue;  // the ground is never a child
    evaluate();
    const JointView view = world_.joint(loop.id());
    Attach change{{own}, {other}, loop.joint, {}, reversed};
    for (const double q : view.q) change.q.push_back(q);
    const int number = tree().joint_of(body);
    touch(loop.id().index);
    carry_out(BreakLoop{loop.id(), true}, Nature::workless);
    world_.names_.remove_joint(loop.id().index);
    carry_out(change, Nature::workless);
    world_.names_.name_joint(number, name);
    if (other < 0)
      world_.names_.move_mechanism(body, own);
    else
      world_.names_.name_mechanism(body, {});
    if (other < 0 && world_.names_.mechanism(own) == world_.model()[BodyId{body}].name)
      world_.names_.name_mechanism(own, world_.model()[BodyId{own}].name);
    if (loop.parameters.any()) {
      evaluate();
      carry_out(SetParameters{{number}, loop.parameters}, Nature::workless);
    }
    return;
  }
}

}  // namespace momentree
