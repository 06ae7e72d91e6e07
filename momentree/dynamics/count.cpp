#include <momentree/dynamics/count.hpp>

#include <new>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/steps/step_table.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

extern template void evaluate_rates<Counted>(const Tree&, const Counted*, const Counted*, Workspace<Counted>&) noexcept;

Operations count_operations(const Tree& tree) {
  Workspace<Counted> workspace(tree);
  auto& steps = workspace.table(Passes::stage_momenta);
  steps = detail::make_step_table(detail::counting_scalar());
  if (!steps->follow(tree)) throw std::bad_alloc();
  std::vector<Counted> q(static_cast<std::size_t>(tree.nq())), p(static_cast<std::size_t>(tree.nv()), Counted(0));
  for (const int b : tree.order())
    dispatch(tree.kind(b), [&](auto tag) {
      double zero[7] = {};
      decltype(tag)::type::Kernels::zero(zero);
      for (int i = 0; i < info(tree.kind(b)).nq; ++i) q[static_cast<std::size_t>(tree.first_q(b) + i)] = zero[i];
    });
  Counted::operations() = {};
  evaluate_rates(tree, q.data(), p.data(), workspace);
  return Counted::operations();
}

}  // namespace momentree
