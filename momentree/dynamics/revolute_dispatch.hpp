#pragma once
// Which step inboard a pin takes: by the shape of its link, and by what there is to collect and where it goes.
#include <momentree/joint/revolute_steps.hpp>
#include <momentree/tree/tree.hpp>

namespace momentree {

/// Where a step inboard puts what the parent gets: nowhere, into what the next step goes on with, or elsewhere.
enum class Way : unsigned char { root, on, aside };
/// Calls f(shape, children, way), integral constants, for a step inboard of a body with that flow. A root crosses nothing
/// on the way in; last children, for whom the parent's x axis was not chosen, go aside.
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
    if ((flags & (node::leaf | node::branching)) == 0)  // most of them
      dispatch_link<Rotor>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, one, on); });
    else if ((flags & node::leaf) != 0)
      dispatch_link<Rotor>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, none, on); });
    else if constexpr (Rotor)
      dispatch_link<Rotor>(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, several, on); });
    else
      dispatch_main_shape(shape, [&](auto s) MOMENTREE_INLINE_LAMBDA { f(s, several, on); });
  } else if ((flags & node::root) == 0) {
    // Records of late steps are slid as the way out by the link's own shape has it.
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
