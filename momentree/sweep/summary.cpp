#include <momentree/sweep/summary.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/sweep/stats/estimates.hpp>
#include <momentree/text/number_text.hpp>

#ifndef MOMENTREE_VERSION
#error "MOMENTREE_VERSION is set by the build"
#endif

namespace momentree::sweep {

namespace {

constexpr std::size_t most_failures = 100;
constexpr std::size_t most_shown = 20'000;
constexpr std::size_t most_worst = 10;
constexpr double listed_shares[] = {0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99};

io::JsonWriter& member_count(io::JsonWriter& json, std::string_view name, std::uint64_t count) {
  return json.key(name).value(static_cast<long>(count));
}

}  // namespace

std::string page_of_world(std::uint64_t world) { return "world-" + std::to_string(world) + ".html"; }

SweepSummary::SweepSummary(const Sweep& sweep)
    : sweep_(sweep),
      columns_(parameter_columns(sweep)),
      statistics_(columns_.size() + sweep.measures.size(), {.extremes = most_worst}) {}

void SweepSummary::add(const Row& row) {
  std::vector<double> numbers;
  numbers.reserve(statistics_.columns());
  for (const ParameterColumn& column : columns_) numbers.push_back(parameter_number(column, row.values));
  for (std::size_t m = 0; m < sweep_.measures.size(); ++m) numbers.push_back(row.result.done() ? row.result.measures[m] : NAN);
  statistics_.add(row.world, numbers);
  if (row.result.done()) {
    ++done_;
    return;
  }
  ++failed_;
  if (failures_.size() < most_failures) failures_.push_back({row.world, row.result.failure});
}

std::string SweepSummary::name(std::size_t column) const {
  return column < columns_.size() ? columns_[column].name : sweep_.measures[column - columns_.size()].name;
}

std::vector<Worst> SweepSummary::worst(std::size_t count) const {
  std::vector<Worst> all;
  for (std::size_t m = 0; m < sweep_.measures.size(); ++m) {
    if (sweep_.measures[m].is_flag()) continue;
    Summary summary = statistics_.summary(columns_.size() + m);
    summary.largest.resize(std::min(summary.largest.size(), count));
    summary.smallest.resize(std::min(summary.smallest.size(), count));
    if (summary.largest.empty()) continue;
    all.push_back({sweep_.measures[m].name, true, std::move(summary.largest)});
    all.push_back({sweep_.measures[m].name, false, std::move(summary.smallest)});
  }
  return all;
}

void SweepSummary::write_column(io::JsonWriter& json, std::size_t column, const std::vector<double>& sample) const {
  const bool varied = column < columns_.size();
  const Parameter* const parameter = varied ? &sweep_.parameters[columns_[column].parameter] : nullptr;
  const Measure* const measure = varied ? nullptr : &sweep_.measures[column - columns_.size()];
  const bool text = varied && columns_[column].is_text, flag = measure != nullptr && measure->is_flag();
  json.begin_object().member("name", name(column)).member("role", varied ? "vary" : "measure");
  json.member("kind", text ? "text" : flag ? "flag" : "number");
  json.member("about", varied ? parameter->about : measure->about).member("unit", varied ? parameter->unit : measure->unit);
  const Summary summary = statistics_.summary(column);
  if (!text) {
    member_count(json, "count", summary.count);
    member_count(json, "missing", summary.missing);
  }
  if (flag && summary.count > 0) {
    const Interval interval = wilson_interval(summary.nonzero, summary.count);
    json.member("share", static_cast<double>(summary.nonzero) / static_cast<double>(summary.count));
    json.key("interval").begin_array().value(interval.lowest).value(interval.highest).end_array();
  } else if (!text && summary.count > 0) {
    json.member("mean", summary.mean).member("deviation", summary.deviation);
    json.member("least", summary.smallest.front().value).member("greatest", summary.largest.front().value);
    member_count(json, "least_world", summary.smallest.front().world);
    member_count(json, "greatest_world", summary.largest.front().world);
    const std::vector<double> values = sorted(sample);
    json.key("quantiles").begin_object();
    for (const double share : listed_shares) json.member(io::number_text(share), quantile(values, share));
    json.end_object();
    if (const Histogram bins = histogram(values); !bins.counts.empty()) {
      json.key("histogram").begin_object().member("from", bins.edges.front()).member("to", bins.edges.back());
      json.key("counts").begin_array();
      for (const std::uint64_t count : bins.counts) json.value(static_cast<long>(count));
      json.end_array().end_object();
    }
  }
  json.end_object();
}

void SweepSummary::write_sensitivities(io::JsonWriter& json, const std::vector<std::vector<double>>& sample) const {
  json.key("sensitivities").begin_array();
  const auto write = [&json](const char* key, std::optional<double> value) {
    json.key(key);
    if (value)
      json.value(*value);
    else
      json.null();
  };
  for (std::size_t m = columns_.size(); m < sample.size(); ++m) {
    const bool conditional = statistics_.summary(m).missing > 0;
    for (std::size_t v = 0; v < columns_.size(); ++v) {
      if (columns_[v].is_text) continue;
      const auto of = [c = columns_[v].component](const Correlation& each) {
        return each.coefficient != 0 && (each.a == c || each.b == c);
      };
      std::uint64_t pairs = 0;
      for (std::size_t i = 0; i < sample[m].size(); ++i) pairs += std::isfinite(sample[v][i]) && std::isfinite(sample[m][i]);
      json.begin_object().member("measure", name(m)).member("vary", name(v));
      write("correlation", rank_correlation(sample[v], sample[m]));
      write("first_order", sobol_index(sample[v], sample[m]));
      member_count(json, "pairs", pairs);
      json.member("conditional", conditional);
      json.member("correlated", std::any_of(sweep_.correlations.begin(), sweep_.correlations.end(), of));
      json.end_object();
    }
  }
  json.end_array();
}

void SweepSummary::write_values(io::JsonWriter& json, const std::vector<std::vector<double>>& sample) const {
  const std::vector<std::uint64_t> worlds = statistics_.sample().worlds();
  const std::vector<std::size_t> shown = statistics_.sample().smallest(most_shown);
  json.key("values").begin_object().key("world").begin_array();
  for (const std::size_t i : shown) json.value(static_cast<long>(worlds[i]));
  json.end_array();
  std::vector<double> values(sweep_.plan->size());
  for (std::size_t c = 0; c < sample.size(); ++c) {
    const bool text = c < columns_.size() && columns_[c].is_text;
    const bool flag = c >= columns_.size() && sweep_.measures[c - columns_.size()].is_flag();
    json.key(name(c)).begin_array();
    for (const std::size_t i : shown) {
      if (text) {
        sweep_.plan->values(worlds[i], values);
        json.value(parameter_text(columns_[c], values));
      } else if (flag && !std::isnan(sample[c][i])) {
        json.value(sample[c][i] != 0);
      } else {
        json.value(sample[c][i]);
      }
    }
    json.end_array();
  }
  json.end_object();
}

void SweepSummary::write_worst(io::JsonWriter& json, const std::vector<std::uint64_t>& animated) const {
  json.key("worst").begin_array();
  for (const Worst& worst : this->worst(most_worst)) {
    json.begin_object().member("measure", worst.measure).member("end", worst.greatest ? "greatest" : "least");
    json.key("worlds").begin_array();
    for (const Extreme& each : worst.worlds) {
      member_count(json.begin_object(), "world", each.world).member("value", each.value);
      json.member("replay", replay_command(sweep_, each.world)).key("animation");
      if (std::find(animated.begin(), animated.end(), each.world) != animated.end())
        json.value(page_of_world(each.world));
      else
        json.null();
      json.end_object();
    }
    json.end_array().end_object();
  }
  json.end_array();
}

std::string SweepSummary::document(bool with_values, const std::vector<std::uint64_t>& animated) const {
  std::string text;
  io::JsonWriter json(text, with_values ? 1 : 2);
  json.begin_object().member("format", 1).key("program").begin_object().member("name", "momentree");
  json.member("version", MOMENTREE_VERSION).end_object();
  json.member("title", sweep_.title.empty() ? sweep_.name : sweep_.title).member("sweep", sweep_.path);
  json.member("scenario", sweep_.scenario->path).member("hash", sweep_.hash);
  if (!former_.empty()) {
    json.key("accepted_changes").begin_array();
    for (const FormerIdentity& each : former_)
      json.begin_object().member("version", each.version).member("hash", each.hash).end_object();
    json.end_array();
  }
  member_count(json, "seed", sweep_.seed);
  member_count(json, "worlds", sweep_.worlds());
  member_count(json, "done", done_);
  member_count(json, "failed", failed_);
  std::vector<std::vector<double>> sample;
  for (std::size_t c = 0; c < statistics_.columns(); ++c) sample.push_back(statistics_.sample().column(c));
  if (with_values) member_count(json, "shown", std::min(statistics_.sample().size(), most_shown));
  json.key("columns").begin_array();
  for (std::size_t c = 0; c < sample.size(); ++c) write_column(json, c, sample[c]);
  json.end_array();
  write_sensitivities(json, sample);
  if (with_values) write_values(json, sample);
  json.key("failures").begin_array();
  for (const Failure& failure : failures_)
    member_count(json.begin_object(), "world", failure.world)
        .member("why", failure.why)
        .member("replay", replay_command(sweep_, failure.world))
        .end_object();
  json.end_array();
  member_count(json, "failures_listed", failures_.size());
  write_worst(json, animated);
  json.end_object();
  return text + '\n';
}

std::string SweepSummary::json() const { return document(false, {}); }
std::string SweepSummary::report(const std::vector<std::uint64_t>& animated) const { return document(true, animated); }

std::vector<std::vector<std::string>> SweepSummary::table() const {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t m = 0; m < sweep_.measures.size(); ++m) {
    const Measure& measure = sweep_.measures[m];
    const Summary summary = statistics_.summary(columns_.size() + m);
    std::vector<std::string> row = {measure.name};
    const auto number = [&](double x) { return io::rounded_text(x, 5) + (measure.unit.empty() ? "" : ' ' + measure.unit); };
    if (summary.count == 0) {
      row.insert(row.end(), {"—", "", "", ""});
    } else if (measure.is_flag()) {
      const Interval interval = wilson_interval(summary.nonzero, summary.count);
      const double share = static_cast<double>(summary.nonzero) / static_cast<double>(summary.count);
      row.push_back(io::rounded_text(100 * share, 4) + " %");
      row.push_back(io::rounded_text(100 * interval.lowest, 4) + " to " + io::rounded_text(100 * interval.highest, 4) + " %");
      row.insert(row.end(), {"", ""});
    } else {
      row.push_back(number(summary.mean));
      row.push_back(std::isnan(summary.deviation) ? "" : number(summary.deviation));
      row.push_back(number(summary.smallest.front().value));
      row.push_back(number(summary.largest.front().value));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace momentree::sweep
