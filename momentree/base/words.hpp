#pragma once
#include <cstddef>
#include <string_view>

namespace momentree {

/// How many letters apart two words are: inserted, left out, replaced, or swapped with their neighbour.
std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace momentree
