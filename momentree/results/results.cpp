#include <momentree/results/results.hpp>

#include <cmath>
#include <new>
#include <utility>

#include <momentree/base/check.hpp>
#include <momentree/integrate/integrator.hpp>
#include <momentree/results/columns/contact_columns.hpp>
#include <momentree/results/columns/energy_columns.hpp>
#include <momentree/results/columns/spring_columns.hpp>
#include <momentree/results/hdf5/hdf5_results.hpp>

namespace momentree::io {

namespace {

bool writes_contacts(const Simulation& simulation, const RecordOptions& options) {
  return options.reactions && !simulation.world().model().colliders().empty();
}

std::vector<std::string> files_of(const Simulation& simulation, const RecordOptions& options) {
  std::vector<std::string> files = {"summary.json", "model.json", "events.jsonl", "bodies.csv", "joints.csv", "final.json"};
  if (options.energy) files.emplace_back("energy.csv");
  if (simulation.world().springs() > 0) files.emplace_back("springs.csv");
  if (writes_contacts(simulation, options)) files.emplace_back("contacts.csv");
  if (!options.meshes.empty()) files.emplace_back("meshes.json");
  if (options.report) files.emplace_back("report.html");
  if (options.hdf5) files.insert(files.end(), {"results.h5", "results.h5.partial"});
  if (options.input) files.emplace_back(checkpoint_file);
  return files;
}

TextFile open_table(ResultDirectory& folder, const char* name, const RecordOptions& options, const RecorderState::Table* from) {
  const std::string path = folder.file(name);
  if (from == nullptr) {
    TextFile made(path);
    if (options.input) made.keep_checksum();
    return made;
  }
  TextFile continued(path, from->mark);
  continued.text() = from->last;
  return continued;
}

std::unique_ptr<ResultDirectory> take_up(Interrupted& from, const Simulation& simulation, const RecordOptions& options) {
  const RecorderState& record = from.checkpoint.record;
  if (record.energy.has_value() != options.energy || record.springs.has_value() != (simulation.world().springs() > 0) ||
      record.contacts.has_value() != writes_contacts(simulation, options) ||
      record.body_quaternions.size() != static_cast<std::size_t>(simulation.world().model().size()) ||
      record.joint_quaternions.size() != options.joints.size() + 1 || record.events_taken > from.checkpoint.run.events.size())
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
      events_(open_table(*directory_, "events.jsonl", options_, from != nullptr ? &from->events : nullptr)),
      bodies_(open_table(*directory_, "bodies.csv", options_, from != nullptr ? &from->bodies : nullptr)),
      joints_(open_table(*directory_, "joints.csv", options_, from != nullptr ? &from->joints : nullptr)),
      body_columns_(simulation.world()),
      joint_columns_(options_.joints, options_.reactions) {
  if (options_.energy)
    energy_.emplace(open_table(*directory_, "energy.csv", options_, from != nullptr ? &*from->energy : nullptr));
  if (simulation.world().springs() > 0)
    springs_.emplace(open_table(*directory_, "springs.csv", options_, from != nullptr ? &*from->springs : nullptr));
  if (writes_contacts(simulation, options_))
    contacts_.emplace(open_table(*directory_, "contacts.csv", options_, from != nullptr ? &*from->contacts : nullptr));
}

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
    body_columns_.header(bodies_.text(), simulation.world().model());
    joint_columns_.header(joints_.text());
    if (energy_) energy_header(energy_->text());
    if (springs_) spring_header(springs_->text(), simulation.world().model());
    if (contacts_) contact_header(contacts_->text());
    each_table([](TextFile& table, std::size_t&) { table.flush(); });
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
  body_columns_.quaternions().continue_from(record.body_quaternions);
  joint_columns_.quaternions().continue_from(record.joint_quaternions);
  write_running_summary();
}

// Calls f with each table of rows, and the offset of its last row in its buffer.
template <class F>
void Recorder::each_table(const F& f) {
  f(bodies_, body_row_);
  f(joints_, joint_row_);
  if (energy_) f(*energy_, energy_row_);
  if (springs_) f(*springs_, spring_row_);
  if (contacts_) f(*contacts_, contact_row_);
}

void Recorder::write_running_summary() {
  const std::string running = summary_json(origin_, "running, or killed");
  directory_->write("summary.json", running);
  constexpr std::size_t results = 2048, message = 8192;  // space for the rest of the summary
  directory_->reserve(running.size() + results + message);
}

// The last row is kept back: a row of the same instant may replace it.
RecorderState Recorder::state() {
  const auto table = [](TextFile& file, std::size_t& row) {
    file.flush(row);
    row = 0;
    return RecorderState::Table{file.mark(), file.text()};
  };
  std::size_t all = events_.text().size();
  RecorderState state;
  state.events = table(events_, all);  // events first: see close_tables
  state.bodies = table(bodies_, body_row_);
  state.joints = table(joints_, joint_row_);
  if (energy_) state.energy = table(*energy_, energy_row_);
  if (springs_) state.springs = table(*springs_, spring_row_);
  if (contacts_) state.contacts = table(*contacts_, contact_row_);
  state.next = next_, state.row_time = row_time_, state.events_taken = events_taken_;
  state.body_quaternions = body_columns_.quaternions().last();
  state.joint_quaternions = joint_columns_.quaternions().last();
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
  for (; events_taken_ < all.size(); ++events_taken_) events_.text() += event_json(all[events_taken_]) + '\n';
}

void Recorder::write_out_where_due() {
  using namespace std::chrono_literals;
  const Clock::time_point now = Clock::now();
  bool full = false;
  each_table([&](TextFile& table, std::size_t&) { full = full || table.is_full(); });
  if (!full && now - written_out_ < 1s) return;
  written_out_ = now;
  events_.flush();
  each_table([](TextFile& table, std::size_t&) { table.flush(); });
}

void Recorder::write_row(const World& world) {
  if (row_time_ == world.time()) {
    each_table([](TextFile& table, std::size_t& row) { table.text().resize(row); });
  } else {
    write_out_where_due();  // the last row is final: no other row has its time
    each_table([](TextFile& table, std::size_t& row) { row = table.text().size(); });
    row_time_ = world.time();
  }
  try {
    take_events();
    body_columns_.row(bodies_.text(), world);
    joint_columns_.row(joints_.text(), world);
    if (energy_) energy_row(energy_->text(), simulation_.world(), simulation_.energy());
    if (springs_) spring_row(springs_->text(), world);
    if (contacts_) contact_rows(contacts_->text(), world);
  } catch (...) {  // out of memory: no table has a partial row, or one row more than another
    each_table([](TextFile& table, std::size_t& row) { table.text().resize(row); });
    throw;
  }
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
  const bool events = attempt([&] { events_.close(options_.lasting); });
  each_table([&](TextFile& table, std::size_t&) {
    if (!events) table.text().clear();
    attempt([&] { table.close(options_.lasting); });
  });
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
      temporary.insert(temporary.end(), {"bodies.csv", "joints.csv", "energy.csv", "springs.csv", "contacts.csv"});
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
