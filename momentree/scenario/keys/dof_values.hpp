#pragma once
// Values that a joint has one of per DoF or coordinate, with the units of its kind. Internal to the reader.
#include <string_view>
#include <vector>

#include <momentree/scenario/keys/fields.hpp>
#include <momentree/scenario/keys/joint_keys.hpp>

namespace momentree::io {

/// A list with one number per letter or, if `single` allows it, one number for all. Empty, with a report, if it is wrong.
/// `infinite`: the numbers may be infinite.
Values read_values(const Value& value, Quantity quantity, std::string_view letters, bool single, std::string_view label,
                   Diagnostics& out, bool infinite = false);
/// Like read_number, for a number that may be infinite.
std::optional<double> read_extended(const Value& value, const Dimension& expected, bool infinite, std::string_view label,
                                    Diagnostics& out);

/// What a signal may be: in a state document its numbers have no units; a motion is a prescribed position, not an effort.
struct SignalRules {
  Dimension expected{};
  bool motion = false, document = false;
};
/// A number, `{ table = [[t, value], …], ends }`, `{ sine = { amplitude, frequency, phase, offset } }` or `{ rate, offset }`;
/// nothing, with reports, if it is wrong.
std::optional<Signal> read_signal(const Value& value, const SignalRules& rules, std::string_view label, Diagnostics& out);

}  // namespace momentree::io
