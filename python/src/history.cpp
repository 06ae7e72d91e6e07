// Snapshots, history, branches, state documents, and runs that are recorded.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <cli/page.hpp>
#include <momentree/export/export.hpp>
#include <momentree/models/mesh/pack.hpp>
#include <momentree/results/checkpoint/checkpoint.hpp>
#include <momentree/results/model_json.hpp>
#include <momentree/results/run_record.hpp>
#include <momentree/scenario/state/state_document.hpp>

#include "records.hpp"
#include "world_object.hpp"

namespace momentree::python {

namespace {

struct SnapshotObject {
  SimulationSnapshot snapshot;
  SimulationObject::Inputs inputs;
  std::weak_ptr<const io::Scenario> scenario;
};

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
  if (to.scenario.lock() != self->shared_scenario())
    refuse("the snapshot is of a simulation of another model",
           "restore it in the simulation that made it, or in a branch of that");
  self->simulation().restore(to.snapshot);
  self->set_inputs(to.inputs);
}

void undo(const SimulationPtr& self, std::ptrdiff_t number, bool again) {
  const Use use(*self, Access::change);
  const auto count = static_cast<std::ptrdiff_t>(self->simulation().events().size());
  const std::ptrdiff_t event = number < 0 ? count + number : number;
  if (event < 0 || event >= count)
    refuse("there is no event " + std::to_string(number) + " to undo", std::to_string(count) + " events have happened");
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

// What a checkpoint has of a run: the simulation goes on from it to the same bits.
nb::bytes saved(const SimulationPtr& self) {
  const Use use(*self, Access::read);
  io::Checkpoint state;
  state.run = self->simulation().run_state();
  const std::string bytes = io::checkpoint_bytes(state);
  return nb::bytes(bytes.data(), bytes.size());
}

void go_on_from(const SimulationPtr& self, const nb::bytes& bytes) {
  const Use use(*self, Access::change);
  try {
    io::Checkpoint state = io::read_checkpoint({bytes.c_str(), bytes.size()}, "pickle");
    // Functions of the model's elements are there already; `effort` is set anew.
    Topology& topology = state.run.world.engine.topology;
    const int known = static_cast<int>(self->simulation().world().tree().topology().functions.size());
    const auto keep_known = [known](Joint& joint) { joint.function = joint.function < known ? joint.function : -1; };
    for (Topology::Changed& changed : topology.changed) keep_known(changed.as);
    for (Loop& loop : topology.loops) keep_known(loop.joint);
    io::require_fit(self->simulation(), state, "pickle");
    io::continue_run(self->simulation(), state);
  } catch (const Error& error) {
    refuse("the pickled simulation can't go on: " + error.problem, "unpickle it with the version that pickled it");
  }
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
