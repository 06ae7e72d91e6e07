// Sweeps: reading them, their values, computing worlds on threads, summaries.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include <momentree/sweep/plan/read_sweep.hpp>
#include <momentree/sweep/scenario_worlds.hpp>
#include <momentree/sweep/summary.hpp>
#include <momentree/text/diagnostic.hpp>

#include <nanobind/stl/map.h>

#include "binding.hpp"

namespace momentree::python {

namespace {

using namespace std::chrono_literals;
using sweep::Sweep;
using sweep::WorldResult;
using Failures = std::map<std::size_t, std::string>;  ///< by row

struct SweepObject {
  Sweep sweep;
  std::vector<std::string> warnings;
};

SweepObject read(const std::string& path) {
  sweep::ReadSweep found = sweep::read_sweep(path);
  if (!found.sweep) throw io::InputError(std::move(found.diagnostics));
  SweepObject object{std::move(*found.sweep), {}};
  for (const io::Diagnostic& each : found.diagnostics) object.warnings.push_back(each.message());
  return object;
}

std::uint64_t checked(const Sweep& sweep, double world) {
  if (!(world >= 0) || world >= static_cast<double>(sweep.worlds()) || world != std::floor(world))
    refuse("there is no world " + std::to_string(static_cast<long long>(world)) + ": the sweep has " +
               std::to_string(sweep.worlds()),
           "the first is 0");
  return static_cast<std::uint64_t>(world);
}

// The worlds of the rows: those given, or all.
class Rows {
 public:
  Rows(const Sweep& sweep, nb::handle given) : all_(given.is_none()), count_(sweep.worlds()) {
    if (all_) return;
    for (const double world : numbers_of(given, "worlds")) some_.push_back(checked(sweep, world));
    count_ = some_.size();
  }
  std::size_t size() const { return count_; }
  std::uint64_t operator[](std::size_t row) const { return all_ ? row : some_[row]; }

 private:
  bool all_;
  std::size_t count_;
  std::vector<std::uint64_t> some_;
};

// The system would end the process instead of refusing.
void check_memory(std::size_t rows, std::size_t columns) {
  const double bytes = static_cast<double>(rows) * (8.0 * static_cast<double>(columns) + 64);
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (bytes > 0.5 * memory)
    refuse("not enough memory for the results of " + std::to_string(rows) + " worlds",
           "run them in parts, with worlds=range(...), or with the momentree command, which writes files");
}

// Threads that compute worlds into an array. The calling thread waits.
class Computation {
 public:
  /// `progress`: a function that is called with the number of computed worlds, or None.
  Computation(const Sweep& sweep, const Rows& rows, double* out, nb::object progress)
      : worlds_(sweep, lanes_for(sweep, sweep::lanes_of("auto")), &stop_),
        measures_(sweep.measures.size()),
        rows_(rows),
        out_(out),
        computed_(rows.size()),
        progress_(std::move(progress)) {}

  /// Without the GIL, which is taken to look for signals and to show progress. Throws what a thread threw.
  void run(std::size_t threads) {
    std::vector<std::jthread> all;
    try {
      for (running_ = 0; all.size() < threads;) {
        {
          const std::lock_guard lock(mutex_);
          ++running_;
        }
        all.emplace_back([this] { work(); });
      }
      wait();
    } catch (const std::system_error&) {
      stop_ = true;
      refuse("cannot start " + std::to_string(threads) + " threads", "jobs=0 starts one for each processor");
    } catch (...) {
      stop_ = true;
      throw;
    }
    all.clear();
    if (failure_) std::rethrow_exception(failure_);
  }
  /// The rows that were computed, if the exception of a signal handler or of `progress` ended the computation early.
  std::vector<std::size_t> computed() const {
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < computed_.size(); ++row)
      if (computed_[row] != 0) rows.push_back(row);
    return rows;
  }
  Failures failures;
  nb::object interruption = nb::none();  ///< that exception

 private:
  void wait() {
    std::unique_lock lock(mutex_);
    while (!ended_.wait_for(lock, 50ms, [this] { return running_ == 0; })) {
      const std::size_t count = count_;
      lock.unlock();
      {
        const nb::gil_scoped_acquire held;
        try {
          if (PyErr_CheckSignals() != 0) nb::raise_python_error();
          if (!progress_.is_none() && !stop_) progress_(count);
        } catch (const nb::python_error& error) {
          stop_ = true;
          interruption = nb::borrow(error.value());
        }
      }
      lock.lock();
    }
  }
  void work() noexcept {
    try {
      const std::size_t block = worlds_.at_once();
      for (std::size_t row = next_.fetch_add(block); row < rows_.size() && !stop_; row = next_.fetch_add(block))
        compute(row, std::min(block, rows_.size() - row));
    } catch (...) {
      stop_ = true;
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    --running_;
    ended_.notify_all();
  }
  void compute(std::size_t first, std::size_t count) {
    std::vector<std::uint64_t> worlds(count);
    for (std::size_t i = 0; i < count; ++i) worlds[i] = rows_[first + i];
    // Ended by `stop_`: these worlds have no results.
    (void)worlds_.run(worlds, [&](std::size_t place, WorldResult result) { store(first + place, std::move(result)); });
  }
  void store(std::size_t row, WorldResult result) {
    double* const to = out_ + row * measures_;
    if (result.done())
      std::copy(result.measures.begin(), result.measures.end(), to);
    else
      std::fill_n(to, measures_, std::numeric_limits<double>::quiet_NaN());
    const std::lock_guard lock(mutex_);
    computed_[row] = 1;
    ++count_;
    if (!result.done()) failures.emplace(row, std::move(result.failure));
  }

  std::atomic<bool> stop_ = false;
  std::atomic<std::size_t> next_ = 0;
  sweep::ScenarioWorlds worlds_;
  std::size_t measures_;
  const Rows& rows_;
  double* out_;
  std::mutex mutex_;
  std::condition_variable ended_;
  std::size_t running_ = 0, count_ = 0;
  std::vector<char> computed_;  ///< by row
  std::exception_ptr failure_;
  nb::object progress_;
};

// The measures, shape (rows, measures); why worlds failed, by row; and if an exception ended the sweep, that and the rows that
// have results.
nb::tuple compute(const SweepObject& self, nb::handle given, int jobs, nb::object progress) {
  if (jobs < 0) refuse("jobs: expected the number of threads, found " + std::to_string(jobs), "0: one for each processor");
  const Rows rows(self.sweep, given);
  check_memory(rows.size(), self.sweep.measures.size());
  NewArray array = new_array(rows.size(), self.sweep.measures.size());
  const std::size_t wanted = jobs > 0 ? static_cast<std::size_t>(jobs) : std::max(std::thread::hardware_concurrency(), 1u);
  Computation computation(self.sweep, rows, array.data, std::move(progress));
  {
    const nb::gil_scoped_release free;
    computation.run(std::min(wanted, rows.size()));
  }
  nb::dict failures;
  for (const auto& [row, why] : computation.failures) failures[nb::int_(row)] = why;
  nb::list computed;
  if (!computation.interruption.is_none())
    for (const std::size_t row : computation.computed()) computed.append(row);
  return nb::make_tuple(array.object, failures, computation.interruption, computed);
}

// By name: an array of numbers, or a list of texts.
nb::dict columns(const SweepObject& self, nb::handle given) {
  const Sweep& sweep = self.sweep;
  const Rows rows(sweep, given);
  const std::vector<sweep::ParameterColumn> all = parameter_columns(sweep);
  check_memory(rows.size(), all.size());
  nb::dict found;
  std::vector<double*> numbers;
  std::vector<nb::list> texts(all.size());
  for (std::size_t c = 0; c < all.size(); ++c) {
    numbers.push_back(nullptr);
    if (all[c].is_text) {
      found[all[c].name.c_str()] = texts[c];
    } else {
      NewArray array = new_array(rows.size());
      numbers.back() = array.data;
      found[all[c].name.c_str()] = array.object;
    }
  }
  std::vector<double> values(sweep.plan->size());
  for (std::size_t row = 0; row < rows.size(); ++row) {
    sweep.plan->values(rows[row], values);
    for (std::size_t c = 0; c < all.size(); ++c) {
      if (numbers[c] != nullptr)
        numbers[c][row] = parameter_number(all[c], values);
      else
        texts[c].append(parameter_text(all[c], values));
    }
  }
  return found;
}

std::string summary(const SweepObject& self, nb::handle worlds, nb::handle measures, const Failures& failures) {
  const Sweep& sweep = self.sweep;
  const Rows rows(sweep, worlds);
  const std::size_t count = sweep.measures.size();
  const std::vector<double> numbers = numbers_of(measures, rows.size(), count, "measures", false);
  sweep::SweepSummary result(sweep);
  sweep::Row row;
  row.values.resize(sweep.plan->size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    row.world = rows[r];
    sweep.plan->values(row.world, row.values);
    const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(r * count);
    row.result.measures.assign(first, first + static_cast<std::ptrdiff_t>(count));
    const auto failed = failures.find(r);
    row.result.failure = failed == failures.end() ? "" : failed->second;
    result.add(row);
  }
  return result.json();
}

nb::tuple names_of_parameters(const SweepObject& self) {
  nb::list names;
  for (const sweep::ParameterColumn& column : parameter_columns(self.sweep)) names.append(column.name);
  return nb::tuple(names);
}

nb::tuple names_of_measures(const SweepObject& self) {
  nb::list names;
  for (const sweep::Measure& measure : self.sweep.measures) names.append(measure.name);
  return nb::tuple(names);
}

using DrawnFrom = std::pair<std::string, std::vector<double>>;  ///< kind and numbers; "list": how many entries

sweep::Distribution distribution_of(const DrawnFrom& from) {
  const auto& [kind, n] = from;
  if (kind == "uniform" && n.size() == 2) return sweep::Uniform{n[0], n[1]};
  if (kind == "normal" && n.size() == 2) return sweep::Normal{n[0], n[1]};
  if (kind == "normal" && n.size() == 4) return sweep::Normal{n[0], n[1], sweep::Interval{n[2], n[3]}};
  if (kind == "lognormal" && n.size() == 2) return sweep::Lognormal{n[0], n[1]};
  if (kind == "exponential" && n.size() == 1) return sweep::Exponential{n[0]};
  if (kind == "weibull" && n.size() == 2) return sweep::Weibull{n[0], n[1]};
  if (kind == "triangular" && n.size() == 3) return sweep::Triangular{n[0], n[1], n[2]};
  refuse("no distribution '" + kind + "' has " + std::to_string(n.size()) + " parameters");
}

// The values of a plan, shape (worlds, variables): an index for a list.
nb::object draw(const std::vector<std::pair<std::string, DrawnFrom>>& given, std::uint64_t worlds, std::uint64_t seed,
                const std::string& sampling) {
  sweep::Sampling how = sweep::Sampling::random;
  if (sampling == "latin" || sampling == "sobol")
    how = sampling == "latin" ? sweep::Sampling::latin : sweep::Sampling::sobol;
  else if (sampling != "random")
    refuse("unknown sampling '" + sampling + "'", "\"random\", \"latin\" or \"sobol\"");
  std::vector<sweep::Variable> variables;
  for (const auto& [key, from] : given) {
    if (from.first == "list")
      variables.push_back({key, sweep::ListValues{static_cast<std::size_t>(from.second.at(0))}});
    else
      variables.push_back({key, sweep::Sampled{how, {distribution_of(from)}}});
  }
  const sweep::Plan plan(std::move(variables), worlds, seed);
  check_memory(worlds, plan.size());
  NewArray array = new_array(worlds, plan.size());
  for (std::uint64_t world = 0; world < worlds; ++world) plan.values(world, {array.data + world * plan.size(), plan.size()});
  return std::move(array.object);
}

}  // namespace

void register_sweep(nb::module_& m) {
  m.def("_draw", &draw);
  nb::class_<SweepObject>(m, "SweepBase")
      .def(
          "__init__", [](SweepObject* self, const std::string& path) { new (self) SweepObject(read(path)); }, "path"_a)
      .def_prop_ro(
          "path", [](const SweepObject& self) { return self.sweep.path; }, "The file, as given.")
      .def_prop_ro(
          "name", [](const SweepObject& self) { return self.sweep.name; },
          "Name of the sweep: that of its file without the ending.")
      .def_prop_ro(
          "title", [](const SweepObject& self) { return self.sweep.title; }, "Title of the sweep; may be empty.")
      .def_prop_ro(
          "scenario", [](const SweepObject& self) { return self.sweep.scenario->path; }, "The scenario's file.")
      .def_prop_ro(
          "seed", [](const SweepObject& self) { return self.sweep.seed; }, "Seed of its random numbers.")
      .def_prop_ro(
          "worlds", [](const SweepObject& self) { return self.sweep.worlds(); }, "Number of worlds.")
      .def_prop_ro("parameters", &names_of_parameters,
                   "Names of the varied values: keys of the scenario, with .0, .1 … for the components of vectors.")
      .def_prop_ro("measures", &names_of_measures, "Names of what is recorded of each world.")
      .def_prop_ro(
          "warnings", [](const SweepObject& self) { return self.warnings; },
          "What the reader of the file warned of, as text with file and line.")
      .def_prop_ro("_flags",
                   [](const SweepObject& self) {
                     std::vector<bool> all;
                     for (const sweep::Measure& measure : self.sweep.measures) all.push_back(measure.is_flag());
                     return all;
                   })
      .def("_overrides", [](const SweepObject& self, double world) { return self.sweep.overrides(checked(self.sweep, world)); })
      .def("_columns", &columns, nb::arg().none())
      .def("_compute", &compute, nb::arg().none(), nb::arg(), nb::arg().none())
      .def("_summary", &summary);
}

}  // namespace momentree::python
