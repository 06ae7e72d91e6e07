#pragma once
// What the steps in momenta and those in velocities share: the frame in which a step works, and the transforms between it, the
// body and the parent.
//
// A step works in a frame F in which E is constant: that of the child, the frame before the joint's last rotation, about z, or,
// if the joint is a screw, the frame before its displacement, too. There (20) and (39) have no term Ė; instead, they contain the
// velocity of F. If E is constant in several of them, `Order` says which is used: the orders of reduction and transform are one
// text.
#include <algorithm>
#include <string>
#include <vector>

#include <momentree/derive/elimination.hpp>
#include <momentree/joint/screw_kernels.hpp>

namespace momentree::derive {

/// Choices that change the operations but not the results.
struct Order {
  enum Frame { child, before_rotation, before_displacement } frame = child;
  bool one_shift = false;  ///< the displacement of a screw and the placement's offset as one shift
};

/// What the derivation needs to know of a kind besides its functions.
struct Traits {
  std::string name;
  int angle = -1;  ///< the angle of the last rotation if F is the frame before it
  int dof = -1;    ///< and its DoF
  bool armature = false;
  Order::Frame frame = Order::before_rotation;  ///< of a screw, for the least time
};

template <class K, std::size_t NQ, std::size_t NV>
struct Crossing {
  const Traits& kind;
  bool leaf, root;
  Order order;
  Recorder& in;
  Link k;
  T mass = in.constant("mass");
  std::array<T, NQ> q = inputs<NQ>("j.q");
  std::array<T, K::angles.size()> c = inputs<K::angles.size()>("j.c"), s = inputs<K::angles.size()>("j.s");
  std::array<T, NV> given;
  Derived out{};

  /// `name`: the numbers of the DoFs that the first function is given.
  Crossing(const Traits& of, std::optional<PlacementShape> shape, BodyPlace place, const Order& by_order, Recorder& recorder,
           const std::string& name)
      : kind(of),
        leaf(place == BodyPlace::leaf || place == BodyPlace::single),
        root(place == BodyPlace::root || place == BodyPlace::single),
        order(by_order),
        in(recorder),
        k(recorder, shape),
        given(inputs<NV>(name)) {
    if (kind.name == "free" && !root) k.geometry[0] = k.geometry[1] = k.geometry[2] = T(0);  // the frame is that of the joint
    c_F = c, s_F = s;
    for (std::size_t i = 0; i < c.size(); ++i)
      if (static_cast<int>(i) == kind.angle) c_F[i] = T(1), s_F[i] = T(0);
    const auto columns = K::template columns<T>(k, JointState<T>{q.data(), c_F.data(), s_F.data()});
    for (const Motion<T>& e : columns) E.push_back(six(e));
    basis = unit_basis(E);
    if (kind.armature) basis.armature = in.constant("armature");
  }

 protected:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  template <std::size_t N>
  std::array<T, N> inputs(const std::string& name) {
    std::array<T, N> all;
    for (std::size_t i = 0; i < N; ++i) all[i] = in.number(name + '[' + std::to_string(i) + ']');
    return all;
  }
  Function& begin(const std::string& text) {
    out.functions.emplace_back();
    part(text);
    return out.functions.back();
  }
  void part(const std::string& text) { out.functions.back().comments.push_back({in.size(), text}); }
  void end() { out.functions.back().end = in.size(); }
  static void store(std::vector<Store>& to, const std::string& name, const Vector3<T>& a) {
    to.push_back({name + ".x", a.x.node()}), to.push_back({name + ".y", a.y.node()});
    to.push_back({name + ".z", a.z.node()});
  }
  static void store(std::vector<Store>& to, const std::string& name, const SpatialMass<T>& M) {
    const auto put = [&](const char* element, const T& x) { to.push_back({name + element, x.node()}); };
    put(".A.xx", M.A.xx), put(".A.yy", M.A.yy), put(".A.zz", M.A.zz), put(".A.xy", M.A.xy), put(".A.xz", M.A.xz);
    put(".A.yz", M.A.yz), put(".B.xx", M.B.xx), put(".B.xy", M.B.xy), put(".B.xz", M.B.xz), put(".B.yx", M.B.yx);
    put(".B.yy", M.B.yy), put(".B.yz", M.B.yz), put(".B.zx", M.B.zx), put(".B.zy", M.B.zy), put(".B.zz", M.B.zz);
    put(".J.xx", M.J.xx), put(".J.yy", M.J.yy), put(".J.zz", M.J.zz), put(".J.xy", M.J.xy), put(".J.xz", M.J.xz);
    put(".J.yz", M.J.yz);
  }

  /// p' = Qᵀ p, momenta or forces along the columns of the basis.
  std::vector<T> along_basis(const std::array<T, NV>& p) const {
    std::vector<T> to;
    for (std::size_t i = 0; i < NV; ++i) {
      T x(0);
      for (std::size_t j = 0; j < NV; ++j) x = x + basis.Q[i][j] * p[j];
      to.push_back(x);
    }
    return to;
  }
  /// u = Q u'.
  std::array<T, NV> from_basis(const std::vector<T>& u_basis) const {
    std::array<T, NV> u;
    for (std::size_t i = 0; i < NV; ++i) {
      u[i] = T(0);
      for (std::size_t j = 0; j < NV; ++j) u[i] = u[i] + basis.Q[j][i] * u_basis[j];
    }
    return u;
  }

  SpatialMass<T> mass_of_children() {
    if (leaf) return {zero_symmetric(), zero_matrix(), zero_symmetric()};
    return {symmetric("a.M.A"), matrix("a.M.B"), symmetric("a.M.J")};
  }
  Force<T> force_of_children() {
    if (leaf) return {zero(), zero()};
    return {in.numbers_of("a.D.l"), in.numbers_of("a.D.h")};
  }

  // Inboard. Every transform takes the quantities that are to be transformed.

  /// From the child's frame to the frame before the last rotation.
  void before_last_rotation(auto&... x) {
    if (kind.angle < 0) return;
    part("before the last rotation, where E is constant");
    (rotate_z(x, c[at(kind.angle)], s[at(kind.angle)]), ...);
  }
  // The parts of a screw's transform.
  void find_screw() {
    screw = K::template screw<T>(k, JointState<T>{q.data(), c.data(), s.data()});
    screw.d = screw.d + k.d;
  }
  void rotate_own(auto&... x) { (rotate_z(x, screw.c, screw.s), ...); }
  void displace(auto&... x) const { (shift(x, Vector3<T>{T(0), T(0), screw.d}), ...); }
  void rotate_placement(auto&... x) {
    (rotate_x(x, k.cos_a, k.sin_a), ...);
    (rotate_z(x, k.cos_b, k.sin_b), ...);
  }
  /// E is the same on both sides of a screw.
  void impose_again(SpatialMass<T>& M) const {
    if (!kind.armature)
      for (std::size_t i = 0; i < NV; ++i) impose(M, basis.columns[i], basis.pivots[i]);
  }
  /// The placement's offset, with the displacement of the joint if both are one shift.
  Vector3<T> offset() {
    Vector3<T> r{T(0), T(0), order.one_shift ? screw.d : T(0)};
    rotate_x(r, k.cos_a, k.sin_a), rotate_z(r, k.cos_b, k.sin_b);
    return k.r + r;
  }

  // Outboard.

  /// Directions before the joint's own motion.
  void placement_out(auto&... x) { (placement_outboard<false>(k, x), ...); }
  static void rotate_out(const T& cos, const T& sin, auto&... x) { (rotate_z(x, cos, -sin), ...); }
  /// Directions in F: to the axes of the child.
  void to_child(auto&... x) const {
    if (kind.angle >= 0) rotate_out(c[at(kind.angle)], s[at(kind.angle)], x...);
    if constexpr (K::rotates_about_z)
      if (order.frame != Order::child) rotate_out(screw.c, screw.s, x...);
  }

  /// (27) for one column after the other, the last reduced first, and (17): the body's velocity, from that before the joint's
  /// own. In a pivot's row it is the velocity that the column's pivot contributes in total. The same for accelerations.
  Six joint_velocity(const Six& before, std::vector<T>& u_basis) const {
    Six now = before;
    for (std::size_t i = NV; i-- > 0;) {
      const Six& e = basis.columns[i];
      const std::size_t pivot = basis.pivots[i];
      const T turning = now[pivot];
      T total = eliminated[i].u0;
      if (kind.armature) {
        for (std::size_t j = 0; j < 6; ++j) total = total - eliminated[i].g[j] * now[j];
        u_basis[i] = total;
        for (std::size_t j = 0; j < 6; ++j) now[j] = now[j] + e[j] * total;
        continue;
      }
      for (std::size_t j = 0; j < 6; ++j)
        if (j != pivot) total = total - eliminated[i].g[j] * (now[j] - e[j] * turning);
      u_basis[i] = total - turning;
      for (std::size_t j = 0; j < 6; ++j)
        if (j != pivot) now[j] = now[j] + e[j] * u_basis[i];
      now[pivot] = total;
    }
    return now;
  }
  /// M̂ a + D̂, as in (21). M̂ does not act on velocities along the columns, and Eᵀ (M̂ a + D̂) = p gives the rows of the pivots.
  Six reduced_sum(const Six& a, const std::vector<T>& p_basis) {
    Six rest = a;
    const auto is_pivot = [&](std::size_t j) {
      return !kind.armature && std::count(basis.pivots.begin(), basis.pivots.end(), j) > 0;
    };
    for (std::size_t i = 0; i < NV && !kind.armature; ++i) {
      const T along = a[basis.pivots[i]];
      for (std::size_t j = 0; j < 6; ++j) rest[j] = j == basis.pivots[i] ? T(0) : rest[j] - basis.columns[i][j] * along;
    }
    Six sum = six(D_hat);
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t l = 0; l < 6 && !is_pivot(j); ++l) sum[j] = sum[j] + element(M_hat, j, l) * rest[l];
    for (std::size_t i = 0; i < NV && !kind.armature; ++i) {
      const std::size_t pivot = basis.pivots[i];
      sum[pivot] = p_basis[i];
      for (std::size_t j = 0; j < 6; ++j)
        if (j != pivot) sum[pivot] = sum[pivot] - basis.columns[i][j] * sum[j];
    }
    return sum;
  }
  /// The velocity of F: without the motion between it and the body.
  Six velocity_of_F(const Six& before, const Six& now, const std::array<T, NV>& u) const {
    if (K::rotates_about_z && order.frame != Order::child) return before;  // what is along z has no effect on a screw
    Six frame = now;
    if (kind.dof < 0) return frame;
    const Six& last = E[at(kind.dof)];
    for (std::size_t j = 0; j < 6; ++j) {
      if (is_zero(last[j])) continue;
      frame[j] = before[j];
      for (std::size_t i = 0; i < NV; ++i)
        if (static_cast<int>(i) != kind.dof) frame[j] = frame[j] + E[i][j] * u[i];
    }
    return frame;
  }

  /// The transform from F to the parent, (16), (17).
  void find_transform() {
    Matrix3<T> own;
    Vector3<T> r;
    K::template pose<T>(k, JointState<T>{q.data(), c_F.data(), s_F.data()}, own, r);
    across_joint = {k.R0 * own, k.r + k.R0 * r};
  }

  static Vector3<T> zero() { return {T(0), T(0), T(0)}; }
  static Symmetric3<T> zero_symmetric() { return {T(0), T(0), T(0), T(0), T(0), T(0)}; }
  static Matrix3<T> zero_matrix() { return {T(0), T(0), T(0), T(0), T(0), T(0), T(0), T(0), T(0)}; }
  Symmetric3<T> symmetric(const std::string& m) {
    return {in.number(m + ".xx"), in.number(m + ".yy"), in.number(m + ".zz"),
            in.number(m + ".xy"), in.number(m + ".xz"), in.number(m + ".yz")};
  }
  Matrix3<T> matrix(const std::string& m) {
    return {in.number(m + ".xx"), in.number(m + ".xy"), in.number(m + ".xz"), in.number(m + ".yx"), in.number(m + ".yy"),
            in.number(m + ".yz"), in.number(m + ".zx"), in.number(m + ".zy"), in.number(m + ".zz")};
  }

  std::array<T, K::angles.size()> c_F, s_F;
  std::vector<Six> E;
  Basis basis;
  std::vector<Eliminated> eliminated;
  SpatialMass<T> M_hat;
  Force<T> D_hat;
  DenseTransform<T> across_joint;
  Screw<T> screw;
};

}  // namespace momentree::derive
