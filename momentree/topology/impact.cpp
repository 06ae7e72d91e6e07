#include <algorithm>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/loops/loop_workspace.hpp>
#include <momentree/dynamics/loops/loops.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

namespace {

// Those of the solution for a unit impulse.
void scale_impulses(Workspace<double>& workspace, double impulse) noexcept {
  LoopWorkspace& loops = *workspace.loops;
  for (double& lambda : loops.lambda) lambda *= impulse;
  loops.strike.impulse = impulse * loops.strike.impulse;
}

double strike(const Impact& change, const Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  const int place = tree.loops().place(change.joint);
  MT_REQUIRE(place >= 0, "the loop joint is in the tree");
  double q[7] = {}, u[6] = {};
  loop_coordinates(tree, workspace, place, q, u);
  double* const y = workspace.impulse.get();
  const double unit = strike_loop(tree, state.q().data(), workspace, place, change.dof, y);
  const double impulse = -(1 + change.restitution) * u[change.dof] / unit;
  const State::Edit edit = state.edit();
  for (std::size_t k = 0; k < edit.u.size(); ++k) edit.u[k] += impulse * y[k];
  scale_impulses(workspace, impulse);
  return impulse;
}

}  // namespace

// The row of the constraint is the unit vector e of the DoF: y = M⁻¹ e, λ = −(1 + restitution) u / y, p += λ e. Velocities are
// linear in p, so one evaluation with p = e gives y.
double apply(const Impact& change, const Tree& tree, State& state, Workspace<double>& workspace) noexcept {
  if (is_loop(change.joint)) return strike(change, tree, state, workspace);
  const int b = tree.carrier(change.joint).index;
  MT_REQUIRE(evaluated_on(tree, state, workspace), stale_workspace(state));
  MT_REQUIRE(change.dof >= 0 && change.dof < info(tree.joint(b).kind).nv && (tree.joint(b).locked >> change.dof & 1u) == 0,
             "the joint has that degree of freedom, and it is not locked");
  MT_REQUIRE(change.restitution >= 0 && change.restitution <= 1, "a restitution from 0 to 1");
  const auto i = static_cast<std::size_t>(tree.first_p(b) + change.dof);
  const double u = workspace.v[i];
  if (state.variables() == Variables::velocities) {  // the factors are those of the evaluation
    double* const y = workspace.impulse.get();
    std::fill_n(y, tree.nv(), 0.0);
    y[i] = 1;
    if (tree.has_loops())
      solve_with_loops(tree, state.q().data(), workspace, y);
    else
      solve_with_factors<double>(tree, state.q().data(), workspace, y);
    const double impulse = -(1 + change.restitution) * u / y[i];
    const State::Edit edit = state.edit();
    for (std::size_t k = 0; k < edit.u.size(); ++k) edit.u[k] += impulse * y[k];
    if (tree.has_loops()) scale_impulses(workspace, impulse);
    return impulse;
  }
  std::fill_n(workspace.impulse.get(), tree.nv(), 0.0);
  workspace.impulse[i] = 1;
  evaluate_rates<double>(tree, state.q().data(), workspace.impulse.get(), workspace);
  const double impulse = -(1 + change.restitution) * u / workspace.v[i];
  state.edit().p[i] += impulse;
  return impulse;
}

}  // namespace momentree
