#include <momentree/scenario/state/changed_start.hpp>

#include <algorithm>
#include <cmath>

#include <momentree/text/diagnostic.hpp>
#include <momentree/text/number_text.hpp>

namespace momentree::io {

namespace {

// "rad", "m/s": of the coordinates or velocities of a joint; empty if they have different ones.
std::string unit_of_start(const KindInfo& kind, bool rates) {
  const char* const units = rates ? kind.v_units : kind.q_units;
  const int count = rates ? kind.nv : kind.nq;
  for (int i = 0; i < count; ++i)
    if (units[i] != units[0] || units[i] == 'n') return {};
  return std::string(units[0] == 'r' ? " rad" : " m") + (rates ? "/s" : "");
}

std::string start_text(std::span<const double> values, int digits) {
  std::string text;
  for (const double x : values) text += (text.empty() ? "" : ", ") + rounded_text(x, digits);
  return values.size() == 1 ? text : "[" + text + "]";
}

// "'m/crank' starts at 48.2 rad/s, not at 40 rad/s"; empty if they differ by round-off.
std::string changed_value(const std::string& name, std::span<const double> given, std::span<const double> used,
                          const std::string& unit) {
  constexpr double round_off = 1e-9;
  bool changed = false;
  for (std::size_t i = 0; i < given.size(); ++i)
    changed = changed || std::fabs(used[i] - given[i]) > round_off * std::max(1.0, std::fabs(given[i]));
  if (!changed) return {};
  int digits = 3;
  while (digits < 15 && start_text(given, digits) == start_text(used, digits)) ++digits;
  return in_quotes(name) + " starts at " + start_text(used, digits) + unit + ", not at " + start_text(given, digits) + unit;
}

}  // namespace

std::optional<ChangedStart> changed_start(const World& world, std::span<const JointStart> given) {
  constexpr int most_named = 6;
  std::string changes;
  int count = 0;
  JointId first;
  for (const JointStart& start : given) {
    const JointView joint = world.joint(start.joint);
    if (joint.driven) continue;
    const auto note = [&](const Values& values, std::span<const double> used, bool rates) {
      const std::string change = changed_value(std::string(joint.name), {values.begin(), static_cast<std::size_t>(values.size())},
                                               used, unit_of_start(info(joint.kind), rates));
      if (change.empty()) return;
      if (count == 0) first = start.joint;
      if (++count <= most_named) changes += (changes.empty() ? "" : "; ") + change;
    };
    note(start.q, joint.q, false);
    note(start.v, joint.v, true);
  }
  if (count == 0) return std::nullopt;
  if (count > most_named) changes += "; and " + std::to_string(count - most_named) + " more";
  return ChangedStart{"the loops and couplings don't allow these start values: " + changes,
                      "leave out those that follow from others, or give them with more digits; if they are as you mean them, "
                      "check the axes and frames of the loops",
                      first};
}

std::optional<ChangedStart> changed_start(const World& world) {
  const Model& model = world.model();
  std::vector<JointStart> given;
  for (int j = 0; j < model.size(); ++j)
    if (world.joint({j}).kind == model[{j}].joint.kind) given.push_back({{j}, model[{j}].q, model[{j}].v, {}});
  return changed_start(world, given);
}

}  // namespace momentree::io
