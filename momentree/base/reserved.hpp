#pragma once
// Lists whose storage is reserved for every later topology: no change allocates, and unused memory is never touched.
#include <algorithm>
#include <cstddef>
#include <vector>

namespace momentree::detail {

/// A vector whose copies keep its capacity, so that a copied tree also changes without allocating.
template <class T>
struct Reserved : std::vector<T> {
  Reserved() = default;
  Reserved(const Reserved& other) : std::vector<T>() { *this = other; }
  Reserved(Reserved&&) noexcept = default;
  Reserved& operator=(const Reserved& other) {
    this->reserve(other.capacity());
    this->assign(other.begin(), other.end());
    return *this;
  }
  Reserved& operator=(Reserved&&) noexcept = default;
  ~Reserved() = default;
};

/// Reserves space for `count`; grows by at least half, so that repeated additions are cheap.
template <class T>
void reserve(std::vector<T>& list, std::size_t count) {
  if (list.capacity() < count) list.reserve(std::max(count, list.capacity() + list.capacity() / 2));
}

}  // namespace momentree::detail
