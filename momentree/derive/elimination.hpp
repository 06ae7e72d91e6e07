#pragma once
// Reduction by elimination: the columns of E one after the other, as if each were a joint with one DoF. The reduced mass then
// fulfils M̂ E = 0 and the remainder Eᵀ D̂ = p (without armature); the entries that follow from this are not computed but set, so
// that they are zeros for all later steps. A generic subtraction would leave round-off there, and the operations with it.
#include <algorithm>
#include <array>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include <momentree/derive/recorder.hpp>

namespace momentree::derive {

using Six = std::array<T, 6>;

/// Element (i, j) of a spatial mass; i <= j by symmetry.
inline T& element(SpatialMass<T>& M, std::size_t i, std::size_t j) {
  if (i > j) std::swap(i, j);
  T* const A[3][3] = {{&M.A.xx, &M.A.xy, &M.A.xz}, {&M.A.xy, &M.A.yy, &M.A.yz}, {&M.A.xz, &M.A.yz, &M.A.zz}};
  T* const B[3][3] = {{&M.B.xx, &M.B.xy, &M.B.xz}, {&M.B.yx, &M.B.yy, &M.B.yz}, {&M.B.zx, &M.B.zy, &M.B.zz}};
  T* const J[3][3] = {{&M.J.xx, &M.J.xy, &M.J.xz}, {&M.J.xy, &M.J.yy, &M.J.yz}, {&M.J.xz, &M.J.yz, &M.J.zz}};
  return j < 3 ? *A[i][j] : i < 3 ? *B[i][j - 3] : *J[i - 3][j - 3];
}
inline Six six(const Force<T>& f) { return {f.l.x, f.l.y, f.l.z, f.h.x, f.h.y, f.h.z}; }
inline Six six(const Motion<T>& m) { return {m.v.x, m.v.y, m.v.z, m.w.x, m.w.y, m.w.z}; }
inline Force<T> force(const Six& f) { return {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}}; }
inline Motion<T> motion(const Six& m) { return {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}}; }

inline bool is_zero(const T& x) { return x.node() == Expressions::zero; }
inline bool is_one(const T& x) { return x.node() == T::graph()->constant(1); }

/// E' = E Q, whose columns have a one in the row of their own pivot and zeros in those of the others: u = Q u', p' = Qᵀ p.
struct Basis {
  std::vector<Six> columns;
  std::vector<std::size_t> pivots;
  std::vector<std::vector<T>> Q;  ///< by column
  std::optional<T> armature{};    ///< of a single DoF
};

inline Basis unit_basis(std::vector<Six> E) {
  const std::size_t n = E.size();
  Basis basis{E, std::vector<std::size_t>(n, 6), {}, {}};
  for (std::size_t i = 0; i < n; ++i) {
    basis.Q.emplace_back(n, T(0));
    basis.Q[i][i] = T(1);
  }
  auto& C = basis.columns;
  const auto eliminate = [&](std::size_t i, std::size_t row) {
    basis.pivots[i] = row;
    const T by = C[i][row];
    for (T& x : C[i]) x = is_zero(x) ? x : x / by;
    C[i][row] = T(1);
    for (T& x : basis.Q[i]) x = is_zero(x) ? x : x / by;
    for (std::size_t j = 0; j < n; ++j) {
      if (j == i) continue;
      const T f = C[j][row];
      for (std::size_t k = 0; k < 6; ++k) C[j][k] = C[j][k] - f * C[i][k];
      for (std::size_t k = 0; k < n; ++k) basis.Q[j][k] = basis.Q[j][k] - f * basis.Q[i][k];
    }
  };
  for (const bool ones : {true, false})  // the pivots that cost no division come first
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t row = 6; row-- > 0 && basis.pivots[i] == 6;)
        if (ones ? is_one(C[i][row]) : !is_zero(C[i][row])) eliminate(i, row);
  if (std::ranges::count(basis.pivots, std::size_t{6}) > 0) throw std::bad_alloc();  // all nodes are zero once memory ran out
  return basis;
}

/// What the outward step needs of one eliminated column.
struct Eliminated {
  Six g;  ///< Mb E' / Mj; not defined in the row of the pivot
  T u0;   ///< (p' − E'ᵀ D) / Mj
};

/// The entries in the row of the pivot that follow from M E' = 0.
inline void impose(SpatialMass<T>& M, const Six& E, std::size_t pivot) {
  for (std::size_t row = 0; row < 7; ++row) {  // the pivot's own last: it needs the others
    const std::size_t j = row == 6 ? pivot : row;
    if (row == pivot) continue;
    T x(0);
    for (std::size_t l = 0; l < 6; ++l)
      if (l != pivot) x = x - E[l] * element(M, l, j);
    element(M, pivot, j) = x;
  }
}

// The equations of kernels.hpp for one column E' and the articulated mass in which those before it are reduced; e = Mb E'.

/// (24): Mj = E'ᵀ Mb E'.
inline T joint_space_mass(const Six& E, const Six& e) {
  T Mj(0);
  for (std::size_t j = 0; j < 6; ++j) Mj = Mj + E[j] * e[j];
  return Mj;
}
/// (25): M̂ = Mb − g eᵀ, with M̂ E' = 0.
inline void reduced_mass(const Six& E, std::size_t pivot, const Six& g, const Six& e, SpatialMass<T>& M) {
  for (std::size_t j = 0; j < 6; ++j)
    for (std::size_t l = j; l < 6; ++l)
      if (j != pivot && l != pivot) element(M, j, l) = element(M, j, l) - g[j] * e[l];
  impose(M, E, pivot);
}
/// (26): D̂ = Db + g r, with E'ᵀ D̂ = p'.
inline void reduced_remainder(const Six& E, std::size_t pivot, const Six& g, const T& r, const T& p, Six& D) {
  T last = p;
  for (std::size_t j = 0; j < 6; ++j)
    if (j != pivot) D[j] = D[j] + g[j] * r, last = last - E[j] * D[j];
  D[pivot] = last;
}

/// (24)–(26) with armature I, which leaves M̂ E = I G. E is a unit vector. The armature may be arbitrarily large, so that Eᵀ D̂
/// is not computed as p − I u0.
inline Eliminated reduce_with_armature(std::size_t pivot, const T& I, const Six& e, const T& p, SpatialMass<T>& M, Six& D,
                                       std::vector<int>& first) {
  const T inverse = T(1) / (e[pivot] + I), r = p - D[pivot];
  Eliminated one{{}, inverse * r};
  for (std::size_t j = 0; j < 6; ++j) one.g[j] = inverse * e[j];
  first.push_back(inverse.node());
  for (const T& x : one.g) first.push_back(x.node());
  for (std::size_t j = 0; j < 6; ++j) {
    for (std::size_t l = j; l < 6; ++l)
      if (j != pivot && l != pivot) element(M, j, l) = element(M, j, l) - one.g[j] * e[l];
    D[j] = D[j] + one.g[j] * r;
  }
  for (std::size_t j = 0; j < 6; ++j) element(M, pivot, j) = I * one.g[j];
  return one;
}

/// (24)–(26) for one column after the other; `p` are the momenta p' of the columns. The divisions, which take longest, and the
/// columns of G come `first`.
inline std::vector<Eliminated> reduce(const Basis& basis, const std::vector<T>& p, SpatialMass<T>& M, Force<T>& remainder,
                                      std::vector<int>& first) {
  std::vector<Eliminated> all;
  Six D = six(remainder);
  for (std::size_t i = 0; i < basis.columns.size(); ++i) {
    const Six& E = basis.columns[i];
    const std::size_t pivot = basis.pivots[i];
    Six e;
    T known(0);
    for (std::size_t j = 0; j < 6; ++j) {
      e[j] = T(0);
      for (std::size_t l = 0; l < 6; ++l) e[j] = e[j] + E[l] * element(M, j, l);
    }
    if (basis.armature) {
      all.push_back(reduce_with_armature(pivot, *basis.armature, e, p[i], M, D, first));
      break;
    }
    const T Mj = joint_space_mass(E, e);
    for (std::size_t j = 0; j < 6; ++j) known = known + E[j] * D[j];
    const T inverse = T(1) / Mj, r = p[i] - known;
    Eliminated one{{}, inverse * r};
    for (std::size_t j = 0; j < 6; ++j) one.g[j] = j == pivot ? T(0) : inverse * e[j];
    first.push_back(inverse.node());
    for (const T& x : one.g) first.push_back(x.node());
    reduced_mass(E, pivot, one.g, e, M);
    reduced_remainder(E, pivot, one.g, r, p[i], D);
    all.push_back(one);
  }
  remainder = force(D);
  return all;
}

}  // namespace momentree::derive
