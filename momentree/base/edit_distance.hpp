#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace momentree {

/// Number of letters inserted, omitted, replaced, or swapped with their neighbour between two words.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word in lower case without '_', '-' and spaces: "Time-Step" and "time_step" both give "timestep".
std::string plain_word(std::string_view word);

}  // namespace momentree
