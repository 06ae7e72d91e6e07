#pragma once
// Reads the arguments of actions and quantities. Internal to the reader.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <momentree/scenario/scenario_parts.hpp>

namespace momentree::io {

/// Reads all arguments of an action or a quantity, each as its kind says.
class ArgumentReader {
 public:
  /// `match`: of a wildcard; without its pattern, it stands for every name. `time` (s): of the event.
  ArgumentReader(const Value& value, WithArguments& what, TriggerMatch match, double time, Reading& reading);
  /// False, with reports, if something is wrong.
  bool read();

  const Value& value;  ///< a table, or the value of one argument
  WithArguments& what;
  const std::string key;  ///< of the action or quantity, for messages
  Reading& reading;
  Diagnostics& out;
  const double time;
  /// The kinds that a joint can have when the action takes effect, the likeliest first; empty: unknown.
  std::function<std::vector<const KindInfo*>(const std::string& joint)> kinds_of;

  /// Null if the value is not a table.
  Fields* table();
  /// The value of an argument; null if it is absent, with a report if it is required.
  const Value* find(const char* argument, bool required = false);
  /// The value of a required argument, which is that of a quantity if it has no other, even a table.
  const Value* given(const char* argument) { return alone_ ? &value : find(argument, true); }
  /// Nothing for null or, with a report, for anything but a string.
  std::optional<std::string> text(const Value* given, const char* argument);
  bool wild() const { return !match_.joint.empty(); }
  /// True for a name with the wildcard.
  bool matches(const std::string& name) const { return wild() && (match_.pattern.empty() || name == match_.pattern); }
  std::string matched(const std::string& name, std::string TriggerMatch::*which) const {
    return matches(name) ? match_.*which : name;
  }
  /// At least one of the arguments for which this is called must be given.
  void effect(bool given) { acts_ = given || acts_.value_or(false); }
  void error(const Value& at, const std::string& problem, std::string hint = {}) {
    out.error(at.place, key + ": " + problem, std::move(hint));
  }

 private:
  const TriggerMatch match_;
  const bool of_quantity_;
  bool alone_ = false;
  std::optional<Fields> fields_;
  std::optional<bool> acts_;
};

}  // namespace momentree::io
