#include <momentree/results/results.hpp>

#include <cmath>
#include <new>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/results/hdf5/hdf5_results.hpp>

namespace momentree::io {

namespace {

TableChoice choice_of(const Simulation& simulation, const RecordOptions& options) {
  const bool contacts = options.reactions && !simulation.world().model().colliders().empty();
  return {options.joints, options.reactions, options.energy, contacts};
}

std::vector<std::string> files_of(const Simulation& simulation, const RecordOptions& options) {
  std::vector<std::string> files = RunTables::files(simulation.world().model(), choice_of(simulation, options));
  files.insert(files.end(), {"summary.json", "model.json", "final.json"});
  if (!options.meshes.empty()) files.emplace_back("meshes.json");
  if (options.report) files.emplace_back("report.html");
  if (options.hdf5) files.insert(files.end(), {"results.h5", "results.h5.partial"});
  if (options.input) files.emplace_back(checkpoint_file);
  return files;
}

std::unique_ptr<ResultDirectory> take_up(Interrupted& from, const Simulation& simulation, const RecordOptions& options) {
  const RecorderState& record = from.checkpoint.record;
  if (!RunTables::fit(simulation.world(), choice_of(simulation, options), record) ||
      record.events_taken > from.checkpoint.run.events.size())
    throw_error({"this checkpoint is of other tables", from.path, "run without --resume to start again from the beginning"});
  require_fit(simulation, from.checkpoint, from.path);
  from.directory->take_up();
  return std::move(from.directory);
}

}  // namespace

Recorder::Recorder(const Simulation& simulation, RunOrigin origin, RecordOptions options,
                   std::unique_ptr<ResultDirectory> directory, const RecorderState* from)
    : simulation_(simulation),
      origin_(std::move(origin)),
      options_(std::move(options)),
      directory_(std::move(directory)),
      tables_(*directory_, simulation.world(), choice_of(simulation, options_), options_.input.has_value(), from) {}

Recorder::Recorder(const Simulation& simulation, RunOrigin origin, std::string_view model_json, RecordOptions options)
    : Recorder(simulation, std::move(origin), options,
               std::make_unique<ResultDirectory>(options.directory, files_of(simulation, options), options.lasting), nullptr) {
  try {
    write_running_summary();
    directory_->write("model.json", model_json);
    if (!options_.meshes.empty()) directory_->write("meshes.json", options_.meshes);
    if (options_.input) {
      static_cast<void>(directory_->file(checkpoint_file));
      directory_->to_disk();
    }
    tables_.flush();
    directory_->keep();
  } catch (const Error& error) {  // the file that it names is removed with the folder
    status_ = "not begun";
    throw_error({"the results could not be begun: " + error.problem, options_.directory, error.hint});
  } catch (...) {
    status_ = "not begun";
    throw;
  }
}

Recorder::Recorder(const Simulation& simulation, RunOrigin origin, RecordOptions options, Interrupted& from)
    : Recorder(simulation, std::move(origin), options, take_up(from, simulation, options), &from.checkpoint.record) {
  const RecorderState& record = from.checkpoint.record;
  next_ = record.next, row_time_ = record.row_time, events_taken_ = record.events_taken;
  write_running_summary();
}

void Recorder::write_running_summary() {
  const std::string running = summary_json(origin_, "running, or killed");
  directory_->write("summary.json", running);
  constexpr std::size_t results = 2048, message = 8192;  // space for the rest of the summary
  directory_->reserve(running.size() + results + message);
}

RecorderState Recorder::state() {
  RecorderState state;
  tables_.save(state);
  state.next = next_, state.row_time = row_time_, state.events_taken = events_taken_;
  return state;
}

bool Recorder::save(double every) noexcept {
  if (failed_) return false;
  return attempt([&] {
    MT_REQUIRE(options_.input.has_value(), "the recorder was told what checkpoints belong to");
    const Checkpoint checkpoint{*options_.input, every, simulation_.run_state(), state()};
    try {
      directory_->write(checkpoint_file, checkpoint_bytes(checkpoint));
      directory_->to_disk();
    } catch (const Error& error) {
      if (warnings_.empty())
        warnings_.push_back((error.where.empty() ? "" : error.where + ": ") + "warning: no checkpoint: " + error.problem);
    }
  });
}

bool Recorder::due(double time) {
  if (!(options_.every > 0)) return true;
  const double slack = 1e-6 * options_.every;  // steps reach multiples up to rounding
  if (time < next_ * options_.every - slack) return false;
  next_ = std::floor((time + slack) / options_.every) + 1;
  return true;
}

void Recorder::take_events() {
  const std::vector<Event>& all = simulation_.events();
  for (; events_taken_ < all.size(); ++events_taken_) tables_.add(all[events_taken_]);
}

void Recorder::write_out_where_due() {
  using namespace std::chrono_literals;
  const Clock::time_point now = Clock::now();
  if (!tables_.is_full() && now - written_out_ < 1s) return;
  written_out_ = now;
  tables_.flush();
}

void Recorder::write_row(const World& world) {
  const bool replaces = row_time_ == world.time();
  if (!replaces) write_out_where_due();  // the last row is final: no other row has its time
  take_events();
  tables_.row(world, simulation_.energy(), replaces);
  row_time_ = world.time();
}

Recorder::~Recorder() {
  if (status_.empty()) abandon("failed: the program ended early");
}

// Without memory, the message may be lost, too.
void Recorder::note(const char* what) noexcept {
  failed_ = true;
  try {
    if (!error_) error_ = Error{what, "", ""};
  } catch (const std::bad_alloc&) {
  }
}

template <class Action>
bool Recorder::attempt(const Action& action) noexcept {
  try {
    action();
    return true;
  } catch (Error& error) {
    failed_ = true;
    if (!error_) error_ = std::move(error);
  } catch (const std::bad_alloc&) {
    note("out of memory");
  } catch (const std::exception& error) {
    note(error.what());
  }
  return false;
}

bool Recorder::observe(const World& world) noexcept {
  return attempt([&] {
    if (row_time_ == world.time() || due(world.time())) write_row(world);
  });
}

// Rows whose events are not in events.jsonl would show a topology that did not exist.
void Recorder::close_tables() {
  const bool events = attempt([&] { tables_.events().close(options_.lasting); });
  for (RunTables::File& table : tables_.tables()) {
    if (!events) table.file.text().clear();
    attempt([&] { table.file.close(options_.lasting); });
  }
}

// summary.json comes last: the report contains its text, and all files it refers to are complete.
void Recorder::seal(const std::string& status, const ReportPage& report) {
  const auto say = [&] {
    status_ = failed_ && status == "done" ? "failed: " + reason() : status;
    summary_ = summary_json(origin_, status_, simulation_);
  };
  bool said = false;
  for (int tries = 0; !said && tries < 2; ++tries) {  // a second time with the error of the first attempt
    if (sealed_) directory_->remove("summary.json");
    directory_->remove("report.html");
    has_report_ = false;
    if (!attempt(say)) continue;
    has_report_ = report && attempt([&] { directory_->write("report.html", report(directory_->working(), summary_)); });
    said = attempt(say) && attempt([&] { directory_->write("summary.json", summary_, true); });
    sealed_ = sealed_ || said;
  }
  if (said) return;
  directory_->remove("report.html");
  has_report_ = false;
}

std::string Recorder::reason() const {
  if (!error_) return "out of memory";
  if (!error_->where.empty()) return error_->message();
  return error_->problem;
}

void Recorder::finish(const std::string& status, const Armed& armed, const ReportPage& report) {
  const std::string outcome = failed_ ? "done" : status;  // the run was stopped by the failure to write
  if (!failed_) attempt([&] { write_row(simulation_.world()); });
  close_tables();
  attempt([&] { directory_->write("final.json", state_json(simulation_.world(), armed, step_memory(simulation_))); });
  if (options_.hdf5 && !failed_ && status == "done")
    attempt([&] {
      for (const char* name : {"results.h5", "results.h5.partial"}) directory_->file(name);
      write_hdf5_results(directory_->working(), origin_, simulation_.world(), options_.joints, options_.lasting);
    });
  seal(outcome, report);
  if (failed_ || status != "done") return;
  // Checkpoints and tables in CSV go only when the result is in its place: a run that is killed before that can be resumed.
  std::vector<std::string> warnings;
  published_ = attempt([&] {
    std::vector<const char*> temporary;
    if (options_.input) temporary.push_back(checkpoint_file);
    if (options_.hdf5)
      for (const RunTables::File& table : tables_.tables()) temporary.push_back(table.name.c_str());
    warnings = directory_->publish(temporary);
  });
  if (!published_) return seal(outcome, report);
  warnings_.swap(warnings);
  try {
    for (std::string& warning : warnings) warnings_.push_back(std::move(warning));  // of checkpoints
  } catch (const std::bad_alloc&) {
  }
}

void Recorder::abandon(const char* status) noexcept {
  close_tables();
  failed_ = true;
  attempt([&] {
    status_ = status;
    summary_ = summary_json(origin_, status_);
    directory_->write("summary.json", summary_, true);
  });
}

std::string Recorder::directory() const { return (published_ ? directory_->destination() : directory_->working()).string(); }

}  // namespace momentree::io
