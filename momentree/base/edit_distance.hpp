#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace momentree {

/// How many letters apart two words are: inserted, left out, replaced, or swapped with their neighbour.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word in small letters, without '_', '-' and spaces: "Time-Step" and "time_step" are "timestep".
std::string plain_word(std::string_view word);

}  // namespace momentree
