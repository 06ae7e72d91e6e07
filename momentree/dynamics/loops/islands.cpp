#include <momentree/dynamics/loops/islands.hpp>

#include <algorithm>
#include <numeric>

namespace momentree {

Islands::Islands(const Tree& tree) : next_(static_cast<std::size_t>(tree.bodies())) {
  std::iota(next_.begin(), next_.end(), 0);
  for (const int b : tree.order()) join(b, tree.parent(b));
  for (const Loop& loop : tree.loops()) join(loop.body, loop.to);
  const std::span<const Coupling> couplings = tree.couplings();
  for (std::size_t c = 0; c < couplings.size(); ++c)
    if (couplings[c].leads() && tree.coupling_acts(static_cast<int>(c)))
      join(couplings[c].joint.index, couplings[c].follows.index);
}

void Islands::join(int a, int b) {
  if (a < 0 || b < 0) return;
  const int one = of(a), other = of(b);
  next_[static_cast<std::size_t>(std::max(one, other))] = std::min(one, other);
}

int Islands::of(int body) const {
  while (next_[static_cast<std::size_t>(body)] != body) {
    int& next = next_[static_cast<std::size_t>(body)];
    next = next_[static_cast<std::size_t>(next)];
    body = next;
  }
  return body;
}

}  // namespace momentree
