#pragma once
// Reads worlds.csv of a complete sweep again.
#include <functional>
#include <string_view>

#include <momentree/sweep/results.hpp>

namespace momentree::sweep {

/// Calls `take` with the result of each world, from 0. `text`: as RowWriter::csv() wrote it, with its header. False: the text is
/// not the table of that sweep, with a row for each of its worlds; some may then have been taken.
[[nodiscard]] bool read_csv(const Sweep& sweep, std::string_view text, const std::function<void(WorldResult)>& take);

}  // namespace momentree::sweep
