// Tries values of the parameters before anything runs.
#include <algorithm>
#include <cmath>

#include <momentree/sweep/sweep_reading.hpp>

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

}  // namespace

void try_parameters(SweepReading& reading) {
  Sweep& sweep = reading.sweep;
  std::vector<std::vector<std::vector<double>>> all;
  std::vector<std::string> usual;
  for (std::size_t p = 0; p < sweep.parameters.size(); ++p) {
    all.push_back(trials(reading.variables[p]));
    usual.push_back(override_text(sweep.parameters[p], all.back().front()));
  }
  std::vector<bool> reported(sweep.parameters.size());
  // True if the scenario can be read with these values. `which`: the parameter that was changed last.
  const auto check = [&](const std::vector<std::string>& overrides, std::size_t which) {
    const io::ReadResult read = io::read_scenario_again(*sweep.scenario, overrides);
    if (read.scenario) return true;
    for (const io::Diagnostic& each : read.diagnostics) {
      if (each.severity != io::Severity::error) continue;
      std::size_t of = which;
      for (std::size_t p = 0; p < overrides.size(); ++p)
        if (each.file == "--set " + overrides[p]) of = p;
      if (reported[of]) continue;
      reported[of] = true;
      const std::string value = overrides[of].substr(sweep.parameters[of].key.size() + 1);
      std::string where = each.line > 0 ? " (" + each.file + ", line " + std::to_string(each.line) + ")" : "";
      reading.out.error(sweep.parameters[of].place, sweep.parameters[of].key + " = " + value + ": " + each.what + where,
                        each.hint);
    }
    return false;
  };
  const bool good = check(usual, 0);
  for (std::size_t p = 0; p < all.size() && !reading.out.full(); ++p)
    for (std::size_t i = 1; i < all[p].size() && !reported[p] && good; ++i) {
      std::vector<std::string> overrides = usual;
      overrides[p] = override_text(sweep.parameters[p], all[p][i]);
      check(overrides, p);
    }
}

}  // namespace momentree::sweep
