#pragma once
// Closes the loops of a start state.
#include <optional>

#include <momentree/base/error.hpp>
#include <momentree/simulate/names.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

/// Closes the loops by the least change of the coordinates, then projects the velocities, both in the metric of the mass matrix.
/// The state, in velocities, is left unchanged if nothing is open. Returns the mistake if a loop cannot be closed: `where` is
/// "loop 'name'".
[[nodiscard]] std::optional<Error> assemble(const Tree& tree, const Model& model, const Names& names, State& state);

/// The mistake if prescribed motions of joints in loops are not independent: a motion that follows from others, or that loops and
/// locks do not allow. `where` is "joint 'name'".
[[nodiscard]] std::optional<Error> conflicting_motions(const Tree& tree, const Names& names, const State& state);

/// The mistake if a loop joint starts beyond its hard stops.
[[nodiscard]] std::optional<Error> beyond_stops(const Tree& tree, const Names& names, const State& state);

/// The mistake that keeps a model's loops from being closed at the start.
[[nodiscard]] std::optional<Error> check_assembly(const Model& model);

}  // namespace momentree
