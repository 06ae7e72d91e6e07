#include <algorithm>

#include <momentree/dynamics/forward.hpp>
#include <momentree/topology/change.hpp>

namespace momentree {

// The row of the constraint is the unit vector e of the freedom: y = M⁻¹ e, λ = −(1 + restitution) u / y, p += λ e. Velocities
// are linear in p, so one evaluation with p = e solves for y.
double apply(const Impact& change, const Tree& tree, State& state, Work<double>& work) noexcept {
  const int b = change.body.index;
  MT_REQUIRE(evaluated_on(tree, state, work), stale_work(state));
  MT_REQUIRE(
      change.freedom >= 0 && change.freedom < info(tree.joint(b).kind).nv && (tree.joint(b).locked >> change.freedom & 1u) == 0,
      "the joint has that freedom, and it is not locked");
  MT_REQUIRE(change.restitution >= 0 && change.restitution <= 1, "a restitution from 0 to 1");
  const auto i = static_cast<std::size_t>(tree.first_p(b) + change.freedom);
  const double u = work.v[i];
  std::fill_n(work.impulse.get(), tree.nv(), 0.0);
  work.impulse[i] = 1;
  evaluate_rates<double>(tree, state.q().data(), work.impulse.get(), work);
  const double impulse = -(1 + change.restitution) * u / work.v[i];
  state.edit().p[i] += impulse;
  return impulse;
}

}  // namespace momentree
