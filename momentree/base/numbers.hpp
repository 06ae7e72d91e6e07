#pragma once
// Numbers and vectors that user code reads by index.
#include <cstddef>
#include <span>
#include <vector>

#include <momentree/base/check.hpp>

namespace momentree {

/// A view of numbers stored elsewhere: a std::span whose [] stops the program if the index is out of range.
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

/// A std::vector whose [] stops the program if the index is out of range.
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
