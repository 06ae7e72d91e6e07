#pragma once
// Force elements that act between joints of the tree with one DoF each, such as springs that couple two joints. A kind is one
// file in elements/: a described type (base/describe.hpp) with a function
//
//   void efforts(std::span<const double> q, std::span<const double> v, std::span<double> efforts) const noexcept;
//
// of the coordinates (rad, m) and velocities of its joints, in the order in which describe() lists them, that sets the efforts on
// them (N m, N). A kind with a table of its own in scenarios has a member `static constexpr ElementInfo info`.
#include <concepts>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <momentree/model/all_elements.hpp>
#include <momentree/model/element_list.hpp>

namespace momentree {

class Model;

#define MT_ELEMENT(name, Type) , elements::Type
/// An element between joints of a model. It acts as long as all its joints are those of the model: not broken, freed or changed.
/// Its energy counts as work.
using JointElement = std::variant<std::monostate MOMENTREE_ELEMENTS(MT_ELEMENT)>;
#undef MT_ELEMENT

/// Calls f with the element as the kind that it is.
template <class F>
void with_kind(const JointElement& element, F&& f) {
  std::visit(
      [&f](const auto& kind) {
        if constexpr (!std::same_as<std::decay_t<decltype(kind)>, std::monostate>) f(kind);
      },
      element);
}

/// True for a kind with a table of its own in scenarios.
template <class Kind>
inline constexpr bool has_table = requires {
  Kind::info;
};

/// Its joints, in the order of their efforts.
std::vector<JointId> joints_of(const JointElement& element);

/// The same element between other joints: `now` gives the joint that takes the place of one.
JointElement with_joints(JointElement element, const std::function<JointId(JointId)>& now);

/// The faults of an element of a model. `field`: the scenario key at fault.
struct ElementProblem {
  std::string field, what, hint;
};
std::vector<ElementProblem> check_element(const JointElement& element, const Model& model);

}  // namespace momentree
