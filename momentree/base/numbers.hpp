#pragma once
// Numbers and vectors that users' code reads by index.
#include <cstddef>
#include <span>
#include <vector>

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

/// A std::vector whose [] stops the program where there is no such entry.
template <class T>
class CheckedVector : public std::vector<T> {
 public:
  using std::vector<T>::vector;
  T& operator[](std::size_t i) {
    MT_REQUIRE(i < this->size(), "an index below size()");
    return this->data()[i];
  }
  const T& operator[](std::size_t i) const {
    MT_REQUIRE(i < this->size(), "an index below size()");
    return this->data()[i];
  }
};

}  // namespace momentree
