#include <momentree/simulate/arguments.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <momentree/integrate/integrator.hpp>
#include <momentree/simulate/contact/contact_bodies.hpp>
#include <momentree/simulate/events/instant.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/simulate/stepping/overlap.hpp>

namespace momentree {

std::string detail::text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.9g", x);
  return buffer;
}

using detail::text;

Integration checked(Integration how) {
  const std::vector<std::string> methods = integration_methods();
  how.method = method_named(how.method);
  if (std::find(methods.begin(), methods.end(), how.method) == methods.end())
    throw_error({"unknown integration method '" + how.method + "'", "", did_you_mean(how.method, method_names())});
  if (how.variables == Variables::velocities && !takes_velocities(how.method))
    throw_error({"the method '" + how.method + "' integrates momenta", "", "leave out variables = \"velocities\""});
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (!positive(how.step)) throw_error({"the step must be a positive time, not " + text(how.step), "", ""});
  if (!positive(how.rtol) || !positive(how.atol) || !(how.max_step > 0))
    throw_error({"rtol, atol and max_step must be positive", "", ""});
  if (!positive(how.event_tolerance))
    throw_error({"the event tolerance must be a positive time, not " + text(how.event_tolerance), "", ""});
  return how;
}

namespace {

std::optional<Error> unfit_method(const std::string& method) {
  if (supports_contact(method)) return std::nullopt;
  std::string others;
  for (const std::string& other : integration_methods())
    if (supports_contact(other)) others += (others.empty() ? "\"" : ", \"") + other + '"';
  return Error{"the method '" + method + "' does not support contact and cables", "", "use one of " + others};
}

}  // namespace

void require_contact_method(const WorldSnapshot& snapshot, const std::string& method) {
  if (!snapshot.added_colliders.empty())
    if (std::optional<Error> unfit = unfit_method(method)) throw_error(std::move(*unfit));
}

std::optional<Error> unfit_for_contact(const Model& model, const std::string& method) {
  if (!model.has_contact()) return std::nullopt;
  if (std::optional<Error> unfit = unfit_method(method)) return unfit;
  if (model.colliders().size() > most_colliders)
    return Error{std::to_string(model.colliders().size()) + " shapes can touch, and at most " + std::to_string(most_colliders) +
                     " are supported yet",
                 "", "give fewer bodies a collision"};
  return std::nullopt;
}

Variables Integration::state_variables() const { return variables.value_or(default_variables(method)); }

Variables Integration::state_variables(const Model& model) const {
  if (model.has_contact()) return Variables::velocities;
  return has_equations(model) ? loop_variables() : state_variables();
}

Variables Integration::loop_variables() const {
  return variables.value_or(takes_velocities(method) ? Variables::velocities : Variables::momenta);
}

std::optional<Error> wrong_period(double period, double clock, const char* what) {
  if (!(period > 0) || !std::isfinite(period))
    return Error{std::string(what) + " can't be " + text(period) + " s", "", "give a positive time"};
  if (clock + period <= clock)
    return Error{std::string(what) + " of " + text(period) + " s is shorter than the clock can resolve", "",
                 "at " + text(clock) + " s that is " + text(std::nextafter(clock, HUGE_VAL) - clock) + " s"};
  return std::nullopt;
}

std::optional<Error> unknown_name(const World& world, const EventQueue& queue, const std::vector<std::string>& joints,
                                  const std::vector<std::string>& bodies, bool springs) {
  const Model& model = world.model();
  const auto unknown = [&model](const char* what, const std::string& name, std::string BodySpec::*names) {
    std::vector<std::string> known;
    for (const BodySpec& body : model.bodies()) known.push_back(body.*names);
    if (names == &BodySpec::joint_name)
      for (const LoopSpec& loop : model.loops()) known.push_back(loop.name);
    return Error{"there is no " + std::string(what) + " '" + name + "'", "", did_you_mean(name, known)};
  };
  for (const std::string& body : bodies)
    if (body != "ground" && !model.has_body(body)) return unknown("body", body, &BodySpec::name);
  for (const std::string& joint : joints) {
    if (model.has_spring(joint)) {
      if (springs) continue;
      return Error{"'" + joint + "' is a spring, not a joint", "", "a spring can break and be set, and has a reaction_force"};
    }
    if (model.has_joint(joint) || world.find_joint(joint) >= 0 || queue.expected.contains(joint)) continue;
    const std::size_t tail = joint.rfind("~free");
    if (model.has_body(tail == std::string::npos ? joint : joint.substr(0, tail))) continue;
    const auto made = [&](const EventQueue::Entry& e) { return makes_joint(e.event, joint); };
    if (std::any_of(queue.entries.begin(), queue.entries.end(), made)) continue;
    Error error = unknown("joint", joint, &BodySpec::joint_name);
    if (springs && !model.springs().empty()) {
      std::vector<std::string> known;
      for (const Spring& spring : model.springs()) known.push_back(spring.name);
      error.problem = "there is no joint or spring '" + joint + "'";
      if (const std::string hint = did_you_mean(joint, known); error.hint.empty()) error.hint = hint;
    }
    return error;
  }
  return std::nullopt;
}

namespace {

bool has_single_dof(Kind kind) { return info(kind).nq == 1 && info(kind).nv == 1; }

// A quantity that was valid at the start but is not now may become valid again: a continued run schedules all events of the whole
// run.
void check_quantity(const World& world, const EventQueue& queue, const Quantity& what) {
  const Model& model = world.model();
  for (const std::string& name : what.mechanisms()) {
    if (model.has_body(name)) continue;  // a part that breaks off has the name of its root body
    std::vector<std::string> known = world.mechanism_names();
    for (int b = 0; b < model.size(); ++b)
      if (model[{b}].parent == ground) known.push_back(model.mechanism_name({b}));
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw_error({"there is no mechanism '" + name + "'", "", did_you_mean(name, known)});
  }
  if (!what.of_single_dof()) return;
  for (const std::string& name : what.joints()) {
    const int number = world.find_joint(name);
    if (number < 0 || has_single_dof(world.joint({number}).kind)) continue;
    if (model.has_joint(name) && has_single_dof(model.joint_spec(model.joint(name)).kind)) continue;
    const auto changes = [&name](const EventQueue::Entry& e) {
      return std::any_of(e.event.actions.begin(), e.event.actions.end(), [&name](const Action& a) {
        const std::vector<std::string> joints = a->joints();
        return a->effect() == JointEffect::replaced && std::find(joints.begin(), joints.end(), name) != joints.end();
      });
    };
    if (std::any_of(queue.entries.begin(), queue.entries.end(), changes)) continue;
    const KindInfo& kind = info(world.joint({number}).kind);
    throw_error({std::string(what.key()) + ": joint '" + name + "' is " + kind.name + " and has " + std::to_string(kind.nv) +
                     " degrees of freedom",
                 "", "for joints with one degree of freedom"});
  }
}

}  // namespace

std::optional<Error> open_reaction(const World& world, const Condition& condition) {
  const Quantity& what = *condition.what;
  const ReactionParts parts = what.reaction_parts();
  if (parts == 0 || condition.least_norm || !world.tree().has_loops()) return std::nullopt;
  for (const std::string& name : what.joints()) {
    const int number = world.find_joint(name);
    if (number < 0 || world.loops_determine({number}, parts)) continue;
    std::string determined;
    for (unsigned part = 0; part < 6; ++part)
      if (world.loops_determine({number}, 1u << part))
        determined += std::string(determined.empty() ? "" : " ") + "fm"[part / 3] + "xyz"[part % 3];
    return Error{
        std::string(what.key()) + ": the closed loops do not determine the reaction of joint '" + name + "'" +
            (determined.empty() ? "" : ", but its components " + determined),
        "",
        "add undetermined = \"least_norm\" to take the least of all possible reactions, or let loops block fewer "
        "directions, for example by a ball and a universal joint instead of revolute ones (explain counts the equations)"};
  }
  return std::nullopt;
}

void check_condition(const World& world, const EventQueue& queue, const Condition& condition) {
  const Quantity& what = *condition.what;
  if (std::optional<Error> error = unknown_name(world, queue, what.joints(), what.bodies(), what.takes_springs()))
    throw_error(std::move(*error));
  if (std::optional<Error> error = cannot_touch(world.model(), what)) throw_error(std::move(*error));
  check_quantity(world, queue, what);
  if (std::optional<Error> error = open_reaction(world, condition)) throw_error(std::move(*error));
  if (!std::isfinite(condition.threshold)) throw_error({"the threshold must be finite", "", ""});
  if (what.never_negative() && !(condition.threshold > 0))
    throw_error({"a threshold of " + text(condition.threshold) + " must be positive: the quantity is never negative", "", ""});
  if (!(condition.duration >= 0) || !std::isfinite(condition.duration))
    throw_error({"the duration of a condition can't be " + text(condition.duration) + " s", "", ""});
  if (!std::isfinite(condition.hysteresis)) throw_error({"the hysteresis must be finite", "", ""});
}

}  // namespace momentree
