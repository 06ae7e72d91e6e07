#pragma once
// Selects the inward step of a revolute body: by the shape of its link, its children and the destination of its output.
#include <momentree/joint/revolute_steps.hpp>
#include <momentree/tree/kernel_run.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Destination of an inward step's output: none, the accumulator with which the next step continues, or elsewhere in memory.
enum class Way : unsigned char { root, on, aside };
/// Calls f(shape, children, way), integral constants, for the inward step of a body with these node flags. A root has nothing to
/// transform; last children, for which the parent's x axis was not chosen, write elsewhere.
template <bool Rotor, class F>
MOMENTREE_INLINE void dispatch_inboard(PlacementShape shape, unsigned flags, F&& f) {
  constexpr std::integral_constant<Children, Children::none> none{};
  constexpr std::integral_constant<Children, Children::one> one{};
  constexpr std::integral_constant<Children, Children::several> several{};
  constexpr std::integral_constant<Way, Way::on> on{};
  const auto by_children = [&](auto way, auto s) MOMENTREE_INLINE_LAMBDA {
    if ((flags & node::leaf) != 0)
      f(s, none, way);
    else if ((flags & node::branching) != 0)
      f(s, several, way);
    else
      f(s, one, way);
  };
  if ((flags & (node::root | node::last_child)) == 0) {
    if ((flags & (node::leaf | node::branching)) == 0)  // most bodies
      dispatch_link<Rotor>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, one, on); });
    else if ((flags & node::leaf) != 0)
      dispatch_link<Rotor>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, none, on); });
    else if constexpr (Rotor)
      dispatch_link<Rotor>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, several, on); });
    else
      dispatch_main_shape(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, several, on); });
  } else if ((flags & node::root) == 0) {
    // With rotate_then_reduce a record refers to the frame before the shift along z: the shape used here must split off that
    // shift as the link's own does, by which the outward step goes.
    constexpr std::integral_constant<Way, Way::aside> aside{};
    if (shape == PlacementShape::general || shape == PlacementShape::tilted)
      by_children(aside, std::integral_constant<PlacementShape, PlacementShape::general>{});
    else
      by_children(aside, std::integral_constant<PlacementShape, PlacementShape::screw>{});
  } else {
    constexpr std::integral_constant<Way, Way::root> root{};
    by_children(root, std::integral_constant<PlacementShape, PlacementShape::parallel>{});
  }
}

}  // namespace momentree
