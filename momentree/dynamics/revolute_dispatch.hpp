#pragma once
// Selects the inward step of a revolute body: by the shape of its link, its children and the destination of its output.
#include <momentree/joint/revolute_steps.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Destination of the output of an inward step: none (a root), the accumulator with which the next step continues, or the sum of
/// the parent in memory.
enum class Destination : unsigned char { none, accumulator, parent_sum };
/// Calls f(shape, children, destination), integral constants, for the inward step of a body with these node flags, of which
/// `Roots` marks the roots. A root has nothing to transform; last children, for which the parent's x axis was not chosen, write
/// elsewhere.
template <bool Armature, unsigned Roots = node::root, class F>
MOMENTREE_INLINE void dispatch_inboard(PlacementShape shape, unsigned flags, F&& f) {
  constexpr std::integral_constant<Children, Children::none> none{};
  constexpr std::integral_constant<Children, Children::one> one{};
  constexpr std::integral_constant<Children, Children::several> several{};
  constexpr std::integral_constant<Destination, Destination::accumulator> accumulator{};
  const auto by_children = [&](auto destination, auto s) MOMENTREE_INLINE_LAMBDA {
    if ((flags & node::leaf) != 0)
      f(s, none, destination);
    else if ((flags & node::branching) != 0)
      f(s, several, destination);
    else
      f(s, one, destination);
  };
  if ((flags & (Roots | node::last_child)) == 0) {
    if ((flags & (node::leaf | node::branching)) == 0)  // most bodies
      dispatch_link<Armature>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, one, accumulator); });
    else if ((flags & node::leaf) != 0)
      dispatch_link<Armature>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, none, accumulator); });
    else if constexpr (Armature)
      dispatch_link<Armature>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, several, accumulator); });
    else
      dispatch_main_shape(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, several, accumulator); });
  } else if ((flags & Roots) == 0) {
    constexpr std::integral_constant<Destination, Destination::parent_sum> parent_sum{};
    by_children(parent_sum, std::integral_constant<PlacementShape, PlacementShape::general>{});
  } else {
    constexpr std::integral_constant<Destination, Destination::none> no_output{};
    by_children(no_output, std::integral_constant<PlacementShape, PlacementShape::parallel>{});
  }
}

}  // namespace momentree
