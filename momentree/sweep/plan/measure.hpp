#pragma once
// What a sweep records of each world: final values, extremes, times and values of events.
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <momentree/results/columns/result_column.hpp>
#include <momentree/simulate/events/condition.hpp>

namespace momentree::sweep {

/// A number at an instant: a column of the results, or a quantity as in conditions.
using Source = std::variant<io::ResultColumn, std::shared_ptr<const Quantity>>;
/// Its value in the present state; NaN if it does not exist.
double value_of(const Source& source, const Simulation& simulation);

/// Whether an event happened, when, how often, or a number of its certificate. `number` selects one of several events of that
/// name: from 1, or from the last one with −1.
struct EventMeasure {
  enum class What { happened, time, count, value };
  What what = What::happened;
  std::string event;
  std::string value{};  ///< for What::value: one of event_values()
  int number = 1;
};

/// The extreme of a source over the run, its mean over time, or the time of an extreme (s). Taken at the ends of all steps,
/// before and after the events of each instant.
struct FoldMeasure {
  enum class What { max, min, mean };
  What what = What::max;
  Source source;
  bool time = false;  ///< the time of the extreme instead of its value
};

/// A source at the end of the run, or at an instant.
struct InstantMeasure {
  Source source;
  std::optional<double> at{};  ///< s; empty: at the end
};

struct Measure {
  std::string name;
  std::variant<EventMeasure, FoldMeasure, InstantMeasure> what;
  std::string unit{};
  std::string about{};  ///< "largest reaction_force of tug/wrist", for reports

  bool is_flag() const {
    const auto* event = std::get_if<EventMeasure>(&what);
    return event != nullptr && event->what == EventMeasure::What::happened;
  }
};

/// Whether a measure needs the energy ledger of the run.
bool needs_ledger(const Measure& measure);

/// The numbers of a certificate that a measure can name: "lost", "before.kinetic", "hardest.linear" …
const std::vector<std::string>& event_values();
/// The SI unit of one of them.
std::string unit_of_event_value(std::string_view value);
/// That number of an event.
double event_value(const Event& event, std::string_view value);

/// Records the measures of one world while it runs.
class Observation {
 public:
  explicit Observation(const std::vector<Measure>& measures);

  /// Whether sample() has to be called.
  bool samples() const { return samples_; }
  /// The instants (s) at which instant() has to be called, sorted, without repetition.
  const std::vector<double>& instants() const { return instants_; }
  /// The state at the end of a step.
  void sample(const Simulation& simulation);
  /// The state at one of the instants, after its events.
  void instant(const Simulation& simulation, double time);
  /// The measures at the end of the run.
  std::vector<double> results(const Simulation& simulation) const;

 private:
  struct Fold {
    double value = 0, time = 0;     ///< the extreme and when it occurred, or the last value and its time
    double integral = 0, span = 0;  ///< of a mean
    bool any = false;
  };
  const std::vector<Measure>& measures_;
  std::vector<Fold> folds_;
  std::vector<double> at_;  ///< values of instant measures with an instant
  std::vector<double> instants_;
  bool samples_ = false;
};

}  // namespace momentree::sweep
