#pragma once
// Lists whose storage is reserved for every later topology: no change allocates, and what is not used is never touched.
#include <algorithm>
#include <cstddef>
#include <vector>

namespace momentree {

/// A vector whose copies keep its capacity: a copied tree changes without allocating, too.
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

/// Room for `count`; grows by halves, so that additions are cheap.
template <class T>
void reserve(std::vector<T>& list, std::size_t count) {
  if (list.capacity() < count) list.reserve(std::max(count, list.capacity() + list.capacity() / 2));
}

}  // namespace momentree
