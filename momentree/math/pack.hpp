#pragma once
// A scalar with several lanes: the kernels run on it as on double, for as many worlds at once. Every operation does the same in
// every lane and never branches on values, so a lane does not depend on its neighbours.
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include <momentree/base/inline.hpp>
#include <momentree/math/isa.hpp>
#include <momentree/math/sincos.hpp>

namespace momentree {

/// N lanes of S, double or float. Constants of the model are double; a pack of floats rounds them and computes in float.
template <class S, int N, Isa I = Isa::baseline>
class Pack {
  static_assert(std::is_same_v<S, double> || std::is_same_v<S, float>);

 public:
  using Scalar = S;
  using Bits = std::conditional_t<std::is_same_v<S, double>, std::int64_t, std::int32_t>;
  using Vector [[gnu::vector_size(sizeof(S) * N)]] = S;
  using Mask [[gnu::vector_size(sizeof(S) * N)]] = Bits;
  static constexpr int lanes = N;

  Pack() = default;
  MOMENTREE_INLINE explicit Pack(double all) : v_(Vector{} + static_cast<S>(all)) {}
  MOMENTREE_INLINE explicit Pack(Vector lanes_) : v_(lanes_) {}
  MOMENTREE_INLINE const Vector& vector() const { return v_; }
  MOMENTREE_INLINE S operator[](int lane) const { return v_[lane]; }
  MOMENTREE_INLINE void set(int lane, double value) { v_[lane] = static_cast<S>(value); }
  /// N consecutive numbers, rounded to S.
  MOMENTREE_INLINE static Pack load(const double* from) {
    Pack a;
    if constexpr (std::is_same_v<S, double>)
      std::memcpy(&a.v_, from, sizeof a.v_);
    else
      for (int i = 0; i < N; ++i) a.v_[i] = static_cast<S>(from[i]);
    return a;
  }
  MOMENTREE_INLINE void store(double* to) const {
    if constexpr (std::is_same_v<S, double>)
      std::memcpy(to, &v_, sizeof v_);
    else
      for (int i = 0; i < N; ++i) to[i] = v_[i];
  }

  MOMENTREE_INLINE friend Pack operator+(const Pack& a, const Pack& b) { return Pack(a.v_ + b.v_); }
  MOMENTREE_INLINE friend Pack operator-(const Pack& a, const Pack& b) { return Pack(a.v_ - b.v_); }
  MOMENTREE_INLINE friend Pack operator*(const Pack& a, const Pack& b) { return Pack(a.v_ * b.v_); }
  MOMENTREE_INLINE friend Pack operator/(const Pack& a, const Pack& b) { return Pack(a.v_ / b.v_); }
  MOMENTREE_INLINE friend Pack operator+(const Pack& a, double b) { return Pack(a.v_ + static_cast<S>(b)); }
  MOMENTREE_INLINE friend Pack operator-(const Pack& a, double b) { return Pack(a.v_ - static_cast<S>(b)); }
  MOMENTREE_INLINE friend Pack operator*(const Pack& a, double b) { return Pack(a.v_ * static_cast<S>(b)); }
  MOMENTREE_INLINE friend Pack operator/(const Pack& a, double b) { return Pack(a.v_ / static_cast<S>(b)); }
  MOMENTREE_INLINE friend Pack operator+(double a, const Pack& b) { return Pack(static_cast<S>(a) + b.v_); }
  MOMENTREE_INLINE friend Pack operator-(double a, const Pack& b) { return Pack(static_cast<S>(a) - b.v_); }
  MOMENTREE_INLINE friend Pack operator*(double a, const Pack& b) { return Pack(static_cast<S>(a) * b.v_); }
  MOMENTREE_INLINE friend Pack operator/(double a, const Pack& b) { return Pack(static_cast<S>(a) / b.v_); }
  MOMENTREE_INLINE friend Pack operator-(const Pack& a) { return Pack(-a.v_); }
  template <class B>
  MOMENTREE_INLINE friend Pack& operator+=(Pack& a, const B& b) {
    return a = a + b;
  }
  template <class B>
  MOMENTREE_INLINE friend Pack& operator-=(Pack& a, const B& b) {
    return a = a - b;
  }
  template <class B>
  MOMENTREE_INLINE friend Pack& operator*=(Pack& a, const B& b) {
    return a = a * b;
  }

  /// a in the lanes in which the mask is set (all bits), b in the others.
  MOMENTREE_INLINE friend Pack select(const Mask& mask, const Pack& a, const Pack& b) {
    return Pack((Vector)((mask & (Mask)a.v_) | (~mask & (Mask)b.v_)));
  }
  /// |a| ≤ limit in each lane; false for NaN.
  MOMENTREE_INLINE friend Mask within(const Pack& a, double limit) {
    const Vector size = (Vector)((Mask)a.v_ & (Mask{} + static_cast<Bits>(static_cast<std::make_unsigned_t<Bits>>(-1) >> 1)));
    return (Mask)(size <= Vector{} + static_cast<S>(limit));
  }

 private:
  Vector v_;
};

/// Largest |x| (rad) for which the polynomials of a pack are accurate.
template <class S>
inline constexpr double pack_sincos_range = std::is_same_v<S, double> ? sincos_range : 8192;

/// The polynomials of sincos(double), in every lane.
template <int N, Isa I>
MOMENTREE_INLINE void sincos(const Pack<double, N, I>& angle, Pack<double, N, I>& s, Pack<double, N, I>& c) {
  using P = Pack<double, N, I>;
  using V = typename P::Vector;
  using M = typename P::Mask;
  constexpr double magic = 6755399441055744.0;
  const V x = angle.vector();
  const V t = x * 0.63661977236758134308 + magic;
  const M n = (M)t;
  const V k = t - magic;
  const V a = x - k * 1.57079632673412561417e+00;
  const V b = k * 6.07710050630396597660e-11;
  const V r1 = a - b;
  const V low = (a - r1) - b - k * 2.02226624879595063154e-21;
  const V r = r1 + low;
  const V e = (r1 - r) + low;
  const V z = r * r, z2 = z * z;
  const V ps = (-1.66666666666666324348e-01 + z * 8.33333333332248946124e-03) +
               z2 * ((-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06) +
                     z2 * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10));
  const V pc = (4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) +
               z2 * ((2.48015872894767294178e-05 + z * -2.75573143513906633035e-07) +
                     z2 * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11));
  const V h = 0.5 * z, u = 1.0 - h;
  const V sine = r + (r * z * ps + e * u);
  const V cosine = u + (z2 * pc + (((1.0 - u) - h) - r * e));
  const M odd = -(n & 1);
  const M change = odd & ((M)sine ^ (M)cosine);  // where sine and cosine are exchanged
  s = P((V)((M)sine ^ change ^ ((n & 2) << 62)));
  c = P((V)((M)cosine ^ change ^ (((n + 1) & 2) << 62)));
}

/// The same in float: reduction in three parts (8 + 11 + 24 bits), polynomials of degree 7 and 8. Error below 1e-7 within
/// pack_sincos_range.
template <int N, Isa I>
MOMENTREE_INLINE void sincos(const Pack<float, N, I>& angle, Pack<float, N, I>& s, Pack<float, N, I>& c) {
  using P = Pack<float, N, I>;
  using V = typename P::Vector;
  using M = typename P::Mask;
  constexpr float magic = 12582912.0F;  // 1.5·2^23
  const V x = angle.vector();
  const V t = x * 0.636619772367581343F + magic;
  const M n = (M)t;
  const V k = t - magic;
  const V r = ((x - k * 1.5703125F) - k * 4.837512969970703125e-4F) - k * 7.54978995489188216e-8F;
  const V z = r * r;
  const V ps = -1.6666654611e-1F + z * (8.3321608736e-3F + z * -1.9515295891e-4F);
  const V pc = 4.166664568298827e-2F + z * (-1.388731625493765e-3F + z * 2.443315711809948e-5F);
  const V sine = r + r * z * ps;
  const V cosine = (1.0F - 0.5F * z) + z * z * pc;
  const M odd = -(n & 1);
  const M change = odd & ((M)sine ^ (M)cosine);  // where sine and cosine are exchanged
  s = P((V)((M)sine ^ change ^ ((n & 2) << 30)));
  c = P((V)((M)cosine ^ change ^ (((n + 1) & 2) << 30)));
}

/// n angles in every lane. Lanes with an angle beyond the range, and only these, use libm: a lane does not depend on its
/// neighbours.
template <class S, int N, Isa I>
void sincos(int n, const Pack<S, N, I>* x, Pack<S, N, I>* s, Pack<S, N, I>* c) {
  using P = Pack<S, N, I>;
  typename P::Mask near = ~typename P::Mask{};
  for (int i = 0; i < n; ++i) {
    near &= within(x[i], pack_sincos_range<S>);
    sincos(x[i], s[i], c[i]);
  }
  bool all = true;
  for (int lane = 0; lane < N; ++lane) all = all && near[lane] != 0;
  if (all) return;
  for (int i = 0; i < n; ++i)
    for (int lane = 0; lane < N; ++lane)
      if (!(std::fabs(x[i][lane]) <= static_cast<S>(pack_sincos_range<S>)))
        s[i].set(lane, std::sin(static_cast<double>(x[i][lane]))), c[i].set(lane, std::cos(static_cast<double>(x[i][lane])));
}

/// angle(0), angle(1) … (n of them) of one world, four at a time. They are combined in registers, because loading numbers that
/// were just written stalls. `s` and `c` must have room for n + 3 numbers. Angles beyond the range use libm.
template <class Angle>
MOMENTREE_INLINE void sincos_by_fours(int n, const Angle& angle, double* s, double* c) {
  using Four = Pack<double, 4>;
  constexpr int block = 16;
  Four some[block];
  for (int first = 0; first < n; first += 4 * block) {
    const int count = n - first < 4 * block ? n - first : 4 * block, fours = (count + 3) / 4;
    typename Four::Mask near = ~typename Four::Mask{};
    for (int k = 0; k < fours; ++k) {
      const int i = first + 4 * k;
      const auto there = [&](int lane) MOMENTREE_INLINE_LAMBDA { return angle(i + lane < n ? i + lane : i); };
      some[k] = Four(Four::Vector{angle(i), there(1), there(2), there(3)});
      near &= within(some[k], sincos_range);
    }
    for (int k = 0; k < fours; ++k) {
      Four sine, cosine;
      sincos(some[k], sine, cosine);
      sine.store(s + first + 4 * k), cosine.store(c + first + 4 * k);
    }
    if ((near[0] & near[1] & near[2] & near[3]) != 0) continue;
    for (int i = 0; i < count; ++i)
      if (const double x = some[i / 4][i % 4]; !(std::fabs(x) <= sincos_range))
        s[first + i] = std::sin(x), c[first + i] = std::cos(x);
  }
}

}  // namespace momentree
