// Snapshots, history, branches, state documents, and runs that are recorded.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <cli/page.hpp>
#include <momentree/export/export.hpp>
#include <momentree/models/mesh/pack.hpp>
#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/run_record.hpp>
#include <momentree/scenario/state/state_document.hpp>
#include <momentree/tree/lasting_function.hpp>

#include "records.hpp"
#include "world_object.hpp"

namespace momentree::python {

namespace {

struct SnapshotObject {
  SimulationSnapshot snapshot;
  SimulationObject::Inputs inputs;
  std::shared_ptr<const io::Scenario> scenario;
};

// True for that of an unpickled simulation, too.
bool of_same_model(const SnapshotObject& snapshot, const SimulationObject& sim) {
  if (snapshot.scenario == sim.shared_scenario()) return true;
  const Model &one = snapshot.scenario->model, &other = sim.scenario().model;
  const auto same_name = [](const BodySpec& a, const BodySpec& b) { return a.name == b.name && a.joint_name == b.joint_name; };
  return snapshot.snapshot.world.engine.topology.model == other.compiled().topology().model &&
         std::ranges::equal(one.bodies(), other.bodies(), same_name) && one.colliders() == other.colliders();
}

struct RecordObject {
  std::shared_ptr<io::RunRecord> record;
  SnapshotObject end;  ///< with events and functions at the end of the run
  io::MeshSources meshes;
};

SnapshotObject snapshot(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  return {self->simulation().snapshot(), self->copy_inputs(), self->shared_scenario()};
}

void restore(const SimulationPtr& self, const SnapshotObject& to) {
  const Use use(*self, Access::change);
  if (!of_same_model(to, *self))
    refuse("the snapshot is of a simulation of another model",
           "restore it in the simulation that made it, or in a branch of that");
  self->simulation().restore(to.snapshot);
  self->set_inputs(to.inputs);
}

void undo(const SimulationPtr& self, std::ptrdiff_t number, bool again) {
  const Use use(*self, Access::change);
  const auto count = static_cast<std::ptrdiff_t>(self->simulation().events().size());
  const std::ptrdiff_t event = number < 0 ? count + number : number;
  if (count == 0) refuse("there is nothing to undo", "no event has happened");
  if (event < 0 || event >= count)
    refuse("there is no event " + std::to_string(number) + " to undo", "the last one has number " + std::to_string(count - 1));
  self->simulation().undo(static_cast<std::size_t>(event), again);
  self->set_inputs(self->copy_inputs());
}

std::string state_json(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  return io::state_json(self->simulation().world(), self->armed(), step_memory(self->simulation()));
}

void restore_state(const SimulationPtr& self, const std::string& text, const std::string& name) {
  const Use use(*self, Access::change);
  const io::RestoredState state = io::read_state(text, name, first_model(self->simulation().world()));
  for (io::Diagnostic& warning : io::restore(self->simulation(), {state})) self->warn(std::move(warning));
  resume(self->simulation(), {}, state.memory);
}

constexpr io::CheckpointWords pickle_words{"this pickle", "pickle it again", "unpickle it with the version that wrote it"};

// Calls a function with each joint that a function drives, and the number of that.
template <class Act>
void each_driven(Topology& topology, Act act) {
  for (Topology::Changed& each : topology.changed)
    if (each.as.function >= 0) act(each.joint, each.as.function);
  for (Loop& each : topology.loops)
    if (each.joint.function >= 0) act(each.id().index, each.joint.function);
}

// In the bytes, the number of a function says which one the joint has: that of its elements, with an effort or without, or an
// effort alone.
enum : int { of_elements, of_effort };

// The contents of a checkpoint: a simulation continues from them bitwise identically. Within a run, as a branch would.
nb::bytes saved(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  io::Checkpoint all{{MOMENTREE_VERSION, {}, {}}, 0, self->simulation().run_state(), {}};
  Topology& topology = all.run.world.engine.topology;
  each_driven(topology, [&](int, int& function) {
    function = is_lasting(topology.functions[static_cast<std::size_t>(function)].get()) ? of_elements : of_effort;
  });
  all.scheduled = scheduled(self->simulation());
  all.efforts = self->efforts();
  const std::string bytes = io::checkpoint_bytes(all);
  return nb::bytes(bytes.data(), bytes.size());
}

// In a simulation that was made as that one was.
void go_on_from(const SimulationPtr& self, const nb::bytes& data) {
  const Use use(*self, Access::change);
  io::Checkpoint all = io::read_checkpoint({data.c_str(), data.size()}, "pickle", pickle_words);
  if (all.input.version != MOMENTREE_VERSION)
    throw_error({"this pickle was written by momentree " + all.input.version + ", and this is " MOMENTREE_VERSION, "pickle",
                 pickle_words.other_version});
  std::map<int, std::shared_ptr<SimulationObject::JointInput>> inputs;
  for (auto& [joint, efforts] : all.efforts)
    inputs[joint] = std::make_shared<SimulationObject::JointInput>(SimulationObject::JointInput{{}, std::move(efforts)});
  Simulation& sim = self->simulation();
  const Tree& start = sim.world().tree();
  Topology& topology = all.run.world.engine.topology;
  std::vector<int> others;  // took the numbers of joints that had elements, which end
  each_driven(topology, [&](int joint, int& number) {
    const int carrier = joint >= 0 && joint < start.bodies() ? start.carrier(joint) : -1;
    const JointFunction* own = carrier >= 0 ? start.function(carrier) : nullptr;
    if (number != of_elements && std::exchange(own, nullptr) != nullptr) others.push_back(joint);
    const auto input = inputs.find(joint);
    JointFunction function = joined(own, input == inputs.end() ? JointFunction() : drive_of(input->second));
    number = function ? static_cast<int>(topology.functions.size()) : -1;
    if (function) topology.functions.push_back(std::make_shared<const JointFunction>(std::move(function)));
  });
  schedule(sim, std::move(all.scheduled));
  io::require_fit(sim, all, "pickle", pickle_words);
  io::continue_run(sim, all);
  SimulationObject::Inputs named;
  for (const auto& [joint, input] : inputs) named.emplace(sim.world().joint_name({joint}), input);
  for (const int joint : others)
    if (const auto input = inputs.find(joint); input != inputs.end())
      sim.drive_all(std::string(sim.world().joint_name({joint})), drive_of(input->second));
  self->adopt(std::move(named));
}

// Runs and records: (record, how the run ended, why). The record is complete whatever happens.
nb::object run(const SimulationPtr& self, double until, double every, bool reactions, nb::object observer, nb::object progress,
               nb::handle finished) {
  std::shared_ptr<io::RunRecord> record;
  RunResult result;
  std::exception_ptr thrown;
  SnapshotObject end;
  io::MeshSources meshes;
  {
    const Use use(*self, Access::change);
    meshes = io::mesh_sources(self->scenario().shapes);
    Simulation& sim = self->simulation();
    record =
        std::make_shared<io::RunRecord>(sim, io::run_origin(self->scenario(), sim, until),
                                        io::model_json(sim.world(), self->scenario().title, self->scenario().shapes), reactions);
    if (until == HUGE_VAL && observer.is_none())
      refuse("nothing ends a run with infinite end time", "give it an observer that eventually returns False");
    sim.observe(every, [&](const World&) {
      record->observe(sim);
      if (observer.is_none()) return true;
      const nb::gil_scoped_acquire gil;
      const Within observing(*self, Inside::observer);
      const nb::object answer = observer(std::make_shared<WorldObject>(WorldObject{self}));
      return !answer.is(nb::bool_(false));
    });
    self->progress = std::move(progress);
    try {
      result = self->run_until(until);
    } catch (...) {
      thrown = std::current_exception();
      result = {Status::interrupted, "an exception ended the run"};
    }
    sim.observe(0, {});
    self->progress.reset();
    const std::string status = result.status == Status::ok            ? "done"
                               : result.status == Status::interrupted ? "interrupted at t = " + std::to_string(sim.time()) + " s"
                                                                      : result.reason;
    record->finish(sim, status, self->armed());
    end = {sim.snapshot(), self->copy_inputs(), self->shared_scenario()};
  }
  static const char* const words[] = {"ok", "diverged", "interrupted", "refused", "stalled"};
  finished(RecordObject{record, std::move(end), std::move(meshes)}, words[static_cast<int>(result.status)], result.reason);
  if (thrown) std::rethrow_exception(thrown);
  return nb::none();
}

std::string run_page(const RecordObject& self, const std::string& folder, bool report) {
  const io::ReportPage page = report ? io::ReportPage(&cli::report_of) : nullptr;
  const io::PackedMeshes meshes = io::meshes_json(self.meshes);
  for (const io::Diagnostic& warning : meshes.warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, warning.message().c_str(), 1) < 0) throw nb::python_error();
  return self.record->write(folder, page, meshes.json);
}

/// `folder`: for the result that the file is made from.
void export_run(const RecordObject& self, const std::string& folder, const std::string& file) {
  io::require_export_name(file);
  io::export_result(run_page(self, folder, false), file);
}

nb::object matrix(const std::vector<double>& numbers, std::size_t rows, std::size_t columns) {
  NewArray array = new_array(rows, columns);
  std::copy(numbers.begin(), numbers.end(), array.data);
  return std::move(array.object);
}

nb::dict joint_rows(const RecordObject& self, const std::string& name) {
  const io::JointRows rows = self.record->joint(name);
  const std::size_t n = self.record->rows();
  nb::dict all;
  all["q"] = matrix(rows.q, n, rows.nq), all["v"] = matrix(rows.v, n, rows.nv), all["p"] = matrix(rows.p, n, rows.nv);
  if (self.record->has_reactions()) all["a"] = matrix(rows.a, n, rows.nv), all["wrench"] = matrix(rows.wrench, n, 6);
  return all;
}

}  // namespace

void register_history(nb::module_& m, SimulationClass& simulation) {
  nb::class_<SnapshotObject>(
      m, "Snapshot", nb::dynamic_attr(),
      "The complete state of a simulation at an instant; `Simulation.restore` returns to it, exact to the last bit.")
      .def_prop_ro(
          "time", [](const SnapshotObject& s) { return s.snapshot.world.engine.time; }, "Time of the snapshot (s).");
  nb::class_<RecordObject>(m, "_Record")
      .def_prop_ro("rows", [](const RecordObject& r) { return r.record->rows(); })
      .def_prop_ro("time", [](const RecordObject& r) { return copy_of(r.record->times()); })
      .def_prop_ro("status", [](const RecordObject& r) { return r.record->status(); })
      .def_prop_ro("summary", [](const RecordObject& r) { return r.record->summary(); })
      .def_prop_ro("final_state", [](const RecordObject& r) { return r.record->final_state(); })
      .def_prop_ro("has_reactions", [](const RecordObject& r) { return r.record->has_reactions(); })
      .def_prop_ro("joint_names", [](const RecordObject& r) { return r.record->joints(); })
      .def_prop_ro("body_names",
                   [](const RecordObject& r) {
                     std::vector<std::string> names;
                     for (const BodySpec& body : r.record->model().bodies()) names.push_back(body.name);
                     return names;
                   })
      .def_prop_ro("spring_names",
                   [](const RecordObject& r) {
                     std::vector<std::string> names;
                     for (const Spring& spring : r.record->model().springs()) names.push_back(spring.name);
                     return names;
                   })
      .def("spring",
           [](const RecordObject& r, const std::string& name) { return matrix(r.record->spring(name), r.record->rows(), 3); })
      .def_prop_ro("contacts", [](const RecordObject& r) { return r.record->contact_table(); })
      .def_prop_ro("energy_columns", [](const RecordObject&) { return io::RunRecord::energy_columns(); })
      .def_prop_ro("events",
                   [](const RecordObject& r) {
                     nb::list list;
                     for (const Event& event : r.record->events()) list.append(event_record(event));
                     return list;
                   })
      .def("joint", &joint_rows)
      .def("body",
           [](const RecordObject& r, const std::string& name) {
             return matrix(r.record->body(r.record->model().body(name)), r.record->rows(), 13);
           })
      .def("energies",
           [](const RecordObject& r) {
             return matrix(r.record->energies(), r.record->rows(), io::RunRecord::energy_columns().size());
           })
      .def("write", [](const RecordObject& r, const std::string& folder, bool report) { return run_page(r, folder, report); })
      .def("export", &export_run)
      .def("state", [](const RecordObject& r, std::size_t row) {
        if (row >= r.record->rows()) throw nb::index_error("no such row");
        SnapshotObject snapshot = r.end;
        snapshot.snapshot = r.record->snapshot(row);
        return snapshot;
      });
  simulation.def("_snapshot", &snapshot)
      .def("_restore", &restore, "snapshot"_a)
      .def("_saved", &saved)
      .def("_go_on_from", &go_on_from)
      .def(
          "keep_history",
          [](const SimulationPtr& self, std::optional<std::size_t> most) {
            const Use use(*self, Access::change);
            self->simulation().keep_history(most.value_or(std::numeric_limits<std::size_t>::max()));
          },
          "most"_a = nb::none(),
          "From now on, keep a snapshot from before every event, so that `undo` can return to it.\n\n"
          "Args:\n    most: Only before the last events; default: all. Without this call the last 100 are kept.")
      .def("undo", &undo, "number"_a = -1, "again"_a = false,
           "Return to just before an event happened: one of the last 100, or of those that `keep_history` kept.\n\n"
           "Args:\n    number: Of the event in `events`; negative numbers count from the end.\n"
           "    again: Let the actions scheduled for that instant happen again; otherwise the run takes another branch.\n\n"
           "Raises:\n    Error: There is no such event, or the history does not reach back that far.")
      .def("state_json", &state_json,
           "The state document (JSON) of this instant: topology, coordinates, momenta, and conditions that are armed.\n\n"
           "`momentree.load(…, state=…)` continues from it with the same bits; `restore_state` restores the motion, not which "
           "events happened. `effort` and Python functions are not in it.")
      .def("restore_state", &restore_state, "text"_a, "name"_a = "state.json",
           "Return to the state of a document.\n\n"
           "Args:\n    text: A state document (JSON) of a simulation of the same model.\n"
           "    name: Of the document, for messages.\n\n"
           "Raises:\n    Error: The document has errors, or is of another model; nothing has changed.")
      .def("_run", &run, "until"_a, "every"_a, "reactions"_a, "observer"_a.none(), "progress"_a.none(), "finished"_a);
}

}  // namespace momentree::python
