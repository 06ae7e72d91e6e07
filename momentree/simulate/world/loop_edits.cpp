// Loop joints in topology changes.
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/simulate/assembly.hpp>
#include <momentree/simulate/world/topology_editor_impl.hpp>

namespace momentree {

const Loop& TopologyEditor::loop_of(int joint) const {
  const Loop* const found = tree().loops().find({joint});
  MT_REQUIRE(found != nullptr, "the loop joint is in the world");
  return *found;
}

const JointParameters* TopologyEditor::parameters(int joint) const {
  return is_loop({joint}) ? &loop_of(joint).parameters : tree().parameters(tree().carrier(joint));
}

ActionResult TopologyEditor::supports(int joint, const JointParameters& parameters) const {
  if (!is_loop({joint})) return ActionResult::done();
  const Loop& now = loop_of(joint);
  LoopSpec spec;
  spec.name = joint_name(joint), spec.body = {now.body}, spec.to = {now.to};
  spec.joint = spec_of(now.joint);
  if (spec.joint.kind == Kind::free) spec.joint.kind = Kind::weld;  // a loop joint may become free, not begin so
  spec.joint.parameters = parameters;
  for (const BodyProblem& problem : check_loop(spec, tree().bodies()))
    return ActionResult::refused(problem.field + ": " + problem.what, problem.hint);
  return ActionResult::done();
}

ActionResult TopologyEditor::can_move() const {
  if (dry_run_) return ActionResult::done();
  const std::optional<Error> error = conflicting_motions(tree(), edit_.names(), edit_.state());
  return error ? ActionResult::refused(error->where + ": " + error->problem, error->hint) : ActionResult::done();
}

Turns TopologyEditor::turns_of_loop(int joint) const {
  const auto place = static_cast<std::size_t>(tree().loops().place({joint}));
  const std::vector<Turns>& turns = edit_.state().turns();
  return place < turns.size() ? turns[place] : Turns{};
}

ActionResult TopologyEditor::close_loop(int body, int to, const JointSpec& spec, const std::optional<Pose>& at) {
  if (std::optional<ActionResult> taken = name_taken(body, to)) return *taken;
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
  const int made = edit_.names().loops_end();
  change.loop.number = made - first_loop;
  edit_.names().add_loop(made, made_name_);
  touch(made);
  carry_out(change, Nature::impact);
  if (spec.parameters.any()) {  // what a stretched spring stores comes from outside
    const JointParameters parameters = begun(made, spec.parameters);
    const ActionResult follows = can_follow(made, parameters);
    if (follows.outcome != ActionResult::Outcome::done) return follows;
    set(made, parameters);
  }
  return ActionResult::done();
}

void TopologyEditor::break_loop(JointId loop) {
  touch(loop.index);
  carry_out(BreakLoop{loop}, Nature::workless);
  edit_.names().remove_joint(loop.index);
}

// A prescribed motion that a lock has suspended imposes its speed when it resumes.
void TopologyEditor::lock_loop(int joint, unsigned locked) {
  const Loop& loop = loop_of(joint);
  const bool locks = (locked & ~loop.joint.locked) != 0;
  const bool resumes = locked == 0 && loop.parameters.drive != nullptr && loop.parameters.drive->moves();
  const Values now = coordinates(joint);
  SetLoop change{{joint}, loop.joint, loop.parameters, loop.held, turns_of(loop.joint.kind, now.begin()), locks || resumes};
  if (change.held.size() != now.size()) change.held = now;
  for (int i = 0; i < now.size() && now.size() == info(loop.joint.kind).nv; ++i)  // what was locked keeps its place
    if ((loop.joint.locked >> i & 1u) == 0) change.held[i] = now[i];
  const bool whole = loop.joint.locked + 1 == 1u << info(loop.joint.kind).nv;
  if (now.size() != info(loop.joint.kind).nv && !whole) change.held = now;
  change.to.locked = locked;
  carry_out(change, locks ? Nature::impact : resumes ? Nature::outside : Nature::workless);
}

void TopologyEditor::change_loop(int joint, const JointPlan& plan, bool impact) {
  const Loop& loop = loop_of(joint);
  SetLoop change{{joint}, plan.joint, {}, {}, {}, impact, plan.keeps_parameters};
  change.to.parameters = -1;
  if (plan.keeps_parameters) change.parameters = loop.parameters;
  change.turns = turns_of(plan.joint.kind, plan.q.begin());
  carry_out(change, impact ? Nature::impact : Nature::workless);
}

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
    if (loop.joint.kind == Kind::free) continue;  // it holds nothing
    for (const double q : view.q) change.q.push_back(q);
    const int number = tree().joint_of(body);
    touch(loop.id().index);
    carry_out(BreakLoop{loop.id(), true}, Nature::workless);
    edit_.names().remove_joint(loop.id().index);
    carry_out(change, Nature::workless);
    edit_.names().name_joint(number, name);
    for (ActiveLimit& limit : edit_.constraints().active_limits)
      if (limit.joint == loop.id().index) limit.joint = number;
    if (other < 0)
      edit_.names().move_mechanism(body, own);
    else
      edit_.names().name_mechanism(body, {});
    if (other < 0 && edit_.names().mechanism(own) == world_.model()[BodyId{body}].name)
      edit_.names().name_mechanism(own, world_.model()[BodyId{own}].name);
    if (loop.parameters.any()) {
      evaluate();
      carry_out(SetParameters{{number}, loop.parameters}, Nature::workless);
    }
    return;
  }
}

}  // namespace momentree
