#include <momentree/sweep/plan/plan.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>

#include <momentree/base/check.hpp>
#include <momentree/base/error.hpp>
#include <momentree/sweep/stats/random.hpp>
#include <momentree/sweep/stats/sobol.hpp>
#include <momentree/sweep/stats/special_functions.hpp>

namespace momentree::sweep {
namespace {

constexpr std::uint64_t most_worlds = std::uint64_t{1} << 48;

// FNV-1a
std::uint64_t stream_of(std::string_view key) {
  std::uint64_t hash = 0xCBF29CE484222325;
  for (const char c : key) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3;
  return hash;
}

std::uint64_t entries_of(const Variable& variable) {
  if (const auto* list = std::get_if<ListValues>(&variable.values)) return list->count;
  if (const auto* range = std::get_if<RangeValues>(&variable.values)) return range->count;
  return 1;
}

double at_entry(const RangeValues& range, std::uint64_t entry) {
  if (entry == 0) return range.from;
  const std::uint64_t last = range.count - 1;
  if (entry == last) return range.to;
  return (range.from * static_cast<double>(last - entry) + range.to * static_cast<double>(entry)) / static_cast<double>(last);
}

// A point of stratum `number` of `count`, 0 < jitter < 1, as a share of all. The point has 53 bits, so that no rounding moves it
// to another stratum.
double in_stratum(std::uint64_t number, std::uint64_t count, double jitter) {
  const double steps = std::ldexp(1.0, 52 - static_cast<int>(std::bit_width(count)));
  const double inside = (std::floor(jitter * steps) + 0.5) / steps;
  return (static_cast<double>(number) + inside) / static_cast<double>(count);
}

void check_variable(const Variable& variable) {
  const auto refuse = [&](std::string what, std::string hint) {
    throw_error({"'" + variable.key + "' " + what, "", std::move(hint)});
  };
  if (entries_of(variable) == 0) refuse("has no values", "give at least one");
  if (const auto* range = std::get_if<RangeValues>(&variable.values)) {
    const double count = static_cast<double>(range->count);
    if (!std::isfinite(range->from * count) || !std::isfinite(range->to * count)) refuse("has a range that is not finite", "");
  }
  if (const auto* sampled = std::get_if<Sampled>(&variable.values))
    if (sampled->components.empty()) refuse("has no distribution", "give one, or one per component");
}

}  // namespace

Plan::Plan(std::vector<Variable> variables, std::optional<std::uint64_t> worlds, std::uint64_t seed,
           std::vector<Correlation> correlations)
    : variables_(std::move(variables)), seed_(seed), combinations_(!worlds) {
  for (const Variable& variable : variables_) check_variable(variable);
  count_worlds(worlds);
  add_components();
  add_correlations(correlations);
}

void Plan::count_worlds(std::optional<std::uint64_t> worlds) {
  const auto refuse = [](std::string hint) { throw_error({"a sweep has from 1 to 2^48 worlds", "", std::move(hint)}); };
  if (worlds) {
    if (*worlds < 1 || *worlds > most_worlds) refuse("");
    worlds_ = *worlds;
    return;
  }
  for (const Variable& variable : variables_) {
    const std::uint64_t count = entries_of(variable);
    if (count > most_worlds / worlds_)
      refuse("its lists and ranges have more combinations; give a number of worlds to draw from them");
    worlds_ *= count;
  }
}

void Plan::add_components() {
  int dimensions = 0;
  std::uint64_t combinations = 1;
  for (std::size_t v = 0; v < variables_.size(); ++v) {
    const Variable& variable = variables_[v];
    for (std::size_t other = 0; other < v; ++other)
      if (variables_[other].key == variable.key)
        throw_error({"'" + variable.key + "' is varied twice", "", "remove one of them"});
    const auto* sampled = std::get_if<Sampled>(&variable.values);
    const std::size_t count = sampled ? sampled->components.size() : 1;
    if (combinations_) combinations *= entries_of(variable);
    for (std::size_t i = 0; i < count; ++i) {
      Component component{v, i, stream_of(variable.key) + i};
      component.divisor = combinations_ ? worlds_ / combinations : 1;
      if (sampled && sampled->how == Sampling::sobol) component.dimension = dimensions++;
      components_.push_back(component);
    }
  }
  if (dimensions > sobol_dimensions)
    throw_error({"a Sobol sequence has " + std::to_string(sobol_dimensions) + " dimensions, and " + std::to_string(dimensions) +
                     " values are drawn by it",
                 "", "draw those that matter least at random"});
}

std::string Plan::name(std::size_t component) const {
  const Component& c = components_[component];
  const auto* sampled = std::get_if<Sampled>(&variables_[c.variable].values);
  const bool several = sampled && sampled->components.size() > 1;
  return "'" + variables_[c.variable].key + (several ? "." + std::to_string(c.number) : "") + "'";
}

void Plan::add_correlations(const std::vector<Correlation>& correlations) {
  for (const auto& [a, b, coefficient] : correlations) {
    MT_REQUIRE(a < size() && b < size(), "correlations of components of the plan");
    if (a == b) throw_error({"a correlation of " + name(a) + " with itself", "", "name two different values"});
    const std::string pair = "the correlation of " + name(a) + " and " + name(b);
    if (!(std::abs(coefficient) < 1)) throw_error({pair + " is not between -1 and 1", "", "both ends are excluded"});
    for (const std::size_t one : {a, b}) {
      const auto* sampled = std::get_if<Sampled>(&variables_[components_[one].variable].values);
      if (!sampled || sampled->how == Sampling::latin)
        throw_error(
            {pair + " is impossible: " + name(one) + (sampled ? " is part of a Latin hypercube" : " is a list or a range"), "",
             "correlated values are distributions, drawn at random or by a Sobol sequence"});
      if (std::find(correlated_.begin(), correlated_.end(), one) == correlated_.end()) correlated_.push_back(one);
    }
    const auto same = [&](const Correlation& c) { return std::minmax(c.a, c.b) == std::minmax(a, b); };
    if (std::count_if(correlations.begin(), correlations.end(), same) > 1)
      throw_error({pair + " is given twice", "", "remove one"});
  }
  std::sort(correlated_.begin(), correlated_.end());
  const std::size_t n = correlated_.size();
  std::vector<double> matrix(n * n, 0);
  const auto place = [&](std::size_t c) {
    return static_cast<std::size_t>(std::lower_bound(correlated_.begin(), correlated_.end(), c) - correlated_.begin());
  };
  for (std::size_t i = 0; i < n; ++i) matrix[i * n + i] = 1;
  for (const auto& [a, b, coefficient] : correlations)
    matrix[place(a) * n + place(b)] = matrix[place(b) * n + place(a)] = coefficient;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t row = i * (i + 1) / 2;
    for (std::size_t j = 0; j <= i; ++j) {
      double rest = matrix[i * n + j];
      for (std::size_t k = 0; k < j; ++k) rest -= factor_[row + k] * factor_[j * (j + 1) / 2 + k];
      if (i == j && rest < 1e-12)
        throw_error({"the correlations contradict each other: no values have them all (their matrix is not positive definite)",
                     "",
                     name(correlated_[i]) + " completes the contradiction; give weaker correlations, or the missing ones: two "
                                            "values that are both correlated with a third are usually correlated as well"});
      factor_.push_back(i == j ? std::sqrt(rest) : rest / factor_[j * (j + 1) / 2 + j]);
    }
  }
  for (const std::size_t c : correlated_) components_[c].correlated = true;
}

double Plan::fraction(const Component& component, std::uint64_t world) const {
  const Random random(seed_, component.stream);
  switch (std::get<Sampled>(variables_[component.variable].values).how) {
    case Sampling::random: return random.uniform(world);
    case Sampling::sobol: return sobol(world, component.dimension, seed_);
    case Sampling::latin: break;
  }
  const std::uint64_t stratum = permute(world, worlds_, random.bits(~std::uint64_t{0}));
  return in_stratum(stratum, worlds_, random.uniform(world));
}

std::uint64_t Plan::entry(const Component& component, std::uint64_t world) const {
  const std::uint64_t count = entries_of(variables_[component.variable]);
  if (combinations_) return world / component.divisor % count;
  const double place = Random(seed_, component.stream).uniform(world) * static_cast<double>(count);
  return std::min(static_cast<std::uint64_t>(place), count - 1);
}

void Plan::values(std::uint64_t world, std::span<double> out) const {
  MT_REQUIRE(world < worlds_ && out.size() == size(), "a world of the plan, and room for its values");
  for (std::size_t i = 0; i < size(); ++i) {
    const Component& component = components_[i];
    const auto& values = variables_[component.variable].values;
    if (const auto* sampled = std::get_if<Sampled>(&values)) {
      const double u = fraction(component, world);
      out[i] = component.correlated ? normal_quantile(u) : sampled->components[component.number].quantile(u);
    } else if (const auto* range = std::get_if<RangeValues>(&values)) {
      out[i] = at_entry(*range, entry(component, world));
    } else {
      out[i] = static_cast<double>(entry(component, world));
    }
  }
  // The last rows first: a row needs the independent values of those before it.
  for (std::size_t i = correlated_.size(); i-- > 0;) {
    const double* row = factor_.data() + i * (i + 1) / 2;
    double z = 0;
    for (std::size_t j = 0; j <= i; ++j) z += row[j] * out[correlated_[j]];
    const Component& component = components_[correlated_[i]];
    const auto& sampled = std::get<Sampled>(variables_[component.variable].values);
    out[correlated_[i]] = sampled.components[component.number].quantile(std::clamp(normal_cdf(z), 0x1p-53, 1 - 0x1p-53));
  }
}

}  // namespace momentree::sweep
