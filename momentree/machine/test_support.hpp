#pragma once
// What tests of machine code compare with.
#include <array>
#include <cmath>
#include <cstring>

#include <momentree/machine/evaluate.hpp>

namespace momentree::machine {

/// A number of each of N worlds.
template <class S, int N>
struct Worlds {
  std::array<S, static_cast<std::size_t>(N)> x{};
  Worlds() = default;
  explicit Worlds(double all) { x.fill(static_cast<S>(all)); }
  template <class F>
  static Worlds each(F&& f) {
    Worlds r;
    for (std::size_t i = 0; i < r.x.size(); ++i) r.x[i] = f(i);
    return r;
  }
  friend Worlds operator+(const Worlds& a, const Worlds& b) {
    return each([&](auto i) { return a.x[i] + b.x[i]; });
  }
  friend Worlds operator-(const Worlds& a, const Worlds& b) {
    return each([&](auto i) { return a.x[i] - b.x[i]; });
  }
  friend Worlds operator*(const Worlds& a, const Worlds& b) {
    return each([&](auto i) { return a.x[i] * b.x[i]; });
  }
  friend Worlds operator/(const Worlds& a, const Worlds& b) {
    return each([&](auto i) { return a.x[i] / b.x[i]; });
  }
  friend Worlds operator-(const Worlds& a) {
    return each([&](auto i) { return -a.x[i]; });
  }
  /// The same bits, or no numbers.
  friend bool operator==(const Worlds& a, const Worlds& b) {
    for (std::size_t i = 0; i < a.x.size(); ++i)
      if (std::memcmp(&a.x[i], &b.x[i], sizeof(S)) != 0 && !(std::isnan(a.x[i]) && std::isnan(b.x[i]))) return false;
    return true;
  }
  friend Worlds maximum(const Worlds& a, const Worlds& b) {
    return each([&](auto i) { return a.x[i] > b.x[i] ? a.x[i] : b.x[i]; });
  }
  friend Worlds fused(const Worlds& a, const Worlds& b, const Worlds& c) {
    return each([&](auto i) { return std::fma(a.x[i], b.x[i], c.x[i]); });
  }
};

}  // namespace momentree::machine
