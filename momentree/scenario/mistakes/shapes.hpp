#pragma once
// Hints for values of the wrong shape whose intention is clear: limits = [-1, 1], gravity = 9.81, a matrix.
#include <string>
#include <string_view>

#include <momentree/base/value.hpp>

namespace momentree::io {

/// A value as it would be written in a scenario, on one line; empty if that is too long.
std::string as_written(const Value& value);

/// What to write instead of `value`, which should be three numbers, a placement, an inertia or the table `where`; empty if the
/// intention is unclear.
std::string cure_of_vector(std::string_view key, const Value& value);
std::string cure_of_placement(std::string_view key, const Value& value);
std::string cure_of_inertia(const Value& value);
std::string cure_of_table(std::string_view where, const Value& value);
/// The hint for a zero of the table `where` that must be greater.
std::string cure_of_zero(std::string_view where, std::string_view key);

}  // namespace momentree::io
