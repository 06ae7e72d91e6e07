// Finds plane mechanisms, from what the tree stores: numbers meant to be 0 or ±1 are exactly that in links (frames.cpp).
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

// True if the mechanism whose root has that place is grounded and plane: plain revolute joints with parallel axes. Its joints
// keep it in the plane, whatever its masses.
bool Tree::in_a_plane(int place) const {
  const int count = static_cast<int>(tables_.order.size());
  for (int i = place; i < count; ++i) {
    const int b = tables_.order[at(i)];
    if (i > place && tables_.parent[at(b)] < 0) return true;
    const TreeTables::Class own = tables_.classes[at(b)];
    if (own.kind != Kind::revolute || own.variant != Variant::plain || !(own.parallel || i == place)) return false;
  }
  return true;
}

}  // namespace momentree
