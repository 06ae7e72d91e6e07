#pragma once
// Values that a joint has one of per DoF or coordinate, with the units of its kind. Internal to the reader.
#include <string_view>
#include <vector>

#include <momentree/io/fields.hpp>
#include <momentree/io/joint_keys.hpp>

namespace momentree::io {

/// A list with one number per letter or, if `single` allows it, one number for all. Empty, with a report, if it is wrong.
Values read_values(const Value& value, Quantity quantity, std::string_view letters, bool single, std::string_view label,
                   Diagnostics& out);

/// A number, `{ table = [[t, value], …], ends }`, `{ sine = { amplitude, frequency, phase, offset } }` or `{ rate, offset }`;
/// nothing, with reports, if it is wrong. `motion`: the signal is a prescribed position, not an effort.
std::optional<Signal> read_signal(const Value& value, const Dimension& expected, std::string_view label, Diagnostics& out);
std::optional<Signal> read_signal(const Value& value, const Dimension& expected, std::string_view label, bool motion,
                                  Diagnostics& out);

}  // namespace momentree::io
