#pragma once
// A span that is read by index in users' code.
#include <cstddef>
#include <span>

#include <momentree/base/check.hpp>

namespace momentree {

/// Numbers that stand somewhere else: a std::span whose [] stops the program where there is no such number.
class Numbers : public std::span<const double> {
 public:
  using std::span<const double>::span;
  Numbers(std::span<const double> all) : std::span<const double>(all) {}  // NOLINT(google-explicit-constructor)
  const double& operator[](std::size_t i) const {
    MT_REQUIRE(i < size(), "an index below size()");
    return data()[i];
  }
  const double& front() const { return (*this)[0]; }
  const double& back() const { return (*this)[size() - 1]; }
};

}  // namespace momentree
