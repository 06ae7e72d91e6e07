#pragma once
// What a thing consists of, said once. A described type has a function
//
//   template <class Visitor, Like<Spring> S>
//   void describe(Visitor& visit, S& spring) {
//     visit("stiffness", spring.stiffness, Field{"Stiffness", force / length, Range::not_negative});
//
// that calls the visitor with each member, in the order of documents. Readers, writers, archives, hashes, the schema and the
// bindings are visitors. Defaults are the values of a new object.
#include <concepts>
#include <limits>
#include <type_traits>

#include <momentree/base/units.hpp>

namespace momentree {

/// T, or const T.
template <class S, class T>
concept Like = std::same_as<std::remove_const_t<S>, T>;

/// The range of a number.
enum class Range { any, not_negative, positive, fraction };  ///< fraction: from 0 to 1

/// The meaning of a member.
struct Field {
  const char* about;  ///< in one line, for editors and docstrings; they add the unit
  Dimension dimension{};
  Range range = Range::any;
  const char* required = nullptr;  ///< for a member that must be given: the hint if it is missing, which may be empty
  bool unbounded = false;          ///< a number that may be infinite: null in JSON
  const char* absent = nullptr;    ///< what an absent member means, if that is not the value of a new object
  Dimension along{};               ///< its dimension if the first joint of the element is along its axis, not about it
  bool of_joint = false;           ///< it has that other dimension
  double left_out = std::numeric_limits<double>::quiet_NaN();  ///< the value with which it is not in JSON; NaN: none

  constexpr Field needed(const char* hint) const {
    Field field = *this;
    field.required = hint;
    return field;
  }
  constexpr Field by_default(const char* value) const {
    Field field = *this;
    field.absent = value;
    return field;
  }
  constexpr Field or_along(const Dimension& other) const {
    Field field = *this;
    field.along = other, field.of_joint = true;
    return field;
  }
  constexpr Field left_out_at(double value) const {
    Field field = *this;
    field.left_out = value;
    return field;
  }
  constexpr Field or_infinite() const {
    Field field = *this;
    field.unbounded = true;
    return field;
  }
};

/// The table of an element between joints in scenarios.
struct ElementInfo {
  const char* table;         ///< "[[gear]]"
  const char* key;           ///< "gear"
  const char* about;         ///< in one line
  const char* details = "";  ///< more about it, for docstrings
};

}  // namespace momentree
