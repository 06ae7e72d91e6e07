#pragma once
// Identities for objects whose addresses are reused.
#include <cstdint>

namespace momentree::detail {

/// Never 0, and never the same twice in one process; safe to call from several threads. Nothing that is computed depends on its
/// value, only on whether two of them are equal.
std::uint64_t unique_number() noexcept;

/// The unique number of a value, which changes with the value: copies have the same one, and a moved-from object has another.
/// Of a default-constructed object it is 0.
class Version {
 public:
  Version() = default;
  Version(const Version&) = default;
  Version(Version&& other) noexcept : number_(other.number_) { other.renew(); }
  Version& operator=(const Version&) = default;
  Version& operator=(Version&& other) noexcept {
    number_ = other.number_;
    if (this != &other) other.renew();
    return *this;
  }
  ~Version() = default;
  std::uint64_t number() const { return number_; }
  void renew() noexcept { number_ = unique_number(); }

 private:
  std::uint64_t number_ = 0;
};

}  // namespace momentree::detail
