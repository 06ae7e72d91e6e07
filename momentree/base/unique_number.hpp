#pragma once
// Identities of objects whose addresses may be reused.
#include <cstdint>

namespace momentree::detail {

/// Never 0, and never the same number twice in one process; thread-safe. No result depends on the numbers themselves, only on
/// whether two of them are equal.
std::uint64_t unique_number() noexcept;

/// A unique number that is renewed when a value changes: copies share it, and a moved-from object gets another. A
/// default-constructed object has 0.
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
