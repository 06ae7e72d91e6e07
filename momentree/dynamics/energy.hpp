#pragma once
#include <momentree/dynamics/motion.hpp>
#include <momentree/dynamics/workspace.hpp>

namespace momentree {

/// Energies and momenta of the whole world, summed over the bodies (never p·u/2). Locates the bodies if needed.
[[nodiscard]] Totals totals(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

}  // namespace momentree
