// Simulation: making one, stepping, the arrays of its state.
#include <cmath>
#include <utility>

#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/state/changed_start.hpp>

#include "model_object.hpp"
#include "world_object.hpp"

namespace momentree::python {

namespace {

// Constructors write the object into memory that Python has.
void begin(SimulationObject* self, std::unique_ptr<io::Session> session) {
  auto scenario = std::make_shared<const io::Scenario>(session->scenario());
  new (self) SimulationObject(std::move(scenario), std::move(session));
}

void from_model(SimulationObject* self, const ModelObject& model, nb::handle options) {
  const Integration integration = io::PartReader("Simulation").integration(to_value(options, "Simulation"));
  auto session = std::make_unique<io::Session>(scenario_of(model, integration));
  session->warnings = session->schedule();
  if (const World& world = session->simulation().world(); world.tree().has_loops())
    if (const auto changed = io::changed_start(world))
      session->warnings.push_back({io::Severity::warning, "", 0, 0, changed->what, changed->hint, ""});
  begin(self, std::move(session));
}

void from_file(SimulationObject* self, const std::string& path, const std::vector<std::string>& overrides,
               const std::string& state, const std::optional<std::string>& text) {
  io::Session loaded = text ? io::load_text(*text, path, {overrides, state}) : io::load(path, {overrides, state});
  begin(self, std::make_unique<io::Session>(std::move(loaded)));
}

void from_branch(SimulationObject* self, const SimulationPtr& from) {
  const Use use(*from, Access::read);
  new (self) SimulationObject(*from);
  self->set_inputs(from->copy_inputs());
}

using Numbers_ = StateArrays::Numbers;

struct ArrayPart {
  Numbers_ StateArrays::*numbers;
  nb::object StateViews::*view;
};

nb::object view_of(const SimulationPtr& self, ArrayPart part, const char* name) {
  const Use use(*self, Access::read);
  const std::shared_ptr<StateArrays>& arrays = self->arrays();
  Numbers_& numbers = (*arrays).*part.numbers;
  if (part.numbers == &StateArrays::v && !arrays->with_v) arrays->with_v = true, self->pull();
  if (part.numbers == &StateArrays::effort) arrays->with_effort = true;
  nb::object& view = self->views.*part.view;
  if (!view.is_valid()) view = state_view(arrays, numbers.now, name);
  return view;
}

void assign(const SimulationPtr& self, ArrayPart part, nb::handle values, const char* name) {
  const nb::object view = view_of(self, part, name);
  Numbers_& numbers = (*self->arrays()).*part.numbers;
  const std::vector<double> given = numbers_of(values, numbers.now.size(), 0, name);
  if (&((*self->arrays()).*part.numbers) != &numbers) refuse(std::string(name) + ": the topology changed while it was assigned");
  std::copy(given.begin(), given.end(), numbers.now.begin());
  try {
    const Use use(*self, Access::change);  // takes it over, or says what is wrong
  } catch (...) {
    numbers.now = numbers.last;
    throw;
  }
}

void def_array(SimulationClass& simulation, const char* name, ArrayPart which, const char* about) {
  simulation.def_prop_rw(
      name, [which, name](const SimulationPtr& self) { return view_of(self, which, name); },
      [which, name](const SimulationPtr& self, nb::handle values) { assign(self, which, values, name); }, nb::arg().none(),
      about);
}

void set_state(const SimulationPtr& self, nb::handle q, nb::handle v, nb::handle p, std::optional<double> time) {
  const Use use(*self, Access::change);
  Simulation& sim = self->simulation();
  const World& world = sim.world();
  const Tree& tree = world.tree();
  const auto nq = static_cast<std::size_t>(tree.nq()), nv = static_cast<std::size_t>(tree.nv());
  if (!v.is_none() && !p.is_none())
    refuse("set_state: both v and p are given", "momenta follow from velocities: give one of them");
  const auto listed = [](Numbers numbers) { return std::vector<double>(numbers.begin(), numbers.end()); };
  const std::vector<double> coordinates = q.is_none() ? listed(world.state().q()) : numbers_of(q, nq, 0, "q");
  const Variables given = p.is_none() ? Variables::velocities : Variables::momenta;
  const std::vector<double> y = !p.is_none()  ? numbers_of(p, nv, 0, "p")
                                : v.is_none() ? listed(world.v())
                                              : numbers_of(v, nv, 0, "v");
  if (time)
    sim.set_state(*time, coordinates, y, given);
  else
    sim.adjust(coordinates, y, given);
}

void make_step(const SimulationPtr& self, nb::handle dt) {
  const Use use(*self, Access::change);
  self->step(dt.is_none() ? self->scenario().integration.step : seconds_of(dt, "Simulation.step"));
}

nb::dict integration_of(const SimulationObject& self) {
  const Integration& how = self.scenario().integration;
  nb::dict all;
  all["method"] = how.method, all["variables"] = name_of(how.state_variables(self.scenario().model)), all["step"] = how.step,
  all["event_tolerance"] = how.event_tolerance;
  if (is_adaptive(how.method)) {
    all["rtol"] = how.rtol, all["atol"] = how.atol;
    if (std::isfinite(how.max_step)) all["max_step"] = how.max_step;
  }
  return all;
}

nb::dict statistics_of(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  const RunStatistics& s = self->simulation().statistics();
  nb::dict all;
  all["steps"] = s.steps, all["changes"] = s.changes, all["evaluations"] = s.evaluations[0] + s.evaluations[1];
  all["evaluation_seconds"] = s.evaluation_seconds[0] + s.evaluation_seconds[1];
  all["total_seconds"] = s.total_seconds[0] + s.total_seconds[1], all["topology_seconds"] = s.topology_seconds;
  all["worst_step_seconds"] = s.worst_step_seconds;
  all["contact_residual"] = s.contact_residual;
  return all;
}

nb::dict balance_of(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  const EnergyBalance e = self->simulation().energy();
  nb::dict all;
  all["initial"] = e.initial, all["final"] = e.final, all["dissipated"] = e.dissipated, all["work"] = e.work;
  all["lost_in_impacts"] = e.lost_in_impacts, all["released"] = e.released, all["error"] = e.error;
  all["projection"] = e.projection;
  return all;
}

void drive_joint(const SimulationPtr& self, nb::handle joint, nb::handle function) {
  const Use use(*self, Access::change);
  const JointId id = joint_of(self->simulation().world(), *self, joint);
  self->set_drive(std::string(self->simulation().world().joint_name(id)), function);
}

void act_on(const SimulationPtr& self, nb::handle body, nb::handle function) {
  const Use use(*self, Access::change);
  const World& world = self->simulation().world();
  const std::string& name = world.model()[body_of(world, *self, body)].name;
  self->simulation().force(name, function.is_none() ? BodyFunction{} : force_of(function));
}

std::string add_body(const SimulationPtr& self, const std::string& name, nb::handle parent, nb::handle fields) {
  const Use use(*self, Access::change);
  io::BodyPart part = body_part("Simulation.add('" + name + "')", name, fields);
  const World& world = self->simulation().world();
  std::string ground_name;
  const bool on_ground = parent.is_none() || (nb::try_cast(parent, ground_name) && ground_name == "ground");
  part.spec.parent = on_ground ? ground : body_of(world, *self, parent);
  self->simulation().add(std::move(part.spec), std::move(part.solids));
  return name;
}

}  // namespace

void register_simulation(nb::module_& m) {
  nb::class_<StateArrays>(m, "_StateArrays").def_prop_ro("alive", [](const StateArrays& a) { return a.alive; });
  SimulationClass simulation(m, "SimulationBase");
  simulation.def("__init__", &from_model)
      .def("__init__", &from_file)
      .def("__init__", &from_branch)
      .def_prop_ro(
          "time",
          [](const SimulationPtr& self) {
            const Use use(*self, Access::read);
            return self->simulation().time();
          },
          "Time (s).")
      .def_prop_ro(
          "world", [](const SimulationPtr& self) { return std::make_shared<WorldObject>(WorldObject{self}); },
          "The world: bodies, joints and mechanisms at the present instant. It follows the simulation.")
      .def_prop_ro("integration", &integration_of,
                   "Method, step (s) and tolerances, under the names of the constructor's arguments; a copy.")
      .def_prop_ro(
          "statistics", &statistics_of,
          "Counts of steps, evaluations and changes, and the processor times (s) that they took, of all runs so far; a copy.")
      .def_prop_ro("energy_balance", &balance_of,
                   "The energy ledger since the start (J), a copy: initial, final, dissipated, work, lost_in_impacts, released, "
                   "projection, "
                   "error.\n\n"
                   "error = final + dissipated + lost_in_impacts + released - initial - work - projection; it is zero for exact "
                   "integration. projection is what closing the loops after steps brought in.")
      .def_prop_ro(
          "title", [](const SimulationObject& self) { return self.scenario().title; }, "Title of the scenario; may be empty.")
      .def_prop_ro(
          "name", [](const SimulationObject& self) { return self.scenario().name; },
          "Name of the scenario: that of its file without the ending.")
      .def_prop_ro(
          "until", [](const SimulationObject& self) { return self.scenario().until; },
          "End of the scenario's run (s): what `run` uses by default.")
      .def_prop_ro("_output_every", [](const SimulationObject& self) { return self.scenario().output_every; })
      .def_prop_ro(
          "warnings",
          [](const SimulationObject& self) {
            std::vector<std::string> all;
            for (const io::Diagnostic& each : self.warnings()) all.push_back(each.message());
            return all;
          },
          "What the reader of the file warned of, as text with file and line, and start values that loops and couplings changed.")
      .def("_model",
           [](const SimulationPtr& self) {
             const io::Scenario& s = self->scenario();
             return std::make_shared<ModelObject>(ModelObject{s.model, s.shapes, s.title, s.collision_shapes});
           })
      .def_prop_ro("_has_functions",
                   [](const SimulationPtr& self) {
                     const Use use(*self, Access::read);
                     return self->has_functions();
                   })
      .def_prop_ro("_hash", [](const SimulationObject& self) { return self.scenario().hash; })
      .def("set_state", &set_state, nb::kw_only(), "q"_a = nb::none(), "v"_a = nb::none(), "p"_a = nb::none(),
           "time"_a = nb::none(),
           "Set coordinates, velocities or momenta, and time. What is not given stays; without `v` and `p` the velocities "
           "stay.\n\n"
           "Args:\n    q: Coordinates (rad, m, quaternions), shape (nq,); quaternions are normalised.\n"
           "    v: Velocities (rad/s, m/s), shape (nv,).\n"
           "    p: Canonical momenta (N m s, N s), shape (nv,), equation (19) of the paper; instead of `v`.\n"
           "    time: s, not negative. With it a new run begins: events, energy ledger and history start here; without it the\n"
           "        run goes on, and the energy that this adds counts as work.\n\n"
           "Raises:\n    Error: A shape is wrong, a number is not finite, or `v` and `p` are both given; nothing has changed.")
      .def("step", &make_step, "dt"_a = nb::none(),
           "Step the world, with the events that are due. It records nothing. Releases the GIL.\n\n"
           "Args:\n    dt: Length (s, or a string with a unit), positive; default: the step of the integration.\n\n"
           "Raises:\n    RunError: The step diverged, stalled, or an action was refused.")
      .def("_drive", &drive_joint, "joint"_a, "function"_a.none())
      .def("_force", &act_on, "body"_a, "function"_a.none())
      .def("_add", &add_body, "name"_a, "parent"_a.none(), "fields"_a)
      .def(
          "remove",
          [](const SimulationPtr& self, nb::handle body) {
            const Use use(*self, Access::change);
            self->simulation().remove(body_of(self->simulation().world(), *self, body));
          },
          "body"_a,
          "Remove a body and all bodies outboard of it from the world; the joint that carries it breaks first.\n\n"
          "Args:\n    body: Name or handle. Names and numbers of removed bodies are not used again.\n\n"
          "Raises:\n    Error: The name is unknown, or the handle is of another simulation.")
      .def(
          "set_gravity",
          [](const SimulationPtr& self, nb::handle gravity) {
            const Use use(*self, Access::change);
            self->simulation().set_gravity(to_vec3(gravity, "gravity"));
          },
          "gravity"_a,
          "Change gravity from now on. The resulting change of potential energy counts as work; the history of `keep_history` "
          "ends.\n\n"
          "Args:\n    gravity: m/s², world axes, shape (3,).\n\n"
          "Raises:\n    Error: It is not three finite numbers.");
  def_array(
      simulation, "q", {&StateArrays::q, &StateViews::q},
      "Coordinates (rad, m, quaternions w, x, y, z), shape (nq,), packed by joint number: a `StateView`, which follows the "
      "state.\n\n"
      "Numbers that are written, or an array that is assigned, are taken over by the next operation, with velocities kept.");
  def_array(simulation, "v", {&StateArrays::v, &StateViews::v},
            "Velocities (rad/s, m/s), shape (nv,), packed by joint number: a `StateView`, which can be written like `q`.");
  def_array(simulation, "p", {&StateArrays::p, &StateViews::p},
            "Canonical momenta (N m s, N s), shape (nv,), packed by joint number, equation (19) of the paper: p = M v.\n\n"
            "A `StateView`; momenta that are written are taken over as they are.");
  def_array(simulation, "effort", {&StateArrays::effort, &StateViews::effort},
            "Extra efforts along the degrees of freedom (N m, N), shape (nv,), packed by joint number: a `StateView`.\n\n"
            "Numbers that are written act, in addition to drives and springs, until they are changed or their joint breaks.");
  register_equations(simulation);
  register_events(m, simulation);
  register_history(m, simulation);
}

}  // namespace momentree::python
