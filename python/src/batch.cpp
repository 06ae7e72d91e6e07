// Batch: many worlds of one model as arrays.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include <momentree/batch/batch.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/scenario/part_reader.hpp>

#include "model_object.hpp"
#include "records.hpp"

namespace momentree::python {

namespace {

struct BatchObject {
  BatchObject(const Model& given, int worlds, const BatchOptions& options) : batch(given, worlds, options), start(given) {}
  Batch batch;
  World start;  // for names in actions
  std::atomic<bool> busy{false};
};

// One operation on a batch.
class UseBatch {
 public:
  explicit UseBatch(BatchObject& object) : object_(object) {
    if (object_.busy.exchange(true, std::memory_order_acquire))
      refuse("the batch is being used by another thread", "wait for it, or make another batch");
  }
  ~UseBatch() { object_.busy.store(false, std::memory_order_release); }
  UseBatch(const UseBatch&) = delete;
  UseBatch& operator=(const UseBatch&) = delete;

 private:
  BatchObject& object_;
};

using Worlds = std::vector<int>;

void check_worlds(const BatchObject& self, const Worlds& worlds) {
  for (const int world : worlds)
    if (world < 0 || world >= self.batch.worlds())
      refuse("there is no world " + std::to_string(world),
             "the worlds are numbered from 0 to " + std::to_string(self.batch.worlds() - 1));
}

// The common width of some worlds' rows.
std::pair<std::size_t, std::size_t> widths(const BatchObject& self, const Worlds& worlds) {
  check_worlds(self, worlds);
  if (worlds.empty()) return {0, 0};
  for (const int world : worlds)
    if (self.batch.group(world) != self.batch.group(worlds.front()))
      refuse("these worlds have different topologies", "batch.groups has the worlds of each topology, with their arrays");
  return {static_cast<std::size_t>(self.batch.nq(worlds.front())), static_cast<std::size_t>(self.batch.nv(worlds.front()))};
}

nb::object read_rows(BatchObject& self, const Worlds& worlds, const std::string& which) {
  const UseBatch use(self);
  const auto [nq, nv] = widths(self, worlds);
  if (which == "time") {
    NewArray array = new_array(worlds.size());
    for (std::size_t i = 0; i < worlds.size(); ++i) array.data[i] = self.batch.time(worlds[i]);
    return std::move(array.object);
  }
  NewArray array = new_array(worlds.size(), which == "q" ? nq : nv);
  if (!worlds.empty())
    self.batch.read(worlds, nullptr, which == "q" ? array.data : nullptr, which == "p" ? array.data : nullptr,
                    which == "v" ? array.data : nullptr);
  return std::move(array.object);
}

nb::object times(BatchObject& self) {
  const UseBatch use(self);
  NewArray array = new_array(static_cast<std::size_t>(self.batch.worlds()));
  for (int world = 0; world < self.batch.worlds(); ++world) array.data[world] = self.batch.time(world);
  return std::move(array.object);
}

void write_rows(BatchObject& self, const Worlds& worlds, nb::handle q, nb::handle v, nb::handle p, nb::handle time) {
  const UseBatch use(self);
  const auto [nq, nv] = widths(self, worlds);
  if (worlds.empty()) return;
  if (!v.is_none() && !p.is_none())
    refuse("set_state: both v and p are given", "momenta follow from velocities: give one of them");
  const std::size_t n = worlds.size();
  std::vector<double> coordinates, rates, instants;
  if (!q.is_none()) coordinates = rows_of(q, n, nq, "q");
  if (!time.is_none()) instants = numbers_of(time, n, 0, "time");
  const auto or_null = [](const std::vector<double>& numbers) { return numbers.empty() ? nullptr : numbers.data(); };
  if (!p.is_none()) {
    rates = rows_of(p, n, nv, "p");
  } else if (!v.is_none()) {
    rates = rows_of(v, n, nv, "v");
  } else if (!q.is_none()) {  // writing q alone keeps the velocities
    rates.resize(n * nv);
    self.batch.read(worlds, nullptr, nullptr, nullptr, rates.data());
  }
  self.batch.write(worlds, or_null(instants), or_null(coordinates), or_null(rates),
                   p.is_none() ? Variables::velocities : Variables::momenta);
}

std::vector<bool> worlds_away(const Batch& batch) {
  std::vector<bool> all;
  for (int world = 0; world < batch.worlds(); ++world) all.push_back(batch.diverged(world));
  return all;
}

// A RuntimeWarning that names the worlds that went away since `before`, if there are some.
void warn_of_diverged(const Batch& batch, const std::vector<bool>& before) {
  int first = -1, count = 0;
  for (int world = batch.worlds() - 1; world >= 0; --world)
    if (batch.diverged(world) && !before[static_cast<std::size_t>(world)]) first = world, ++count;
  if (count == 0) return;
  const std::string others = count == 1 ? "" : count == 2 ? " and 1 other" : " and " + std::to_string(count - 1) + " others";
  const std::string text = "world " + std::to_string(first) + others + " stopped: " + batch.message(first) +
                           (count == 1 ? "" : "; batch.diverged has all of them");
  if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) < 0) throw nb::python_error();
}

void step_worlds(BatchObject& self, nb::handle h) {
  const UseBatch use(self);
  double all = 0;
  if (nb::try_cast(h, all)) {
    if (!(all >= 0) || all == std::numeric_limits<double>::infinity())
      refuse("a step is a finite number of seconds, not negative");
    const std::vector<bool> before = worlds_away(self.batch);
    {
      const nb::gil_scoped_release free;
      self.batch.step(all);
    }
    return warn_of_diverged(self.batch, before);
  }
  const std::vector<double> each = numbers_of(h, static_cast<std::size_t>(self.batch.worlds()), 0, "h");
  if (std::any_of(each.begin(), each.end(), [](double x) { return x < 0; })) refuse("a step can't be negative");
  const std::vector<bool> before = worlds_away(self.batch);
  {
    const nb::gil_scoped_release free;
    self.batch.step(each);
  }
  warn_of_diverged(self.batch, before);
}

void run_steps(BatchObject& self, double h, std::int64_t count) {
  const UseBatch use(self);
  if (!(h > 0) || h == std::numeric_limits<double>::infinity()) refuse("a step is a finite, positive number of seconds");
  const std::vector<bool> before = worlds_away(self.batch);
  for (std::int64_t k = 0; k < count;) {
    {
      const nb::gil_scoped_release free;
      for (const std::int64_t end = std::min(count, k + 64); k < end; ++k) self.batch.step(h);
    }
    if (PyErr_CheckSignals() != 0) nb::raise_python_error();
  }
  warn_of_diverged(self.batch, before);
}

nb::list apply_in_worlds(BatchObject& self, const Worlds& worlds, const std::vector<std::pair<std::string, nb::object>>& given,
                         const std::string& name) {
  const UseBatch use(self);
  check_worlds(self, worlds);
  std::vector<Action> actions;
  for (const auto& [key, value] : given) {
    const std::string call = "momentree." + key;
    for (Action& action : io::PartReader(call).actions(key, to_value(value, call), {}, self.start))
      actions.push_back(std::move(action));
  }
  nb::list events;
  for (const int world : worlds) events.append(event_record(self.batch.apply(world, actions, name)));
  return events;
}

void set_efforts(BatchObject& self, const Worlds& worlds, nb::handle efforts) {
  const UseBatch use(self);
  const auto [nq, nv] = widths(self, worlds);
  if (!worlds.empty()) self.batch.set_efforts(worlds, rows_of(efforts, worlds.size(), nv, "effort").data());
}

void reset(BatchObject& self, const Worlds& worlds) {
  const UseBatch use(self);
  check_worlds(self, worlds);
  self.batch.reset(worlds);
}

BodyId body_of(const BatchObject& self, const std::string& body) {
  const Model& model = self.start.model();
  if (!model.has_body(body)) {
    std::vector<std::string> names;
    for (const BodySpec& each : model.bodies()) names.push_back(each.name);
    refuse("there is no body '" + body + "'", did_you_mean(body, names));
  }
  return model.body(body);
}

nb::object motions(BatchObject& self, const std::string& body) {
  const UseBatch use(self);
  Worlds worlds(static_cast<std::size_t>(self.batch.worlds()));
  std::iota(worlds.begin(), worlds.end(), 0);
  const BodyId id = body_of(self, body);
  NewArray array = new_array(worlds.size(), 13);
  self.batch.motions(worlds, id, array.data);
  return std::move(array.object);
}

nb::list contacts(BatchObject& self, int world) {
  const UseBatch use(self);
  check_worlds(self, {world});
  return contact_records(self.batch.contacts(world), self.start.model());
}

nb::object contact_forces(BatchObject& self, const std::string& body, const Worlds& worlds) {
  const UseBatch use(self);
  check_worlds(self, worlds);
  const BodyId id = body == "ground" ? ground : body_of(self, body);
  NewArray array = new_array(worlds.size(), 3);
  self.batch.contact_forces(worlds, id, array.data);
  return std::move(array.object);
}

nb::list events(BatchObject& self, int world) {
  const UseBatch use(self);
  check_worlds(self, {world});
  nb::list all;
  for (const Event& event : self.batch.events(world)) all.append(event_record(event));
  return all;
}

std::string message(BatchObject& self, int world) {
  const UseBatch use(self);
  check_worlds(self, {world});
  return self.batch.message(world);
}

// Where a joint's numbers are in the rows of a world: kind, first of q, number, first of v, number; None if it is not in the
// tree.
nb::object layout(BatchObject& self, int world, const std::string& joint) {
  const UseBatch use(self);
  check_worlds(self, {world});
  const Tree& tree = self.batch.tree(world);
  const std::optional<JointId> id = self.batch.find_joint(world, joint);
  if (!id || is_loop(*id)) return nb::none();
  const int body = tree.carrier(*id).index;
  const KindInfo& kind = info(tree.kind(body));
  return nb::make_tuple(kind.name, tree.first_q(body), kind.nq, tree.first_p(body), kind.nv);
}

// Coordinates and velocities of a joint that closes a loop, of worlds of one topology; None if it does not close one there.
nb::object loop_rows(BatchObject& self, const Worlds& worlds, const std::string& joint) {
  const UseBatch use(self);
  widths(self, worlds);
  const std::optional<JointId> id = self.batch.find_joint(worlds.at(0), joint);
  if (!id || !is_loop(*id)) return nb::none();
  const Loop* const loop = self.batch.tree(worlds[0]).loops().find(*id);
  const KindInfo& kind = info(loop->joint.kind);
  NewArray q = new_array(worlds.size(), static_cast<std::size_t>(kind.nq)),
           v = new_array(worlds.size(), static_cast<std::size_t>(kind.nv));
  self.batch.read_loop(worlds, *id, q.data, v.data);
  return nb::make_tuple(kind.name, q.object, v.object);
}

nb::tuple start_layout(BatchObject& self, const std::string& joint) {
  const Model& model = self.start.model();
  const KindInfo& kind = info(model.joint_spec(model.joint(joint)).kind);
  return nb::make_tuple(kind.name, kind.nq, kind.nv);
}

std::vector<int> groups(BatchObject& self) {
  const UseBatch use(self);
  std::vector<int> all;
  for (int world = 0; world < self.batch.worlds(); ++world) all.push_back(self.batch.group(world));
  return all;
}

std::vector<bool> diverged(BatchObject& self) {
  const UseBatch use(self);
  return worlds_away(self.batch);
}

void construct(BatchObject* self, const ModelObject& model, int worlds, int threads, const std::string& precision,
               const std::optional<std::string>& variables, const std::string& contact_method, double step) {
  BatchOptions options;
  if (precision == "float32")
    options.precision = Precision::float32;
  else if (precision != "float64")
    refuse("unknown precision '" + precision + "'", "\"float64\" or \"float32\"");
  if (variables) {
    options.variables = variables_of(*variables);
    if (!options.variables) refuse("unknown variables '" + *variables + "'", "\"momenta\" or \"velocities\"");
  }
  options.threads = threads;
  options.contact_method = contact_method, options.step = step;
  const Tree& tree = model.model.compiled();
  const double simulation = model.model.has_contact() ? 8e3 + 4e3 * tree.bodies() : 0;  // at least
  const double bytes = static_cast<double>(worlds) * (16.0 * (tree.nq() + tree.nv()) + 64 + simulation);
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (bytes > 0.8 * memory)  // the system would end the process instead of refusing
    refuse("not enough memory for " + std::to_string(worlds) + " worlds: they take " +
               std::to_string(static_cast<long>(bytes / 1e9)) + " GB",
           "step them in several batches");
  new (self) BatchObject(model.model, worlds, options);
}

}  // namespace

void register_batch(nb::module_& m) {
  nb::class_<BatchObject>(m, "BatchBase")
      .def("__init__", &construct, "model"_a, "worlds"_a, "threads"_a, "precision"_a, "variables"_a.none(), "contact_method"_a,
           "step"_a)
      .def("__len__", [](const BatchObject& self) { return self.batch.worlds(); })
      .def_prop_ro(
          "lanes", [](const BatchObject& self) { return self.batch.lanes(); },
          "Worlds that one vector of the CPU holds; 1: worlds are stepped one by one.")
      .def_prop_ro(
          "variables", [](const BatchObject& self) { return name_of(self.batch.variables()); },
          "What the states of worlds without closed loops hold: \"momenta\" or \"velocities\".")
      .def_prop_ro(
          "threads", [](const BatchObject& self) { return self.batch.threads(); }, "Number of threads that step the worlds.")
      .def("step", &step_worlds, "h"_a,
           "Step the worlds. A world that diverges stays where it was: see `diverged`. Releases the GIL.\n\n"
           "Args:\n    h: s, not negative: one number for every world, or shape (worlds,).\n\n"
           "Raises:\n    Error: A step is negative or not finite, or another thread is using the batch.\n\n"
           "Warns:\n    RuntimeWarning: A world diverged, for every world once.")
      .def("run", &run_steps, "h"_a, "steps"_a,
           "Make many steps in every world. Releases the GIL; Ctrl-C ends it between steps.\n\n"
           "Args:\n    h: Length of a step (s), positive.\n    steps: How many.\n\n"
           "Raises:\n    Error: A step is not positive or not finite, or another thread is using the batch.\n\n"
           "Warns:\n    RuntimeWarning: A world diverged, for every world once.")
      .def_prop_ro("time", &times, "Times of the worlds (s), shape (worlds,), a copy.")
      .def("_read", &read_rows)
      .def("_write", &write_rows, "worlds"_a, "q"_a.none(), "v"_a.none(), "p"_a.none(), "time"_a.none())
      .def("_apply", &apply_in_worlds)
      .def("_set_efforts", &set_efforts)
      .def("_reset", &reset)
      .def("_motions", &motions)
      .def("contacts", &contacts, "world"_a,
           "The points at which bodies touch in a world, with their forces: a list of `Contact`.\n\n"
           "After its state or topology was set: those with which the next step begins.\n\n"
           "Args:\n    world: Its number.\n\n"
           "Raises:\n    Error: There is no such world, or another thread is using the batch.")
      .def("events", &events, "world"_a,
           "What happened in a world that is stepped one by one since its last step began: a list of `Event`.\n\n"
           "Events of contacts, stops and strengths, and of `apply`. Worlds in lanes have none.\n\n"
           "Args:\n    world: Its number.\n\n"
           "Raises:\n    Error: There is no such world, or another thread is using the batch.")
      .def("message", &message, "world"_a,
           "Why the last step of a world was impossible, see `diverged`; empty if it was not.\n\n"
           "Args:\n    world: Its number.\n\n"
           "Raises:\n    Error: There is no such world, or another thread is using the batch.")
      .def("_contact_forces", &contact_forces)
      .def("_layout", &layout)
      .def("_loop_rows", &loop_rows)
      .def("_start_layout", &start_layout)
      .def("_groups", &groups)
      .def("_diverged", &diverged);
}

}  // namespace momentree::python
