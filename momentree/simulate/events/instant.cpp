#include <momentree/simulate/events/instant.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include <momentree/simulate/events/topology_record.hpp>
#include <momentree/simulate/world/topology_editor.hpp>

namespace momentree {

namespace {

struct Item {
  std::size_t event, action;
  const Action* what;
  ActionPhase phase = ActionPhase::release;
};

std::string in_event(const DueEvent& event, const Action& action) { return action.text() + " (event '" + event.name + "')"; }

// Finds two actions that change the same DoF of one joint; returns the second action and its result.
std::optional<std::pair<std::size_t, ActionResult>> contradiction(std::span<const DueEvent> due, const std::vector<Item>& items) {
  struct Decided {
    std::string joint;
    unsigned dofs;
    std::size_t item;
  };
  std::vector<Decided> all;
  for (std::size_t i = 0; i < items.size(); ++i)
    if (const unsigned dofs = (**items[i].what).reshapes(); dofs != 0)
      for (std::string& joint : (**items[i].what).joints()) all.push_back({std::move(joint), dofs, i});
  std::stable_sort(all.begin(), all.end(), [](const Decided& a, const Decided& b) { return a.joint < b.joint; });
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = i; k-- > 0 && all[k].joint == all[i].joint;) {
      const Item &one = items[all[k].item], &other = items[all[i].item];
      const bool same = (**one.what).key() == (**other.what).key() && (**one.what).effect() != JointEffect::replaced;
      if (same || (all[k].dofs & all[i].dofs) == 0) continue;
      return std::pair{all[i].item, ActionResult::refused(
                                        "contradicts " + in_event(due[one.event], *one.what) + " at the same instant",
                                        "a joint can take only one such change at a time: give the actions different instants")};
    }
  }
  return std::nullopt;
}

// The effect of one action on the world's totals.
struct Step {
  std::size_t event;
  Totals before, after;
};

// Gives each event its own `before` and `after`: the energy and momenta that its own actions changed, whatever other events of
// the instant did in between. Events are chained in the order of the list: the first begins with the totals before the instant,
// each later one with the totals at the end of the previous one. If the actions were carried out in that order, these are states
// that actually occurred.
void share_totals(const Totals& start, const std::vector<Step>& steps, std::vector<Event>& events) {
  Totals now = start;
  bool in_order = true;
  for (std::size_t i = 1; i < steps.size(); ++i) in_order = in_order && steps[i - 1].event <= steps[i].event;
  for (std::size_t e = 0; e < events.size(); ++e) {
    events[e].before = now;
    for (const Step& step : steps) {
      if (step.event != e) continue;
      if (in_order) {
        now = step.after;
        continue;
      }
      now.kinetic += step.after.kinetic - step.before.kinetic;
      now.potential += step.after.potential - step.before.potential;
      now.linear += step.after.linear - step.before.linear;
      now.angular += step.after.angular - step.before.angular;
    }
    events[e].after = now;
  }
  if (!events.empty() && !steps.empty()) events.back().after = steps.back().after;  // removes the rounding errors of the sums
}

ActionResult no_free_mass() {
  return ActionResult::refused("a part would then lack the mass or inertia to move freely",
                               "give it a mass and an inertia about every axis");
}

bool is_finite(const Totals& totals) {
  return std::isfinite(totals.kinetic) && std::isfinite(totals.linear.x + totals.linear.y + totals.linear.z);
}

// Bodies that moved before must still move, and a change that only releases or locks must add no energy (unless a joint is
// driven): otherwise a mass is missing somewhere. `brought`: kinetic energy from new parameters, such as those of a joint that is
// made.
ActionResult check_energy(const Totals& before, const Totals& after, ActionPhase phase, bool driven, double brought) {
  const bool finite = is_finite(after);
  const bool gained = !driven && phase < ActionPhase::impulse && after.kinetic - brought > before.kinetic * (1 + 1e-3) + 1e-30;
  if (finite && !gained) return ActionResult::done();
  if (phase >= ActionPhase::impulse)
    return ActionResult::refused("it would make velocities overflow", "is the value as intended?");
  return no_free_mass();
}

ActionRecord record_of(const ActionBase& action, const std::string& made_joint, const ActionResult& result, const World& world) {
  ActionRecord record{std::string(action.key()), action.target(), made_joint, {}, {}, {}};
  if (const std::vector<std::string> joints = action.joints(); !joints.empty()) {
    const bool spring = action.takes_springs() && world.find_spring(joints.front()) >= 0;
    (spring ? record.spring : record.joint) = joints.front();
  }
  if (const std::vector<std::string> bodies = action.bodies(); !bodies.empty()) {
    record.body = bodies.front();
    if (!made_joint.empty()) record.to = bodies.size() > 1 ? bodies[1] : "ground";
  }
  if (result.outcome == ActionResult::Outcome::skipped) record.skipped = result.why;
  return record;
}

}  // namespace

bool has_thin_bodies(const Model& model) {
  return std::any_of(model.bodies().begin(), model.bodies().end(), [](const BodySpec& body) {
    const Sym3& J = body.inertia;
    const double size = (J.xx + J.yy + J.zz) / 3;
    const double product =
        J.xx * (J.yy * J.zz - J.yz * J.yz) - J.xy * (J.xy * J.zz - J.yz * J.xz) + J.xz * (J.xy * J.yz - J.yy * J.xz);
    return !(body.mass > 0) || !(product > 1e-9 * size * size * size);
  });
}

std::string refusal(const DueEvent& event, const Action& action, double time, const ActionResult& result) {
  char at[40];
  std::snprintf(at, sizeof at, "%.9g", time);
  std::string text = "event '" + event.name + "' at t = " + at + " s: " + action.text() + ": " + result.why;
  if (!result.hint.empty()) text += "; " + result.hint;
  return text;
}

std::string made_joint_name(const DueEvent& event, std::size_t action) {
  if (std::string given = event.actions[action]->made_name(); !given.empty()) return given;
  const std::string own = event.actions[action]->makes();
  if (own.empty() || !event.named) return own;
  const auto makes = [](const Action& a) { return !a->makes().empty() && a->made_name().empty(); };
  return std::count_if(event.actions.begin(), event.actions.end(), makes) == 1 ? event.name : own;
}

bool makes_joint(const DueEvent& event, const std::string& joint) {
  for (std::size_t a = 0; a < event.actions.size(); ++a)
    if (made_joint_name(event, a) == joint) return true;
  return false;
}

InstantReport carry_out(World& world, std::span<const DueEvent> due, bool dry_run) {
  InstantReport report;
  TopologyEditor editor(world, dry_run);
  report.events.resize(due.size());
  std::vector<Item> items;
  for (std::size_t e = 0; e < due.size(); ++e) {
    report.events[e].time = world.time();
    report.events[e].name = due[e].name;
    for (std::size_t a = 0; a < due[e].actions.size(); ++a) items.push_back({e, a, &due[e].actions[a]});
  }
  const WorldSnapshot start = world.snapshot();
  const Totals totals_at_start = world.totals();
  std::optional<Membership> members_at_start;
  if (!dry_run) members_at_start.emplace(world);
  const bool thin = !dry_run && has_thin_bodies(world.model());
  std::vector<Step> steps;
  std::vector<char> begun(due.size(), 0);
  const auto refuse = [&](const Item& item, ActionResult result) {
    world.restore(start);
    report.refused = true;
    report.message = refusal(due[item.event], *item.what, world.time(), result);
    report.actions.push_back({item.event, item.action, std::move(result)});
    report.events.clear();
  };
  if (items.size() > most_actions_at_once) {
    refuse(items[most_actions_at_once], ActionResult::refused("more than " + std::to_string(most_actions_at_once) +
                                                                  " actions at one instant, the first of them " +
                                                                  in_event(due[items[0].event], *items[0].what),
                                                              "does a wildcard match too much?"));
    return report;
  }
  if (const auto found = contradiction(due, items)) {
    refuse(items[found->first], found->second);
    return report;
  }

  // Returns false if the instant is refused.
  const auto carry = [&](const Item& item, bool prepares) {
    Event& event = report.events[item.event];
    const Totals before = world.totals();
    if (!prepares && begun[item.event] == 0) {  // preparation changes no mechanism
      begun[item.event] = 1;
      event.mechanisms_before = world.mechanism_names();
    }
    editor.begin(event, made_joint_name(due[item.event], item.action));
    const long changes = editor.account().changes;
    const double brought = editor.account().brought;
    const ActionBase& action = **item.what;
    ActionResult result = prepares ? action.prepare(editor) : action.apply(editor);
    const Totals after = world.totals();
    // In a dry run the coordinates are not those of the instant: a mass may be missing there and not at the instant itself.
    const bool checked = !dry_run || item.phase >= ActionPhase::impulse;
    if (!checked && !is_finite(after)) {
      world.restore(start);
      report.lost = true;
      report.events.clear();
      return false;
    }
    if (result.outcome == ActionResult::Outcome::done && checked) {
      const bool driven = !world.tree().joints_with().motions.empty() || world.tree().loops().motions > 0;
      const ActionResult sound = check_energy(before, after, item.phase, driven, editor.account().brought - brought);
      if (sound.outcome != ActionResult::Outcome::done) result = sound;
      if (sound.outcome != ActionResult::Outcome::done && prepares)  // the body is not held between the removal of the old joint
                                                                     // and the new one
        result =
            ActionResult::refused("it can't share an impact with other actions: the child alone lacks the inertia to move freely",
                                  "give this change its own instant");
    }
    if (result.outcome == ActionResult::Outcome::refused) {
      refuse(item, std::move(result));
      return false;
    }
    const bool changed = editor.account().changes != changes;
    if (changed && thin && !prepares && !singular_joints(editor.tree(), world.state().q()).empty()) {
      refuse(item, no_free_mass());
      return false;
    }
    if (changed && !prepares)
      if (ActionResult possible = editor.can_move(); possible.outcome == ActionResult::Outcome::refused) {
        refuse(item, std::move(possible));
        return false;
      }
    if (changed) steps.push_back({item.event, before, after});
    event.mechanisms_after = world.mechanism_names();
    if (prepares) return true;
    event.actions.push_back(record_of(action, made_joint_name(due[item.event], item.action), result, world));
    report.actions.push_back({item.event, item.action, std::move(result)});
    return true;
  };

  for (Item& item : items) item.phase = (**item.what).phase(editor);
  const auto in_phase = [&](ActionPhase phase, auto act) {
    for (const Item& item : items)
      if (item.phase == phase && !act(item)) return false;
    return true;
  };
  if (!in_phase(ActionPhase::release, [&](const Item& item) { return carry(item, false); })) return report;
  const auto impacts = std::count_if(items.begin(), items.end(), [](const Item& i) { return i.phase == ActionPhase::impact; });
  if (impacts > 1 && !in_phase(ActionPhase::impact, [&](const Item& item) { return carry(item, true); })) return report;
  for (const ActionPhase phase : {ActionPhase::impact, ActionPhase::impulse, ActionPhase::parameters})
    if (!in_phase(phase, [&](const Item& item) { return carry(item, false); })) return report;

  report.seconds = editor.account().seconds;
  report.changes = editor.account().changes;
  share_totals(totals_at_start, steps, report.events);
  for (std::size_t e = 0; e < due.size(); ++e) {
    if (begun[e] != 0) continue;  // otherwise the event has no action
    report.events[e].mechanisms_before = report.events[e].mechanisms_after = world.mechanism_names();
  }
  for (Event& event : report.events) editor.certify(event);
  if (members_at_start && !report.events.empty() && report.changes != 0)
    report.events.back().topology.moved = members_at_start->moved(Membership(world));
  return report;
}

}  // namespace momentree
