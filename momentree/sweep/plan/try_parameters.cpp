// Tries values of the parameters before anything runs.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include <momentree/sweep/plan/sweep_reading.hpp>
#include <momentree/text/files/input_cache.hpp>
#include <momentree/text/files/text_file.hpp>
#include <momentree/text/hash.hpp>
#include <momentree/text/toml.hpp>

namespace momentree::sweep {

namespace {

constexpr std::size_t most_choices_tried = 100;
constexpr double almost_none = 1e-9;

// The values of one parameter to try, the usual one first; one list of components each.
std::vector<std::vector<double>> trials(const Variable& variable) {
  std::vector<std::vector<double>> all;
  if (const auto* list = std::get_if<ListValues>(&variable.values)) {
    for (std::size_t i = 0; i < std::min(list->count, most_choices_tried); ++i) all.push_back({static_cast<double>(i)});
    if (list->count > most_choices_tried) all.push_back({static_cast<double>(list->count - 1)});
  } else if (const auto* range = std::get_if<RangeValues>(&variable.values)) {
    all = {{range->from}};
    if (range->count > 1) all.push_back({range->to});
  } else {
    const auto& sampled = std::get<Sampled>(variable.values);
    // The ends of distributions that are bounded, for example uniform ones: they will occur, or nearly so.
    const auto at = [&](double u) {
      std::vector<double> values;
      for (const Distribution& each : sampled.components) values.push_back(each.quantile(u));
      return values;
    };
    all.push_back(at(0.5));
    if (const auto* choice = std::get_if<Choice>(&sampled.components.front().kind())) {
      for (std::size_t i = 0; i < std::min(choice->weights.size(), most_choices_tried); ++i)
        if (choice->weights[i] > 0) all.push_back({static_cast<double>(i)});
    } else if (std::holds_alternative<Uniform>(sampled.components.front().kind())) {
      all.push_back(at(almost_none));
      all.push_back(at(1 - almost_none));
    }
  }
  return all;
}

// Whether a value has a string that is the name of a file.
bool names_file(const Value& value, const std::filesystem::path& folder) {
  std::error_code ignored;
  if (const std::string* text = value.string())
    return !text->empty() && text->find('\0') == std::string::npos && std::filesystem::is_regular_file(folder / *text, ignored);
  if (const Value::Array* entries = value.array())
    return std::any_of(entries->begin(), entries->end(), [&](const Value& each) { return names_file(each, folder); });
  if (const Value::Table* entries = value.table())
    return std::any_of(entries->begin(), entries->end(), [&](const auto& each) { return names_file(each.value, folder); });
  return false;
}

class Trials {
 public:
  explicit Trials(SweepReading& reading) : reading_(reading), sweep_(reading.sweep), reported_(sweep_.parameters.size()) {
    for (std::size_t p = 0; p < sweep_.parameters.size(); ++p) {
      all_.push_back(trials(reading.variables[p]));
      add_files(p);
      usual_.push_back(override_text(sweep_.parameters[p], all_.back().front()));
    }
  }

  std::string run() {
    if (!usual()) return hash_.digits();
    for (std::size_t p = 0; p < all_.size() && !reading_.out.full(); ++p)
      for (std::size_t i = 1; i < all_[p].size() && !reported_[p]; ++i) {
        std::vector<std::string> overrides = usual_;
        overrides[p] = override_text(sweep_.parameters[p], all_[p][i]);
        const io::ReadResult read = io::read_scenario_again(*sweep_.scenario, overrides);
        if (read.scenario)
          note(*read.scenario);
        else
          blame(read.diagnostics, overrides, p);
      }
    return hash_.digits();
  }

 private:
  // Of long lists also the entries that name files: these belong to the sweep.
  void add_files(std::size_t p) {
    const std::vector<std::string>& choices = sweep_.parameters[p].choices;
    const std::filesystem::path folder = std::filesystem::path(sweep_.scenario->path).parent_path();
    for (std::size_t i = most_choices_tried; i + 1 < choices.size(); ++i) {
      if (choices[i].find_first_of("\"'") == std::string::npos) continue;
      const std::optional<Value> value = io::parse_toml_value(choices[i], {});
      if (value && names_file(*value, folder)) all_[p].push_back({static_cast<double>(i)});
    }
  }

  // All parameters at their usual values. An error that is not of an override is of the parameter that gives it alone.
  bool usual() {
    const io::ReadResult read = io::read_scenario_again(*sweep_.scenario, usual_);
    if (read.scenario) {
      note(*read.scenario);
      return true;
    }
    std::vector<io::Diagnostic> rest = blame(read.diagnostics, usual_, std::nullopt);
    if (rest.empty()) return false;
    bool found = false;
    for (std::size_t p = 0; p < usual_.size(); ++p) {
      const std::vector<std::string> alone = {usual_[p]};
      const io::ReadResult one = io::read_scenario_again(*sweep_.scenario, alone);
      if (one.scenario) continue;
      found = true;
      for (const io::Diagnostic& each : one.diagnostics) report(each, p, usual_[p]);
    }
    if (!found) {
      const io::Diagnostic& first = rest.front();
      reading_.out.error(reading_.vary, "[vary]: with the typical values of all parameters: " + first.what + place_of(first),
                         first.hint);
    }
    return false;
  }

  // Reports errors at the overrides that they name, the others at `otherwise`; without it, returns them.
  std::vector<io::Diagnostic> blame(const std::vector<io::Diagnostic>& diagnostics, const std::vector<std::string>& overrides,
                                    std::optional<std::size_t> otherwise) {
    std::vector<io::Diagnostic> rest;
    for (const io::Diagnostic& each : diagnostics) {
      if (each.severity != io::Severity::error) continue;
      std::optional<std::size_t> of = otherwise;
      for (std::size_t p = 0; p < overrides.size(); ++p)
        if (each.file == "--set " + overrides[p]) of = p;
      if (of)
        report(each, *of, overrides[*of]);
      else
        rest.push_back(each);
    }
    return rest;
  }

  void report(const io::Diagnostic& each, std::size_t of, const std::string& override) {
    if (each.severity != io::Severity::error || reported_[of]) return;
    reported_[of] = true;
    const Parameter& parameter = sweep_.parameters[of];
    const std::string value = override.substr(parameter.key.size() + 1);
    reading_.out.error(parameter.place, parameter.key + " = " + value + ": " + each.what + place_of(each), each.hint);
  }

  static std::string place_of(const io::Diagnostic& each) {
    return each.line > 0 ? " (" + each.file + ", line " + std::to_string(each.line) + ")" : "";
  }

  // The values and the contents of the files that they name.
  void note(const io::Scenario& scenario) {
    hash_.add("\n--tried ");
    hash_.add(scenario.hash);
    for (const io::StateFile& file : scenario.state_files) {
      hash_.add("\n--state ");
      hash_.add(sweep_.scenario->inputs->text(file.file));
    }
  }

  SweepReading& reading_;
  Sweep& sweep_;
  std::vector<std::vector<std::vector<double>>> all_;
  std::vector<std::string> usual_;
  std::vector<bool> reported_;
  io::Hash hash_;
};

}  // namespace

std::string try_parameters(SweepReading& reading) { return Trials(reading).run(); }

}  // namespace momentree::sweep
