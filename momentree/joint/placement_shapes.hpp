#pragma once
// The shape of a link's placement as a constant.
#include <type_traits>

#include <momentree/base/inline.hpp>
#include <momentree/joint/link_constants.hpp>

namespace momentree {

/// The terms that a shape has.
template <PlacementShape S>
struct PlacementTerms {
  static constexpr bool beta = S == PlacementShape::general;
  static constexpr bool any_offset = S == PlacementShape::general || S == PlacementShape::tilted;
  static constexpr bool right = S >= PlacementShape::right && S <= PlacementShape::right_meeting;
  static constexpr bool parallel = S >= PlacementShape::parallel;
  static constexpr bool a = S == PlacementShape::screw || S == PlacementShape::screw_a || S == PlacementShape::right ||
                            S == PlacementShape::right_a || parallel;
  static constexpr bool d = S == PlacementShape::screw || S == PlacementShape::screw_d || S == PlacementShape::right ||
                            S == PlacementShape::right_d || S == PlacementShape::parallel;
};

/// Calls f(std::integral_constant<PlacementShape, …>{}) for a shape known at run time.
template <class F>
MOMENTREE_INLINE void dispatch_shape(PlacementShape shape, F&& f) {
  switch (shape) {
#define MOMENTREE_SHAPE(name) \
  case PlacementShape::name: return f(std::integral_constant<PlacementShape, PlacementShape::name>{});
    MOMENTREE_SHAPE(general)
    MOMENTREE_SHAPE(tilted)
    MOMENTREE_SHAPE(screw)
    MOMENTREE_SHAPE(screw_a)
    MOMENTREE_SHAPE(screw_d)
    MOMENTREE_SHAPE(right)
    MOMENTREE_SHAPE(right_a)
    MOMENTREE_SHAPE(right_d)
    MOMENTREE_SHAPE(right_meeting)
    MOMENTREE_SHAPE(parallel)
    MOMENTREE_SHAPE(parallel_a)
#undef MOMENTREE_SHAPE
  }
  __builtin_unreachable();
}

}  // namespace momentree
