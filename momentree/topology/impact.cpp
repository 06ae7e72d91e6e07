#include <algorithm>

#include <momentree/dynamics/forward.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

double apply(const Impact& change, Tree& tree, State& state, Work<double>& work) noexcept {
  MT_REQUIRE(work.evaluated == state.stamp() && state.topology() == tree.revision(), "the work was evaluated on this state");
  const int b = change.body.index;
  const int i = tree.first_p(b) + change.freedom;
  MT_REQUIRE(
      change.freedom >= 0 && change.freedom < info(tree.joint(b).kind).nv && (tree.joint(b).locked >> change.freedom & 1u) == 0,
      "the freedom is there, and moves");
  const double u = work.v[static_cast<std::size_t>(i)];
  // y = H⁻¹ Jᵀ, J the unit row of the freedom: velocities are linear in momenta.
  double* unit = work.a.get();
  work.accelerated = {};
  std::fill_n(unit, tree.nv(), 0.0);
  unit[i] = 1;
  evaluate_rates<double>(tree, state.q().data(), unit, work);
  const double lambda = -(1 + change.restitution) * u / work.v[static_cast<std::size_t>(i)];
  state.edit().p[static_cast<std::size_t>(i)] += lambda;
  return lambda;
}

}  // namespace momentree
