#pragma once
// Closes the loops of a start state.
#include <optional>
#include <vector>

#include <momentree/base/error.hpp>
#include <momentree/simulate/names.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

/// Which start values were given, by DoF: 1, or 0 for those that may change freely. Empty: no value was given.
struct GivenStart {
  std::vector<char> q, v;
  bool by_run = false;  ///< a run left all of them: what its method takes for closed is so
};

/// What the model gives for the joints of a tree that was compiled from it.
[[nodiscard]] GivenStart given_start(const Model& model, const Tree& tree);

/// Closes the loops by the least change of the coordinates, then projects the velocities, both in the metric of the mass matrix.
/// Given values are kept; where they contradict each other, they change as well. Of velocities, zeros give way first. A state in
/// which nothing is open is left unchanged, and so is one that a run left. Returns the mistake if a loop cannot be closed
/// (`where` is "loop 'name'"), or if that puts a joint beyond its hard stop ("joint 'name'").
[[nodiscard]] std::optional<Error> assemble(const Tree& tree, const Model& model, const Names& names, State& state,
                                            const GivenStart& given = {});

/// The mistake if prescribed motions of joints in loops are not independent: a motion that follows from others, or that loops and
/// locks do not allow. `where` is "joint 'name'".
[[nodiscard]] std::optional<Error> conflicting_motions(const Tree& tree, const Names& names, const State& state);

/// The mistake if a loop joint starts beyond its hard stops.
[[nodiscard]] std::optional<Error> beyond_stops(const Tree& tree, const Names& names, const State& state);

/// The mistake that keeps a model's loops from being closed at the start.
[[nodiscard]] std::optional<Error> check_assembly(const Model& model);

}  // namespace momentree
