#include <momentree/sweep/plan/measure.hpp>

#include <algorithm>
#include <cmath>

namespace momentree::sweep {

namespace {

struct EventValue {
  const char* name;
  const char* unit;
  double (*of)(const Event& event);
};

constexpr EventValue all_event_values[] = {
    {"time", "s", [](const Event& e) { return e.time; }},
    {"lost", "J", [](const Event& e) { return e.lost; }},
    {"released", "J", [](const Event& e) { return e.released; }},
    {"work", "J", [](const Event& e) { return e.work; }},
    {"before.kinetic", "J", [](const Event& e) { return e.before.kinetic; }},
    {"before.potential", "J", [](const Event& e) { return e.before.potential; }},
    {"before.linear.x", "N s", [](const Event& e) { return e.before.linear.x; }},
    {"before.linear.y", "N s", [](const Event& e) { return e.before.linear.y; }},
    {"before.linear.z", "N s", [](const Event& e) { return e.before.linear.z; }},
    {"before.angular.x", "N m s", [](const Event& e) { return e.before.angular.x; }},
    {"before.angular.y", "N m s", [](const Event& e) { return e.before.angular.y; }},
    {"before.angular.z", "N m s", [](const Event& e) { return e.before.angular.z; }},
    {"after.kinetic", "J", [](const Event& e) { return e.after.kinetic; }},
    {"after.potential", "J", [](const Event& e) { return e.after.potential; }},
    {"after.linear.x", "N s", [](const Event& e) { return e.after.linear.x; }},
    {"after.linear.y", "N s", [](const Event& e) { return e.after.linear.y; }},
    {"after.linear.z", "N s", [](const Event& e) { return e.after.linear.z; }},
    {"after.angular.x", "N m s", [](const Event& e) { return e.after.angular.x; }},
    {"after.angular.y", "N m s", [](const Event& e) { return e.after.angular.y; }},
    {"after.angular.z", "N m s", [](const Event& e) { return e.after.angular.z; }},
    {"ground_impulse.x", "N s", [](const Event& e) { return e.ground_impulse[0]; }},
    {"ground_impulse.y", "N s", [](const Event& e) { return e.ground_impulse[1]; }},
    {"ground_impulse.z", "N s", [](const Event& e) { return e.ground_impulse[2]; }},
    {"hardest.linear", "N s", [](const Event& e) { return e.hardest_linear; }},
    {"hardest.angular", "N m s", [](const Event& e) { return e.hardest_angular; }},
};

const EventValue* find_event_value(std::string_view name) {
  for (const EventValue& each : all_event_values)
    if (name == each.name) return &each;
  return nullptr;
}

double of_events(const EventMeasure& measure, const std::vector<Event>& events) {
  using What = EventMeasure::What;
  long count = 0;
  const Event* chosen = nullptr;
  const auto visit = [&](const Event& event) {
    if (event.name != measure.event) return;
    if (++count == std::labs(measure.number)) chosen = &event;
  };
  if (measure.number > 0)
    std::for_each(events.begin(), events.end(), visit);
  else
    std::for_each(events.rbegin(), events.rend(), visit);
  if (measure.what == What::count) return static_cast<double>(count);
  if (measure.what == What::happened) return chosen != nullptr ? 1 : 0;
  if (chosen == nullptr) return NAN;
  return measure.what == What::time ? chosen->time : event_value(*chosen, measure.value);
}

}  // namespace

const std::vector<std::string>& event_values() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const EventValue& each : all_event_values) all.emplace_back(each.name);
    return all;
  }();
  return names;
}

std::string unit_of_event_value(std::string_view value) {
  const EventValue* const found = find_event_value(value);
  return found != nullptr ? found->unit : "";
}

double event_value(const Event& event, std::string_view value) {
  const EventValue* const found = find_event_value(value);
  return found != nullptr ? found->of(event) : NAN;
}

bool needs_ledger(const Measure& measure) {
  const Source* source = nullptr;
  if (const auto* fold = std::get_if<FoldMeasure>(&measure.what)) source = &fold->source;
  if (const auto* instant = std::get_if<InstantMeasure>(&measure.what)) source = &instant->source;
  const auto* column = source != nullptr ? std::get_if<io::ResultColumn>(source) : nullptr;
  return column != nullptr && column->of_ledger();
}

double value_of(const Source& source, const Simulation& simulation) {
  if (const auto* column = std::get_if<io::ResultColumn>(&source)) return column->value(simulation);
  const World& world = simulation.world();
  const std::vector<Event>& events = simulation.events();
  std::size_t first = events.size();
  while (first > 0 && events[first - 1].time == world.time()) --first;
  return std::get<std::shared_ptr<const Quantity>>(source)
      ->value(world, {events.data() + first, events.size() - first})
      .value_or(NAN);
}

Observation::Observation(const std::vector<Measure>& measures)
    : measures_(measures), folds_(measures.size()), at_(measures.size(), NAN) {
  for (const Measure& measure : measures) {
    if (std::holds_alternative<FoldMeasure>(measure.what)) samples_ = true;
    if (const auto* instant = std::get_if<InstantMeasure>(&measure.what); instant != nullptr && instant->at)
      instants_.push_back(*instant->at);
  }
  std::sort(instants_.begin(), instants_.end());
  instants_.erase(std::unique(instants_.begin(), instants_.end()), instants_.end());
}

void Observation::sample(const Simulation& simulation) {
  const double time = simulation.time();
  for (std::size_t m = 0; m < measures_.size(); ++m) {
    const auto* measure = std::get_if<FoldMeasure>(&measures_[m].what);
    if (measure == nullptr) continue;
    const double value = value_of(measure->source, simulation);
    Fold& fold = folds_[m];
    if (std::isnan(value)) {
      if (measure->what == FoldMeasure::What::mean) fold.any = false;  // the mean is over the times at which it exists
      continue;
    }
    if (measure->what == FoldMeasure::What::mean) {
      if (fold.any) {
        fold.integral += 0.5 * (fold.value + value) * (time - fold.time);
        fold.span += time - fold.time;
      }
      fold = {value, time, fold.integral, fold.span, true};
    } else if (!fold.any || (measure->what == FoldMeasure::What::max ? value > fold.value : value < fold.value)) {
      fold = {value, time, 0, 0, true};
    }
  }
}

void Observation::instant(const Simulation& simulation, double time) {
  for (std::size_t m = 0; m < measures_.size(); ++m)
    if (const auto* measure = std::get_if<InstantMeasure>(&measures_[m].what); measure != nullptr && measure->at == time)
      at_[m] = value_of(measure->source, simulation);
}

std::vector<double> Observation::results(const Simulation& simulation) const {
  std::vector<double> all;
  for (std::size_t m = 0; m < measures_.size(); ++m) {
    const Fold& fold = folds_[m];
    if (const auto* event = std::get_if<EventMeasure>(&measures_[m].what)) {
      all.push_back(of_events(*event, simulation.events()));
    } else if (const auto* measure = std::get_if<FoldMeasure>(&measures_[m].what)) {
      if (measure->what == FoldMeasure::What::mean)
        all.push_back(fold.span > 0 ? fold.integral / fold.span : fold.any ? fold.value : NAN);
      else
        all.push_back(!fold.any ? NAN : measure->time ? fold.time : fold.value);
    } else {
      const auto& instant = std::get<InstantMeasure>(measures_[m].what);
      all.push_back(instant.at ? at_[m] : value_of(instant.source, simulation));
    }
  }
  return all;
}

}  // namespace momentree::sweep
