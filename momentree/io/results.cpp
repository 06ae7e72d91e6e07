#include <momentree/io/results.hpp>

#include <cmath>
#include <new>
#include <utility>

#include <momentree/integrate/integrator.hpp>
#include <momentree/io/energy_columns.hpp>
#include <momentree/io/hdf5_results.hpp>

namespace momentree::io {

namespace {

std::vector<std::string> files_of(const RecordOptions& options) {
  std::vector<std::string> files = {"summary.json", "model.json", "events.jsonl", "bodies.csv", "joints.csv", "final.json"};
  if (options.energy) files.emplace_back("energy.csv");
  if (options.report) files.emplace_back("report.html");
  if (options.hdf5) files.insert(files.end(), {"results.h5", "results.h5.partial"});
  return files;
}

}  // namespace

Recorder::Recorder(const Simulation& simulation, RunOrigin origin, std::string_view model_json, RecordOptions options)
    : simulation_(simulation),
      origin_(std::move(origin)),
      options_(std::move(options)),
      directory_(options_.directory, files_of(options_), options_.lasting),
      events_(directory_.file("events.jsonl")),
      bodies_(directory_.file("bodies.csv")),
      joints_(directory_.file("joints.csv")),
      body_columns_(simulation.world().model()),
      joint_columns_(options_.joints, options_.reactions) {
  const std::string running = summary_json(origin_, "running, or killed");
  directory_.write("summary.json", running);
  constexpr std::size_t results = 2048, message = 8192;  // space for the rest of the summary
  directory_.reserve(running.size() + results + message);
  directory_.write("model.json", model_json);
  BodyColumns::header(bodies_.text(), simulation.world().model());
  joint_columns_.header(joints_.text());
  if (options_.energy) energy_header(energy_.emplace(directory_.file("energy.csv")).text());
  for (TextFile* table : {&bodies_, &joints_}) table->flush();
  if (energy_) energy_->flush();
  directory_.keep();
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
  if (!bodies_.is_full() && !joints_.is_full() && !(energy_ && energy_->is_full()) && now - written_out_ < 1s) return;
  written_out_ = now;
  events_.flush();
  bodies_.flush();
  joints_.flush();
  if (energy_) energy_->flush();
}

void Recorder::write_row(const World& world) {
  if (row_time_ == world.time()) {
    bodies_.text().resize(body_row_);
    joints_.text().resize(joint_row_);
    if (energy_) energy_->text().resize(energy_row_);
  } else {
    write_out_where_due();  // the last row is final: no other row has its time
    body_row_ = bodies_.text().size();
    joint_row_ = joints_.text().size();
    if (energy_) energy_row_ = energy_->text().size();
    row_time_ = world.time();
  }
  try {
    take_events();
    body_columns_.row(bodies_.text(), world);
    joint_columns_.row(joints_.text(), world);
    if (energy_) energy_row(energy_->text(), simulation_.world(), simulation_.energy());
  } catch (...) {  // out of memory: no table has a partial row, or one row more than another
    bodies_.text().resize(body_row_);
    joints_.text().resize(joint_row_);
    if (energy_) energy_->text().resize(energy_row_);
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
  for (TextFile* table : {&bodies_, &joints_, energy_ ? &*energy_ : nullptr}) {
    if (table == nullptr) continue;
    if (!events) table->text().clear();
    attempt([&] { table->close(options_.lasting); });
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
    if (sealed_) directory_.remove("summary.json");
    directory_.remove("report.html");
    has_report_ = false;
    if (!attempt(say)) continue;
    has_report_ = report && attempt([&] { directory_.write("report.html", report(directory_.working(), summary_)); });
    said = attempt(say) && attempt([&] { directory_.write("summary.json", summary_, true); });
    sealed_ = sealed_ || said;
  }
  if (said) return;
  directory_.remove("report.html");
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
  attempt([&] {
    const bool adaptive = is_adaptive(origin_.integration.method);
    directory_.write("final.json", state_json(simulation_.world(), armed, adaptive ? simulation_.step_memory() : StepMemory{}));
  });
  if (options_.hdf5 && !failed_ && status == "done")
    attempt([&] {
      for (const char* name : {"results.h5", "results.h5.partial"}) directory_.file(name);
      write_hdf5_results(directory_.working(), origin_, simulation_.world(), options_.joints, options_.lasting);
    });
  seal(outcome, report);
  if (failed_ || status != "done") return;
  if (options_.hdf5)
    for (const char* name : {"bodies.csv", "joints.csv", "energy.csv"}) directory_.remove(name);  // the report has been made
  published_ = attempt([&] { warnings_ = directory_.publish(); });
  if (!published_) seal(outcome, report);
}

void Recorder::abandon(const char* status) noexcept {
  close_tables();
  failed_ = true;
  attempt([&] {
    status_ = status;
    summary_ = summary_json(origin_, status_);
    directory_.write("summary.json", summary_, true);
  });
}

std::string Recorder::directory() const { return (published_ ? directory_.destination() : directory_.working()).string(); }

}  // namespace momentree::io
