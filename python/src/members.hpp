#pragma once
// The members of a described type (base/describe.hpp) as attributes.
#include <string_view>
#include <utility>

#include <momentree/base/describe.hpp>

#include "binding.hpp"

namespace momentree::python {

/// Copies the member with that key.
template <class Member>
struct MemberFinder {
  std::string_view wanted;
  Member found{};
  void operator()(const char* key, const auto& member, const Field&) {
    if constexpr (Like<std::decay_t<decltype(member)>, Member>)
      if (key == wanted) found = member;
  }
};

/// Adds read-only attributes. `get` gives the value of the described type T for an object of the class.
template <class T, class Object, class Get>
void add_members(nb::class_<Object>& type, Get get) {
  const auto add = [&]<class Member>(const char* key, const Member&, const Field& field) {
    const std::string unit = unit_of(field.dimension);
    const std::string about =
        field.about + (unit.empty() ? "" : " (" + unit + ")") + (field.unbounded ? "; infinite: never." : ".");
    type.def_prop_ro(
        key,
        [get, key](const Object& object) {
          const T value = get(object);
          MemberFinder<Member> finder{key};
          describe(finder, value);
          return finder.found;
        },
        about.c_str());
  };
  const T any{};
  describe(add, any);
}

}  // namespace momentree::python
