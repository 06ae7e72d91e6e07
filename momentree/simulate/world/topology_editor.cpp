#include <momentree/simulate/world/topology_editor_impl.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <momentree/dynamics/momentum.hpp>
#include <momentree/dynamics/user_frames.hpp>
#include <momentree/joint/motion.hpp>
#include <momentree/simulate/arguments.hpp>

namespace momentree {

namespace {
constexpr double motion_tolerance = 1e-6;  // the greatest distance of a joint from the start of its motion (rad, m)
}  // namespace

TopologyEditor::TopologyEditor(World& world, bool dry_run) : world_(world), edit_(world), dry_run_(dry_run) {}

void TopologyEditor::begin(Event& event, std::string made_name) {
  event_ = &event;
  made_name_ = std::move(made_name);
}

int TopologyEditor::body(std::string_view name) const {
  if (name == "ground") return -1;
  if (!world_.model().has_body(name)) return -2;
  const BodyId body = world_.model().body(name);
  return world_.alive(body) ? body.index : -2;
}

std::string TopologyEditor::body_name(int body) const { return world_.model().body_name({body}); }
std::string TopologyEditor::mechanism_of(int body) const { return edit_.names().mechanism(root_of(tree(), {body}).index); }

Values TopologyEditor::coordinates(int joint) const {
  if (is_loop({joint})) {
    Values q;
    for (const double x : world_.joint({joint}).q) q.push_back(x);
    return q;
  }
  const int b = tree().carrier(joint);
  Values q;
  for (int i = 0; i < info(tree().joint(b).kind).nq; ++i)
    q.push_back(edit_.state().q()[static_cast<std::size_t>(tree().first_q(b) + i)]);
  return q;
}

Pose TopologyEditor::pose(int body) {
  if (body < 0) return {};
  evaluate();
  return user_pose(tree(), locate_body(tree(), edit_.state(), edit_.workspace(), body), body);
}

Pose TopologyEditor::joint_pose(int joint) {
  if (is_loop({joint})) {
    const Loop& loop = loop_of(joint);
    return inverse(pose(loop.to)) * pose(loop.body);
  }
  const int b = tree().carrier(joint);
  const Pose outer = pose(tree().parent(b)), own = pose(b);
  return tree().reversed(b) ? inverse(own) * outer : inverse(outer) * own;
}

Motion<double> seen_from_child(const Joint& joint, const Motion<double>& dof) {
  const Mat3 R = rotation_matrix(joint.child_at.rotation);
  const Vec3 w = R * dof.w;
  return {R * dof.v + cross(joint.child_at.position, w), w};
}

std::vector<Motion<double>> TopologyEditor::dofs(const Joint& joint, const Values& q) const {
  std::vector<Motion<double>> all;
  const std::vector<Motion<double>> own = joint_dofs(spec_of(joint), q.begin());
  for (std::size_t i = 0; i < own.size(); ++i)
    if ((joint.locked >> i & 1u) == 0) all.push_back(seen_from_child(joint, own[i]));
  return all;
}

// Work done by prescribed motions in the last impact to keep their velocity: impulse along the DoF times its velocity. Pb before
// the impact is in before_.
double TopologyEditor::work_of_motions() {
  double work = 0;
  if (!tree().joints_with().motions.empty()) locate_bodies(tree(), edit_.state(), edit_.workspace());
  for (const int b : tree().joints_with().motions) {
    const Force<double>&before = before_[static_cast<std::size_t>(b)],
          after = to_user_frame(tree().frame(b), articulated_momentum(tree(), edit_.state(), edit_.workspace(), b));
    Force<double> through{after.l - before.l, after.h - before.h};
    for (std::size_t i = 0; i < loop_impulses_now_.size(); ++i) {  // contained in Pb, but no joint of the tree transmitted them
      const Loop& loop = tree().loops()[i];
      const Force<double> W = impulse_about(b, loop_impulses_now_[i]);
      const auto inboard = [&](int end) {
        while (end >= 0 && end != b) end = tree().parent(end);
        return end == b;
      };
      if (inboard(loop.body)) through = through - W;
      if (inboard(loop.to)) through += W;
    }
    double along[6];
    project(tree(), b, joint_state(tree(), edit_.state(), edit_.workspace(), b), to_kernel_frame(tree().frame(b), through),
            along);
    for (const CouplingImpulse& given : coupling_impulses_now_) {
      const CouplingEnds& ends = tree().loops().links[static_cast<std::size_t>(coupling_place(tree(), given.coupling))].ends;
      along[0] -= (ends.joint == b ? given.joint : 0.0) + (ends.follows == b ? given.follows : 0.0);
    }
    work += along[0] * edit_.workspace().v[static_cast<std::size_t>(tree().first_p(b))];
  }
  for (const LoopImpulse& loop : loop_impulses_now_) work += loop.motion * loop.motion_rate;
  return work;
}

// None of the actions may act on a part that broke off instead.
int TopologyEditor::joint(std::string_view name) const {
  const int found = edit_.names().find_joint(name);
  if (found < 0 || loosened.contains(found)) return found;
  return is_broken(world_, name, {found}) ? -1 : found;
}

ActionResult TopologyEditor::is_within(const Values& q, const JointLimits& limits, bool known) const {
  constexpr double rounding = 1e-6;  // of 1 + |limit|: stops may act a little beyond them
  if ((dry_run_ && !known) || !limits.hard()) return ActionResult::done();
  for (int k = 0; k < q.size(); ++k)
    for (const auto& [sign, limit] : {std::pair{1.0, limits.upper_of(k)}, {-1.0, limits.lower_of(k)}}) {
      if (!(sign * (q[k] - limit) > rounding * (1 + std::fabs(limit)))) continue;
      return ActionResult::refused(
          "limits: the joint is at " + detail::text(q[k]) + ", " + (sign > 0 ? "above" : "below") + " them",
          "let them contain its position, or give them a 'stiffness', which pushes it back");
    }
  return ActionResult::done();
}

void TopologyEditor::touch(int joint) {
  touched_[event_].insert(joint);
  names_at_start_.emplace(joint, joint_name(joint));
}

void TopologyEditor::break_off(int joint) {
  if (is_loop({joint})) return break_loop({joint});
  touch(joint);
  const int b = tree().carrier(joint);
  const bool was_root = tree().parent(b) < 0;
  carry_out(Break{{joint}}, Nature::workless);
  const std::string& body = world_.model()[BodyId{b}].name;
  edit_.names().name_joint(joint, edit_.names().free_joint(body, joint));
  if (!was_root) edit_.names().name_mechanism(b, body);
  if (tree().has_loops()) hold_by_loop(b);
}

void TopologyEditor::break_spring(int spring) {
  carry_out(BreakSpring{{spring}}, Nature::workless);
  event_->topology.broken_springs.push_back(world_.model().springs()[static_cast<std::size_t>(spring)].name);
}

ActionResult TopologyEditor::set_spring(int spring, const JointParameters& given) {
  if (!spring_acts(tree(), spring)) return ActionResult::skipped("the spring is broken");
  Spring all = world_.model().springs()[static_cast<std::size_t>(spring)];
  const SpringLaw& now = tree().springs().law(spring);
  const auto value = [](const Values& from, double kept) { return from.empty() ? kept : from[0]; };
  all.stiffness = value(given.stiffness, now.stiffness);
  all.damping = value(given.damping, now.damping);
  all.rest = value(given.rest, now.rest);
  all.strength = std::isfinite(given.strength.force) ? given.strength.force : now.strength;
  JointParameters others = given;
  others.stiffness = others.damping = others.rest = {};
  others.strength.force = HUGE_VAL;
  if (!(others == JointParameters{}) || std::max({given.stiffness.size(), given.damping.size(), given.rest.size()}) > 1)
    return ActionResult::refused("a spring has only 'stiffness', 'rest', 'damping' and the force of 'strength', each a number");
  if (all.inextensible && (!given.stiffness.empty() || !given.damping.empty()))
    return ActionResult::refused("a cable has neither stiffness nor damping", "its length is 'rest'");
  const double length = world_.spring({spring}).length;
  if (!dry_run_ && all.inextensible && *all.rest < now.rest && *all.rest < length)
    return ActionResult::refused(
        "rest: the ends of the cable are " + detail::text(length) + " m apart, farther than " + detail::text(*all.rest) + " m",
        "shorten it when they are nearer; what pulls them together is a spring with 'tension_only'");
  for (const SpringProblem& problem : check_spring(all))
    return ActionResult::refused(problem.field + ": " + problem.what, problem.hint);
  carry_out(SetSpring{{spring}, law_of(all)}, Nature::outside);
  return ActionResult::done();
}

void TopologyEditor::unlock(int joint, unsigned dofs) {
  touch(joint);
  if (is_loop({joint})) return lock_loop(joint, loop_of(joint).joint.locked & ~(dofs & ~world_.constraints().held(joint)));
  const JointParameters* p = tree().parameters(tree().carrier(joint));
  const bool resumes = p != nullptr && p->drive != nullptr && p->drive->moves();
  carry_out(Unlock{{joint}, dofs & ~world_.constraints().held(joint)}, resumes ? Nature::outside : Nature::workless);
}
void TopologyEditor::lock(int joint, unsigned dofs) {
  touch(joint);
  if (is_loop({joint}))
    lock_loop(joint, loop_of(joint).joint.locked | dofs);
  else
    carry_out(Lock{{joint}, dofs}, Nature::impact);
  std::erase_if(edit_.constraints().active_limits,
                [&](const ActiveLimit& h) { return h.joint == joint && (dofs >> h.dof & 1u) != 0; });
}

void TopologyEditor::apply_restitution(int joint, int dof, double restitution) {
  carry_out(Impact{{joint}, dof, restitution}, Nature::impact);
}
void TopologyEditor::apply_contact_impulses(const std::vector<double>& generalised, std::span<const AppliedImpulse> applied,
                                            std::span<const AppliedImpulse> on_ground) {
  MT_REQUIRE(edit_.state().variables() == Variables::velocities, "worlds with contacts are in velocities");
  evaluate();
  const Totals before = world_.totals();
  remember_momenta();
  const auto start = std::chrono::steady_clock::now();
  std::vector<double> change = generalised;
  if (tree().has_loops())
    solve_with_loops(tree(), edit_.state().q().data(), edit_.workspace(), change.data());
  else
    solve_with_factors<double>(tree(), edit_.state().q().data(), edit_.workspace(), change.data());
  {
    const State::Edit edit = edit_.state().edit();
    for (std::size_t i = 0; i < change.size(); ++i) edit.u[i] += change[i];
  }
  const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  account_.seconds += taken;
  event_->duration_ns += taken * 1e9;
  loop_impulses_now_.clear(), coupling_impulses_now_.clear();
  for (std::size_t i = 0; i < tree().loops().size(); ++i)
    loop_impulses_now_.push_back(loop_impulse(tree(), edit_.workspace(), static_cast<int>(i)));
  for (std::size_t i = tree().loops().size(); i < tree().loops().links.size(); ++i)
    coupling_impulses_now_.push_back(coupling_impulse(tree(), edit_.workspace(), static_cast<int>(i)));
  evaluate();
  event_->lost += before.kinetic - world_.totals().kinetic;
  book_impulses(applied);
  for (const AppliedImpulse& one : on_ground) {
    const Vec3 moment = cross(one.point, one.force);
    const double w[6] = {one.force.x, one.force.y, one.force.z, moment.x, moment.y, moment.z};
    for (std::size_t k = 0; k < 6; ++k) event_->ground_impulse[k] += w[k];
  }
}
void TopologyEditor::engage_limit(int joint, int dof, int sign) {
  if (is_loop({joint}))
    lock_loop(joint, loop_of(joint).joint.locked | 1u << dof);
  else
    carry_out(Lock{{joint}, 1u << dof}, Nature::impact);
  edit_.constraints().active_limits.push_back({joint, dof, sign});
}
void TopologyEditor::release_limit(int joint, int dof) {
  if (is_loop({joint}))
    lock_loop(joint, loop_of(joint).joint.locked & ~(1u << dof));
  else
    carry_out(Unlock{{joint}, 1u << dof}, Nature::workless);
  std::erase_if(edit_.constraints().active_limits, [&](const ActiveLimit& h) { return h.joint == joint && h.dof == dof; });
}

void TopologyEditor::loosen(int joint, const JointPlan& plan) {
  touch(joint);
  if (is_loop({joint})) return change_loop(joint, plan, false);
  end_couplings(joint);
  carry_out(ChangeJoint{{joint}, plan.joint, plan.q}, Nature::workless);
}
void TopologyEditor::become(int joint, const JointPlan& plan) {
  touch(joint);
  if (is_loop({joint})) return change_loop(joint, plan, true);
  end_couplings(joint);
  carry_out(ChangeJoint{{joint}, plan.joint, plan.q}, Nature::impact);
}

void TopologyEditor::reroot(int body) {
  const int root = root_of(tree(), {body}).index;
  touch(tree().joint_of(root));
  carry_out(Reroot{{body}}, Nature::workless);
  edit_.names().move_mechanism(root, body);
}

void TopologyEditor::push(int body, const Vec3& force, const Vec3& torque, const Vec3& point) {
  carry_out(Impulse{{body}, force, torque, point}, Nature::outside);
}

// A joint rests on a stop for as long as the stop stays where it is, and hard.
void TopologyEditor::leave_changed_stops(int joint, const JointLimits& limits) {
  const JointParameters* const own = parameters(joint);
  for (int dof = 0; own != nullptr && dof < info(declared(joint).kind).nv; ++dof) {
    const int sign = world_.constraints().held(joint, dof);
    const auto stop = [&](const JointLimits& of) {
      return !of.hard() ? sign * HUGE_VAL : sign > 0 ? of.upper_of(dof) : of.lower_of(dof);
    };
    if (sign != 0 && stop(own->limits) != stop(limits)) release_limit(joint, dof);
  }
}

void TopologyEditor::set(int joint, const JointParameters& parameters) {
  leave_changed_stops(joint, parameters.limits);
  if (is_loop({joint})) {
    const Loop& loop = loop_of(joint);
    const bool begins = parameters.drive != nullptr && parameters.drive->moves();
    return carry_out(SetLoop{{joint}, loop.joint, parameters, loop.held, turns_of_loop(joint), begins}, Nature::outside);
  }
  carry_out(SetParameters{{joint}, parameters}, Nature::outside);
}

JointParameters TopologyEditor::begun(int joint, JointParameters parameters) const {
  const Values q = coordinates(joint);
  if (q.size() == 1) begin_motion(parameters.drive, q[0], world_.time());
  return parameters;
}

ActionResult TopologyEditor::can_follow(int joint, const JointParameters& parameters) const {
  if (dry_run_ || parameters.drive == nullptr || !parameters.drive->moves()) return ActionResult::done();
  const double at = parameters.drive->motion[0].at(world_.time()).value, is = coordinates(joint)[0];
  if (std::fabs(at - is) <= motion_tolerance) return ActionResult::done();
  const auto text = [](double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.9g", x);
    return std::string(buffer);
  };
  return ActionResult::refused(
      "joint '" + joint_name(joint) + "' is at " + text(is) + ", but its motion is at " + text(at) + " now",
      "a joint can't jump: let the motion pass its position at this instant, or drive it there by 'pd' first");
}

bool TopologyEditor::drifts(int body) const {
  return floats(tree(), {body}) && !loosened.contains(tree().joint_of(root_of(tree(), {body}).index));
}

ActionResult TopologyEditor::already_joined(int body, int to, int joint) const {
  return ActionResult::refused(
      "'" + body_name(body) + "' and '" + body_name(to) + "' are already joined by joint '" + joint_name(joint) + "'",
      "lock that joint, or change its kind");
}

std::optional<ActionResult> TopologyEditor::name_taken(int body, int to) const {
  constexpr const char* other_name = "give the action or its event another name";
  if (spring(made_name_) >= 0) return ActionResult::refused("there is already a spring '" + made_name_ + "'", other_name);
  const int joint = world_.find_joint(made_name_);
  if (joint < 0) return std::nullopt;
  if (is_loop({joint}) && std::minmax(loop_of(joint).body, loop_of(joint).to) == std::minmax(body, to))
    return already_joined(body, to, joint);
  return ActionResult::refused("there is already a joint '" + made_name_ + "'", other_name);
}

ActionResult TopologyEditor::attach(int body, int to, const JointSpec& spec, const std::optional<Pose>& at) {
  if (body == to) return ActionResult::refused("body '" + body_name(body) + "' can't be joined to itself");
  const int root = root_of(tree(), {body}).index;
  if (to >= 0 && root_of(tree(), {to}).index == root) {
    const bool below = tree().parent(body) == to, above = tree().parent(to) == body;
    if (below || above) return already_joined(body, to, tree().joint_of(below ? body : to));
    return close_loop(body, to, spec, at);
  }
  const bool floats_here = drifts(body), floats_there = to >= 0 && drifts(to);
  if (!floats_here && !floats_there) return close_loop(body, to, spec, at);
  if (std::optional<ActionResult> taken = name_taken(body, to)) return *taken;

  const int carrier = floats_here ? body : to, other = floats_here ? to : body;
  const int old_root = root_of(tree(), {carrier}).index;
  const Pose present = inverse(pose(to)) * pose(body);
  ChangeJoint change;
  change.direction = carrier == body ? ChangeJoint::Direction::declared : ChangeJoint::Direction::reversed;
  change.to.kind = spec.kind, change.to.axis = spec.axis, change.to.axis2 = spec.axis2, change.to.pitch = spec.pitch;
  change.to.at = at ? *at : Pose{present.position, Quat{}};
  change.to.child_at = inverse(present) * change.to.at;
  change.q = joint_zero(spec.kind);

  touch(tree().joint_of(old_root));  // the free joint becomes the new joint
  carry_out(Join{{carrier}, {other}}, Nature::workless);
  if (other < 0)
    edit_.names().move_mechanism(old_root, carrier);
  else
    edit_.names().name_mechanism(old_root, {});
  change.joint = tree().inboard_joint({carrier});
  edit_.names().name_joint(change.joint.index, made_name_);
  carry_out(change, Nature::impact);
  const int made = change.joint.index;
  const JointParameters parameters = begun(made, spec.parameters);
  const ActionResult follows = can_follow(made, parameters);
  if (follows.outcome != ActionResult::Outcome::done) return follows;
  if (!(parameters == JointParameters{})) set(made, parameters);
  return ActionResult::done();
}

}  // namespace momentree
