#pragma once
// The rows of energy.csv: the energy ledger and the momentum of the world.
#include <array>
#include <string>
#include <vector>

#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// `time` (s); `kinetic`, `gravity`, `elastic` (springs and soft stops); `dissipated`, `lost` in impacts, `released` and `work`
/// since the start, and the `error` of the balance (all J); `linear.x .y .z` (N s) and `angular.x .y .z` (N m s) in world axes,
/// about the world's origin.
void energy_header(std::string& text);
void energy_row(std::string& text, const World& world, const EnergyBalance& balance);

/// The names and the numbers of these columns without `time`.
std::vector<std::string> energy_column_names();
std::array<double, 14> energy_numbers(const World& world, const EnergyBalance& balance);

}  // namespace momentree::io
