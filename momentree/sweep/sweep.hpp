#pragma once
// A sweep: many worlds of one scenario with varied values, and what is recorded of each.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <momentree/scenario/scenario.hpp>
#include <momentree/sweep/plan/measure.hpp>
#include <momentree/sweep/plan/plan.hpp>

namespace momentree::sweep {

/// A value of the scenario that the sweep varies.
struct Parameter {
  std::string key;                     ///< a dotted path, as in `--set`
  std::size_t components = 1;          ///< numbers of a vector
  bool vector = false;                 ///< written as a list even if it has one component
  std::string unit{};                  ///< as written in the sweep: "deg"; empty: the scenario's own
  std::vector<std::string> choices{};  ///< for a list, its entries as TOML; the plan then gives an index
  std::string about{};                 ///< "uniform 8 to 24"
  Place place{};                       ///< of the key in the sweep's file
};

/// A parameter with these components (for a list: the index) as an override: KEY=VALUE.
std::string override_text(const Parameter& parameter, std::span<const double> components);

/// When a world ends before its scenario does.
struct StopRule {
  std::vector<std::string> events{};  ///< after one of these happened
  long steps = 0;                     ///< a world that needs more steps fails; 0: no limit
};

struct Sweep {
  std::string path;       ///< as given
  std::string name;       ///< the file's name without folder and extension
  std::string title;      ///< may be empty
  std::string text;       ///< as read
  std::string hash;       ///< of the sweep, the scenario and the files that they name
  std::string plan_hash;  ///< of what determines the varied values: [vary], [[correlated]], the seed, the number of worlds
  std::shared_ptr<const io::Scenario> scenario;
  std::vector<io::JointKinds> joints;  ///< joints of the scenario's run
  std::uint64_t seed = 0;
  std::vector<Parameter> parameters;
  std::shared_ptr<const Plan> plan;
  std::vector<Correlation> correlations;  ///< in the plan
  std::vector<Measure> measures;
  StopRule stop;
  std::string output;       ///< a folder, or a file that ends in .h5; empty: not given
  bool json_lines = false;  ///< also worlds.jsonl

  std::uint64_t worlds() const { return plan->worlds(); }
  /// The varied values of a world as overrides: KEY=VALUE.
  std::vector<std::string> overrides(std::uint64_t world) const;
};

/// A column of the varied values: a parameter, or one component of it.
struct ParameterColumn {
  std::string name;                  ///< the key, and ".0" … for the components of a vector
  std::size_t parameter = 0;         ///< its place in Sweep::parameters
  std::size_t component = 0;         ///< its place in the values of the plan
  bool is_text = false;              ///< a list with entries that are not numbers, nor quantities in one unit
  std::vector<double> numbers{};     ///< of the entries of a list; NaN for entries that are not numbers
  std::vector<std::string> texts{};  ///< of the entries of a list, strings without quotes
};
std::vector<ParameterColumn> parameter_columns(const Sweep& sweep);
/// The cell of a table for that column: a number, or the entry of a list as text.
std::string parameter_text(const ParameterColumn& column, std::span<const double> values);
/// The same as a number; NaN for text.
double parameter_number(const ParameterColumn& column, std::span<const double> values);

}  // namespace momentree::sweep
