#pragma once
// Values of the wrong shape whose intention is clear, and how to write them: limits = [-1, 1], gravity = 9.81, a matrix.
#include <string>
#include <string_view>

#include <momentree/base/value.hpp>

namespace momentree::io {

/// A value as a scenario would have it, on one line; empty where that is long.
std::string as_written(const Value& value);

/// What to write in the place of `value`, which should be three numbers, a placement, an inertia or the table `where`; empty
/// where nobody could tell.
std::string cure_of_vector(std::string_view key, const Value& value);
std::string cure_of_placement(std::string_view key, const Value& value);
std::string cure_of_inertia(const Value& value);
std::string cure_of_table(std::string_view where, const Value& value);

}  // namespace momentree::io
