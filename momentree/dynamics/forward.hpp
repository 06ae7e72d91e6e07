#pragma once
// (q, p) → (q̇, ṗ) in two recursions, O(n): backward (22)–(26), forward (27), (17), (21), (20).
#include <momentree/dynamics/workspace.hpp>
#include <momentree/model/model.hpp>
#include <momentree/tree/state.hpp>

namespace momentree {

/// The state with a model's start values q and v at time 0; joints with prescribed motion start at its values. The tree must be
/// as compiled from this model.
[[nodiscard]] State start_state(const Model& model, const Tree& tree, Variables variables = Variables::momenta);

/// One evaluation of a state of this tree, with the joint and body forces at its time: writes workspace.v, qdot and pdot, and the
/// workspace then carries the state's stamp. A workspace that carries it already is left unchanged. Neither allocates nor throws.
/// Stops the program for a state of another tree, or a workspace made for a smaller one.
void forward_dynamics(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

/// Writes world poses and velocities of all bodies (kernel frames) to workspace.bodies; evaluates the state first if needed.
void locate_bodies(const Tree& tree, const State& state, Workspace<double>& workspace) noexcept;

}  // namespace momentree
