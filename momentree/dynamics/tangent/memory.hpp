#pragma once
// Memory and passes of AccelerationTangent.
#include <algorithm>
#include <array>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <momentree/dynamics/evaluate.hpp>
#include <momentree/dynamics/tangent/acceleration_tangent.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/math/dense.hpp>
#include <momentree/math/dual.hpp>
#include <momentree/math/pack.hpp>

namespace momentree {

namespace detail::tangents {

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

using Lanes = Pack<double, 8>;  // directions at once
using Number = Dual<Lanes>;     // a value with its derivatives along them

inline Vector3<Lanes> spread(const Vec3& a) { return {Lanes(a.x), Lanes(a.y), Lanes(a.z)}; }
inline Motion<Lanes> spread(const Motion<double>& a) { return {spread(a.v), spread(a.w)}; }
inline Force<Lanes> spread(const Force<double>& a) { return {spread(a.l), spread(a.h)}; }
inline Vector3<Lanes> rate_of(const Vector3<Number>& a) { return {a.x.e, a.y.e, a.z.e}; }
inline Motion<Lanes> rate_of(const Motion<Number>& a) { return {rate_of(a.v), rate_of(a.w)}; }
inline Force<Lanes> rate_of(const Force<Number>& a) { return {rate_of(a.l), rate_of(a.h)}; }
inline Vec3 value_of(const Vector3<Number>& a) { return {a.x.r, a.y.r, a.z.r}; }
inline Motion<double> value_of(const Motion<Number>& a) { return {value_of(a.v), value_of(a.w)}; }
inline Vector3<Number> with_rate(const Vec3& a, const Vector3<Lanes>& e) { return {{a.x, e.x}, {a.y, e.y}, {a.z, e.z}}; }
inline Motion<Number> with_rate(const Motion<double>& a, const Motion<Lanes>& e) {
  return {with_rate(a.v, e.v), with_rate(a.w, e.w)};
}

/// What the passes hand on, by body.
struct BodyTangent {
  Motion<Lanes> displacement;  ///< η, relative to the parent
  Motion<Lanes> place;         ///< of the body in the world, in its kernel frame
  Motion<Lanes> velocity;      ///< δΩ
  Motion<Lanes> acceleration;  ///< b, then δΩ̇
  Force<Lanes> wrench;         ///< W, then with the contributions of the children
  bool moves = false;          ///< its joint, or one inboard of it, moves along a direction
};

/// Coordinates and trigonometry of a joint, the same in all lanes.
struct SpreadJoint {
  std::array<Lanes, 7> q;
  std::array<Lanes, 2> c, s;
  JointState<Lanes> state() const { return {q.data(), c.data(), s.data()}; }
};
template <class K>
SpreadJoint spread_joint(const JointState<double>& joint) {
  SpreadJoint all;
  for (int i = 0; i < K::nq; ++i) all.q[at(i)] = Lanes(joint.q[i]);
  for (std::size_t i = 0; i < K::angles.size(); ++i) all.c[i] = Lanes(joint.c[i]), all.s[i] = Lanes(joint.s[i]);
  return all;
}

/// The same, moving along the directions δq.
struct MovingJoint {
  std::array<Number, 7> q;
  std::array<Number, 2> c, s;
  std::array<Number, 6> u;
  JointState<Number> state() const { return {q.data(), c.data(), s.data()}; }
};
template <class K>
MovingJoint moving_joint(const JointState<double>& joint, const double* u, const Lanes* dq, const Lanes* dv) {
  MovingJoint moving;
  const SpreadJoint all = spread_joint<K>(joint);
  std::array<Lanes, K::nq> rate;
  K::template coordinate_rate<Lanes>(all.q.data(), dq, rate.data());
  for (int i = 0; i < K::nq; ++i) moving.q[at(i)] = {joint.q[i], rate[at(i)]};
  for (std::size_t i = 0; i < K::angles.size(); ++i) {
    const Lanes& turn = rate[at(K::angles[i])];
    moving.c[i] = {joint.c[i], -joint.s[i] * turn}, moving.s[i] = {joint.s[i], joint.c[i] * turn};
  }
  for (int i = 0; i < K::nv; ++i) moving.u[at(i)] = {u[i], dv[i]};
  return moving;
}

/// Ω × E u + Ė u with its derivative.
struct BiasTangent {
  Motion<double> value;
  Motion<Lanes> rate;
};
/// What a joint contributes to the motion of its body along the directions: η = E δq, E u with its derivative, and δE u̇. Numbers
/// are needed only for kinds whose E changes with the coordinates.
template <class K>
struct JointTangent {
  using Columns = decltype(K::template columns<double>(std::declval<LinkConstants>(), std::declval<JointState<double>>()));
  static constexpr bool turns = requires(const LinkConstants& k, const JointState<double>& j, const double* u) {
    K::template columns_rate<double>(k, j, u);
  };

  Columns E;
  std::array<Motion<Lanes>, turns ? std::tuple_size_v<Columns> : 0> columns_rate;
  Motion<Lanes> displacement{}, velocity_rate{}, turning{};
  Motion<double> velocity{};

  JointTangent(const LinkConstants& link, const JointState<double>& joint, const double* u, const double* udot, const Lanes* dq,
               const Lanes* dv)
      : E(K::template columns<double>(link, joint)) {
    for (std::size_t i = 0; i < E.size(); ++i) {
      const Motion<Lanes> column = spread(E[i]);
      displacement = displacement + Motion<Lanes>{dq[i] * column.v, dq[i] * column.w};
      velocity = velocity + Motion<double>{u[i] * E[i].v, u[i] * E[i].w};
      velocity_rate = velocity_rate + Motion<Lanes>{dv[i] * column.v, dv[i] * column.w};
    }
    if constexpr (turns) {
      moving_ = moving_joint<K>(joint, u, dq, dv);
      const auto columns = K::template columns<Number>(link, moving_.state());
      for (std::size_t i = 0; i < E.size(); ++i) {
        columns_rate[i] = rate_of(columns[i]);
        velocity_rate = velocity_rate + Motion<Lanes>{u[i] * columns_rate[i].v, u[i] * columns_rate[i].w};
        turning = turning + Motion<Lanes>{udot[i] * columns_rate[i].v, udot[i] * columns_rate[i].w};
      }
    }
  }
  /// δE · W of a DoF.
  Lanes turned([[maybe_unused]] std::size_t i, [[maybe_unused]] const Force<Lanes>& W) const {
    if constexpr (turns) return dot(columns_rate[i], W);
    return Lanes(0.0);
  }
  /// Ω × E u + Ė u at the velocity of the body and its derivative.
  BiasTangent bias(const LinkConstants& link, const Motion<double>& body, const Motion<Lanes>& rate) const {
    if constexpr (turns) {
      const Motion<Number> all =
          K::template acceleration_bias<Number>(link, moving_.state(), with_rate(body, rate), moving_.u.data());
      return {value_of(all), rate_of(all)};
    } else {
      return {cross(body, velocity), cross(rate, spread(velocity)) + cross(spread(body), velocity_rate)};
    }
  }

 private:
  struct Nothing {};
  std::conditional_t<turns, MovingJoint, Nothing> moving_;
};

}  // namespace detail::tangents

struct AccelerationTangent::Memory {
  using Lanes = detail::tangents::Lanes;
  using Number = detail::tangents::Number;
  using BodyTangent = detail::tangents::BodyTangent;

  explicit Memory(const Tree& all)
      : records(detail::untouched<Lanes>(all.tables().record_capacity)),
        bodies(detail::tangents::at(all.bodies())),
        dq(6 * detail::tangents::at(all.bodies())),
        dv(dq),
        da(dq),
        slope(6 * detail::tangents::at(all.bodies())),
        stiffness(slope),
        resisting(slope),
        transmitted(detail::tangents::at(all.bodies())) {}

  void outward() noexcept;
  void add_loads() noexcept;
  void inward() noexcept;
  void accelerate() noexcept;
  Kinematics<Number> located(int b) const noexcept;
  /// Sets dq and dv to the directions from `first` on, of which no locked DoF moves; returns how many.
  int load(int first, int count, const double* q_directions, const double* v_directions) noexcept;

  /// Whether b's joint moves along a direction.
  bool moves(int b) const noexcept;

  // Closed loops, loops.cpp. The rows that were chosen at the state hold with multipliers λ:
  //   δu̇ = δu̇₀ + H⁻¹ Jᵀ δλ,  J H⁻¹ Jᵀ δλ = −δ(J u̇ + J̇ u) at δu̇₀,
  // where δu̇₀ is that of the tree with the wrenches of constant λ.
  enum class OfRow : unsigned char { residual, velocity, acceleration };
  void prepare_loops(Workspace<double>& evaluated);
  void add_loop_wrenches() noexcept;
  void close_accelerations() noexcept;
  void close_direction() noexcept;
  void find_rows(OfRow what) noexcept;            // to `right`
  void correct(std::vector<Lanes>& to) noexcept;  // by −H⁻¹ Jᵀ (J H⁻¹ Jᵀ)⁻¹ right

  // Calls f(tag, link) for a body with a joint that can move.
  template <class F>
  void with_kernels(int b, const F& f) const noexcept {
    dispatch_kernels(tree->kind(b), tree->variant(b), [&](auto tag) {
      if constexpr (!decltype(tag)::type::rigid) f(tag, tree->link(b));
    });
  }
  template <class K>
  typename K::template Record<Lanes>& record(int b) noexcept {
    return *reinterpret_cast<typename K::template Record<Lanes>*>(records.get() +
                                                                  tree->tables().offsets[detail::tangents::at(b)].record);
  }

  const Tree* tree = nullptr;
  const State* state = nullptr;
  const Workspace<double>* workspace = nullptr;
  detail::Untouched<Lanes> records;  // those of the workspace in all lanes
  std::vector<BodyTangent> bodies;
  bool needs_places = false;                        // forces or loops depend on the places of bodies
  std::vector<Lanes> dq, dv, da;                    // packed as p
  std::vector<double> slope, stiffness, resisting;  // of the joints' resisting forces
  std::vector<Force<double>> transmitted;           // Tr, by body
  std::vector<int> rows;                            // of loops
  std::vector<double> responses;                    // H⁻¹ Jᵀ, nv numbers for each row
  DenseMatrix factor;                               // of J H⁻¹ Jᵀ
  std::vector<Lanes> right;                         // by row
};

}  // namespace momentree
