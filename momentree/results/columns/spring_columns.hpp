#pragma once
// The rows of springs.csv, which the results of a model with springs have.
#include <array>
#include <string>
#include <vector>

#include <momentree/simulate/world/world.hpp>

namespace momentree::io {

/// Of one spring: length (m), its rate (m/s) and tension (N).
inline constexpr std::array<const char*, 3> spring_column_names = {"length", "rate", "tension"};
inline constexpr std::array<const char*, 3> spring_column_units = {"m", "m/s", "N"};
/// These numbers now; NaN once the spring is broken.
std::array<double, 3> spring_numbers(const World& world, int spring);

/// `time` (s), then per spring its three columns, named `rope.length` and so on; their cells are empty once it is broken.
void spring_header(std::string& text, const Model& model);
void spring_row(std::string& text, const World& world);

}  // namespace momentree::io
