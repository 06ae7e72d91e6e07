#pragma once
// Joint-space mass (24), at most 6 x 6, symmetric positive definite: LDLᵀ in place, without pivoting or branches. Unrolled,
// because the overhead of such short loops exceeds their work.
#include <array>

#include <momentree/base/inline.hpp>

namespace momentree {

/// Symmetric N x N matrix, row-major; after `factorise` its factors: the strict lower triangle holds L, `inverse` holds 1/D.
template <class T, int N>
struct JointMass {
  std::array<T, N * N> m{};
  std::array<T, N> inverse{};

  constexpr T& operator()(int i, int j) { return m[static_cast<std::size_t>(i * N + j)]; }
  constexpr const T& operator()(int i, int j) const { return m[static_cast<std::size_t>(i * N + j)]; }

  /// Factorises in place; reads the lower triangle. A pivot that is not positive gives an entry of `inverse` that is not positive
  /// or not finite.
  MOMENTREE_INLINE constexpr void factorise() {
#pragma GCC unroll 6
    for (int j = 0; j < N; ++j) {
      T d = (*this)(j, j);
      std::array<T, N> w{};
#pragma GCC unroll 6
      for (int k = 0; k < j; ++k) {
        w[static_cast<std::size_t>(k)] = (*this)(j, k) * (*this)(k, k);  // L D
        d = d - (*this)(j, k) * w[static_cast<std::size_t>(k)];
      }
      (*this)(j, j) = d;
      const T inv = T(1) / d;
      inverse[static_cast<std::size_t>(j)] = inv;
#pragma GCC unroll 6
      for (int i = j + 1; i < N; ++i) {
        T a = (*this)(i, j);
#pragma GCC unroll 6
        for (int k = 0; k < j; ++k) a = a - (*this)(i, k) * w[static_cast<std::size_t>(k)];
        (*this)(i, j) = a * inv;
      }
    }
  }
  /// x ← M⁻¹ x, with the factors
  template <class Vector>
  MOMENTREE_INLINE constexpr void solve(Vector& x) const {
#pragma GCC unroll 6
    for (int i = 0; i < N; ++i)
#pragma GCC unroll 6
      for (int k = 0; k < i; ++k) x[i] = x[i] - (*this)(i, k) * x[k];
#pragma GCC unroll 6
    for (int i = N - 1; i >= 0; --i) {
      x[i] = x[i] * inverse[static_cast<std::size_t>(i)];
#pragma GCC unroll 6
      for (int k = i + 1; k < N; ++k) x[i] = x[i] - (*this)(k, i) * x[k];
    }
  }
};

}  // namespace momentree
