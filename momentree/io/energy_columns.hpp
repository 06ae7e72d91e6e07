#pragma once
// The rows of energy.csv: where the energy of the world is and went, and its momentum.
#include <string>

#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// `time`; `kinetic`, `gravity`, `elastic` (springs and soft stops); `dissipated`, `lost` in impacts, `released` and `work` since
/// the start, and the `error` of the balance (J); `linear.x .y .z` (N s) and `angular.x .y .z` (N m s): world axes, about the
/// world's origin.
void energy_header(std::string& text);
void energy_row(std::string& text, const Simulation& simulation);

}  // namespace momentree::io
