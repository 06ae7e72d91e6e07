// Scheduling events, applying actions, and the records of events that happened.
#include <cmath>
#include <utility>

#include "records.hpp"
#include "world_object.hpp"

namespace momentree::python {

nb::object loop_status(const LoopStatus& status) {
  return python_class("_records", "LoopStatus")(status.rows, status.rank, status.residual);
}

nb::list contact_records(std::span<const ContactPoint> points, const Model& model) {
  const nb::object make = python_class("_records", "Contact");
  const auto name = [&](BodyId body) { return model.body_name(body); };
  nb::list all;
  for (const ContactPoint& point : points)
    all.append(make(name(point.one), name(point.other), from_vec3(point.point), from_vec3(point.normal), from_vec3(point.force),
                    from_vec3(point.slip), point.slips, nb::cast(point.determined), from_vec3(point.moment)));
  return all;
}

namespace {

nb::object totals(const Totals& t) {
  return python_class("_records", "Totals")(t.kinetic, t.potential, from_vec3(t.linear), from_vec3(t.angular),
                                            loop_status(t.loops));
}

nb::object impulse_of(const std::array<double, 6>& six) {
  return python_class("_records", "Wrench")(from_vec3({six[0], six[1], six[2]}), from_vec3({six[3], six[4], six[5]}));
}

nb::object contact_of(const Event::Contact& c) {
  if (c.one.empty()) return nb::none();
  return python_class("_records", "EventContact")(c.one, c.other, from_vec3(c.point), from_vec3(c.normal), from_vec3(c.impulse),
                                                  c.scaled, c.in_turn, c.cable);
}

nb::list texts(const std::vector<std::string>& all) {
  nb::list list;
  for (const std::string& each : all) list.append(each);
  return list;
}

// An event that is scheduled, or several that a wildcard stands for, with the parts that their actions need.
struct ScheduledObject {
  SimulationPtr simulation;
  std::vector<Simulation::Scheduled> events;
  std::vector<io::TriggerPart> parts;
};

std::vector<Action> actions_of(const SimulationPtr& self, const std::string& key, nb::handle value, const io::TriggerPart& part) {
  const World& world = self->simulation().world();
  const std::string call = "momentree." + key;
  const std::vector<Action> actions = io::PartReader(call).actions(key, to_value(value, call), part, world);
  return actions;
}

// `actions`: pairs of an action's key and its value in a scenario.
void then(ScheduledObject& scheduled, const std::vector<std::pair<std::string, nb::object>>& actions) {
  const SimulationPtr& self = scheduled.simulation;
  const Use use(*self, Access::schedule);
  std::vector<std::vector<Action>> all(scheduled.events.size());  // first everything that can fail
  for (std::size_t i = 0; i < scheduled.events.size(); ++i)
    for (const auto& [key, value] : actions)
      for (Action& action : actions_of(self, key, value, scheduled.parts[i])) all[i].push_back(std::move(action));
  for (std::size_t i = 0; i < all.size(); ++i)
    for (Action& action : all[i]) scheduled.events[i].then(std::move(action));
}

void named(ScheduledObject& scheduled, const std::string& name) {
  const Use use(*scheduled.simulation, Access::schedule);
  for (Simulation::Scheduled& event : scheduled.events) event.named(name);
}

std::shared_ptr<ScheduledObject> one(const SimulationPtr& self, Simulation::Scheduled event) {
  auto scheduled = std::make_shared<ScheduledObject>(ScheduledObject{self, {}, {}});
  scheduled->events.push_back(std::move(event));
  scheduled->parts.emplace_back();
  return scheduled;
}

std::shared_ptr<ScheduledObject> when(const SimulationPtr& self, nb::handle event) {
  const Use use(*self, Access::schedule);
  Simulation& sim = self->simulation();
  auto scheduled = std::make_shared<ScheduledObject>(ScheduledObject{self, {}, {}});
  scheduled->parts = io::PartReader("Simulation.when").triggers(to_value(event, "Simulation.when"), sim.world());
  for (const io::TriggerPart& part : scheduled->parts) scheduled->events.push_back(sim.when(*part.condition));
  return scheduled;
}

double value_now(const SimulationPtr& self, nb::handle event) {
  const Use use(*self, Access::change);  // it may have to evaluate the world
  const Simulation& sim = self->simulation();
  const auto parts = io::PartReader("Simulation.value").triggers(to_value(event, "Simulation.value"), sim.world());
  if (parts.size() != 1) refuse("a quantity of several joints or bodies has several values", "name one of them");
  return parts.front().condition->what->value(sim.world(), {}).value_or(std::nan(""));
}

std::shared_ptr<ScheduledObject> when_measured(const SimulationPtr& self, nb::handle function, double threshold, bool exceeds,
                                               bool repeats, double hysteresis, double lasting, bool exact) {
  const Use use(*self, Access::schedule);
  const Measure measure = measure_of(function);
  Condition condition = exceeds ? measure.exceeds(threshold) : measure.below(threshold);
  condition.repeats = repeats, condition.hysteresis = hysteresis, condition.duration = lasting, condition.exact = exact;
  return one(self, self->simulation().when(std::move(condition)));
}

nb::object apply_now(const SimulationPtr& self, const std::vector<std::pair<std::string, nb::object>>& actions,
                     const std::string& name) {
  const Use use(*self, Access::change);
  std::vector<Action> all;
  for (const auto& [key, value] : actions)
    for (Action& action : actions_of(self, key, value, {})) all.push_back(std::move(action));
  return event_record(self->simulation().apply(all, name));
}

nb::list events(const SimulationPtr& self, std::size_t first) {
  const Use use(*self, Access::read);
  nb::list list;
  const std::vector<Event>& all = self->simulation().events();
  for (std::size_t i = first; i < all.size(); ++i) list.append(event_record(all[i]));
  return list;
}

nb::list missed(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  const nb::object type = python_class("_records", "MissedEvent");
  nb::list list;
  for (const MissedEvent& m : self->simulation().missed())
    list.append(type(m.name, m.time, m.after, m.quantity, texts(m.of), m.threshold, m.exceeds, m.nearest, m.nearest_time));
  return list;
}

nb::list dry_run(const SimulationPtr& self) {
  const Use use(*self, Access::change);
  nb::list list;
  for (const DryRun::Issue& issue : self->simulation().dry_run().issues)
    list.append(issue.message.empty() ? issue.result.why : issue.message);
  return list;
}

}  // namespace

nb::object event_record(const Event& event) {
  nb::list actions;
  const nb::object action_type = python_class("_records", "ActionRecord");
  for (const ActionRecord& a : event.actions)
    actions.append(action_type(a.kind, a.target, a.joint, a.body, a.to, a.skipped, a.spring));
  nb::dict impulse;
  for (const auto& [joint, six] : event.impulse) impulse[joint.c_str()] = impulse_of(six);
  return python_class("_records", "Event")(
      "time"_a = event.time, "name"_a = event.name, "actions"_a = nb::tuple(actions),
      "mechanisms_before"_a = nb::tuple(texts(event.mechanisms_before)),
      "mechanisms_after"_a = nb::tuple(texts(event.mechanisms_after)), "before"_a = totals(event.before),
      "after"_a = totals(event.after), "released"_a = event.released, "lost"_a = event.lost, "work"_a = event.work,
      "impulse"_a = impulse, "ground_impulse"_a = impulse_of(event.ground_impulse), "hardest_joint"_a = event.hardest_joint,
      "duration_ns"_a = event.duration_ns, "contact"_a = contact_of(event.contact), "reason"_a = event.reason,
      "stepped"_a = nb::tuple(texts(event.stepped)));
}

void register_events(nb::module_& m, SimulationClass& simulation) {
  nb::class_<ScheduledObject>(m, "_Scheduled").def("_then", &then).def("_named", &named);
  simulation
      .def("_at",
           [](const SimulationPtr& self, nb::handle time) {
             const Use use(*self, Access::schedule);
             return one(self, self->simulation().at(seconds_of(time, "Simulation.at")));
           })
      .def("_after",
           [](const SimulationPtr& self, const std::string& event, nb::handle delay) {
             const Use use(*self, Access::schedule);
             return one(self, self->simulation().after(event, seconds_of(delay, "Simulation.after")));
           })
      .def("_every",
           [](const SimulationPtr& self, nb::handle period, nb::handle start) {
             const Use use(*self, Access::schedule);
             return one(self,
                        self->simulation().every(seconds_of(period, "Simulation.every"), seconds_of(start, "Simulation.every")));
           })
      .def("_when", &when)
      .def("_value", &value_now)
      .def("_when_measured", &when_measured)
      .def("_apply", &apply_now)
      .def("_events", &events)
      .def_prop_ro("_event_count",
                   [](const SimulationPtr& self) {
                     const Use use(*self, Access::read);
                     return self->simulation().events().size();
                   })
      .def_prop_ro("missed", &missed, "Scheduled events that have not happened so far, and why: a list of `MissedEvent`.")
      .def("_dry_run", &dry_run)
      .def("_check_handle", [](const SimulationPtr& self, nb::handle handle) {
        const Use use(*self, Access::read);
        const World& world = self->simulation().world();
        if (nb::isinstance<BodyObject>(handle)) (void)body_of(world, *self, handle);
        if (nb::isinstance<JointObject>(handle)) (void)joint_of(world, *self, handle);
      });
}

}  // namespace momentree::python
