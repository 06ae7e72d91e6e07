#include <momentree/simulate/world/connections.hpp>

namespace momentree {

void Connections::update(const Tree& tree) {
  const auto bodies = static_cast<std::size_t>(tree.bodies());
  if (revision_ == tree.revision() && welded_.size() == bodies) return;
  revision_ = tree.revision();
  welded_.resize(bodies), parent_.assign(bodies, -1), loops_.clear();
  for (int b = 0; b < tree.bodies(); ++b) welded_[at(b)] = b;
  for (const int b : tree.order()) {
    if (tree.kind(b) != Kind::free) parent_[at(b)] = tree.parent(b);
    if (tree.kind(b) == Kind::weld) welded_[at(b)] = first_welded(tree.parent(b));
  }
  for (const Loop& loop : tree.loops()) {
    if (loop.to >= 0) loops_.emplace_back(std::min(loop.body, loop.to), std::max(loop.body, loop.to));
    if (loop.joint.kind != Kind::weld) continue;
    const int one = first_welded(loop.body), other = first_welded(loop.to);
    std::replace(welded_.begin(), welded_.end(), std::max(one, other), std::min(one, other));
  }
  std::sort(loops_.begin(), loops_.end());
}

}  // namespace momentree
