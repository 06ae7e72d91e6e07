#pragma once
// The steps of both passes across a joint of any kind, as a text that runs on symbols: (22)–(26) and (16) inboard, (17), (27),
// (21) and (20) outboard.
//
// Both steps work in a frame F in which E is constant: that of the child, the frame before the joint's last rotation, about z,
// or, if the joint is a screw, the frame before its displacement, too. There (20) has no term Ė; instead, Ω × Pb contains the
// velocity of F. If E is constant in several of them, `Order` says which is used: the orders of reduction and transform are one
// text.
#include <algorithm>
#include <string>
#include <vector>

#include <tools/derive/elimination.hpp>

namespace momentree::derive {

/// What the derivation needs to know of a kind besides its functions.
struct Traits {
  std::string name, kernels;
  std::vector<LinkRotation> rotations;
  int angle = -1;  ///< the angle of the last rotation if F is the frame before it
  int dof = -1;    ///< and its DoF
};

/// Choices that change the operations but not the results.
struct Order {
  enum Frame { child, before_rotation, before_displacement } frame = child;
  bool one_shift = false;  ///< the displacement of a screw and the placement's offset as one shift
};

struct Derived {
  Function inboard, outboard;
  std::vector<int> record;  ///< the nodes that the inward step stores for the outward step
};

template <class K, std::size_t NQ, std::size_t NV>
struct Text {
  const Traits& kind;
  LinkRotation rotation;
  bool leaf, root;
  Order order;
  Recorder& in;
  Link k{in, rotation};
  T mass = in.constant("mass");
  std::array<T, NQ> q = inputs<NQ>("j.q");
  std::array<T, K::angles.size()> c = inputs<K::angles.size()>("j.c"), s = inputs<K::angles.size()>("j.s");
  std::array<T, NV> p = inputs<NV>("p");
  Derived out{};

  Text(const Traits& of, LinkRotation by, Place place, const Order& by_order, Recorder& recorder)
      : kind(of),
        rotation(by),
        leaf(place == Place::leaf || place == Place::single),
        root(place == Place::root || place == Place::single),
        order(by_order),
        in(recorder) {}

  Derived run() {
    if (kind.name == "free" && !root) k.geometry[0] = k.geometry[1] = k.geometry[2] = T(0);  // the frame is that of the joint
    c_F = c, s_F = s;
    for (std::size_t i = 0; i < c.size(); ++i)
      if (static_cast<int>(i) == kind.angle) c_F[i] = T(1), s_F[i] = T(0);
    const auto columns = K::template columns<T>(k, JointState<T>{q.data(), c_F.data(), s_F.data()});
    for (const Motion<T>& e : columns) E.push_back(six(e));
    basis = unit_basis(E);
    for (std::size_t i = 0; i < NV; ++i) {
      T x(0);
      for (std::size_t j = 0; j < NV; ++j) x = x + basis.Q[i][j] * p[j];
      p_basis.push_back(x);
    }
    inboard();
    const int own = in.size();
    outboard();
    out.record = nodes_before(own);
    return out;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  template <std::size_t N>
  std::array<T, N> inputs(const std::string& name) {
    std::array<T, N> all;
    for (std::size_t i = 0; i < N; ++i) all[i] = in.number(name + '[' + std::to_string(i) + ']');
    return all;
  }
  static void begin(Function& f, Recorder& in, const std::string& text) { f.comments.push_back({in.size(), text}); }
  static void store(std::vector<Store>& to, const std::string& name, const Vector3<T>& a) {
    to.push_back({name + ".x", a.x.node(), {}}), to.push_back({name + ".y", a.y.node(), {}});
    to.push_back({name + ".z", a.z.node(), {}});
  }

  void inboard() {
    Function& f = out.inboard;
    begin(f, in, "(22), (23): the body and its children");
    SpatialMass<T> M{zero_symmetric(), zero_matrix(), zero_symmetric()};
    Force<T> D{zero(), zero()};
    Vector3<T> mc = zero();
    if (!leaf) {
      M = {symmetric("a.M.A"), matrix("a.M.B"), symmetric("a.M.J")};
      D = {in.numbers_of("a.D.l"), in.numbers_of("a.D.h")};
      mc = in.numbers_of("a.mc");
    }
    articulated_mass(k.body, M), remainder_momentum(D);
    mc += k.body.mc;
    if (kind.angle >= 0) {
      begin(f, in, "before the last rotation, where E is constant");
      const T &cos = c[at(kind.angle)], &sin = s[at(kind.angle)];
      rotate_z(M, cos, sin), rotate_z(D.l, cos, sin), rotate_z(D.h, cos, sin), rotate_z(mc, cos, sin);
    }
    if constexpr (K::rotates_about_z) {
      screw = K::template screw<T>(k, JointState<T>{q.data(), c.data(), s.data()});
      if (order.frame != Order::child) rotate_own(M, D, mc);
      if (order.frame == Order::before_displacement) displace(M, D, mc);
    }
    begin(f, in, "(24), (25), (26), column by column");
    eliminated = reduce(basis, p_basis, M, D, f.first);
    M_hat = M, D_hat = D;
    const char* const axes[] = {"x", "y", "z"};
    const T moments[] = {mc.x, mc.y, mc.z};
    for (std::size_t i = 0; i < 3; ++i) f.stores.push_back({"w.mc." + std::string(axes[i]), moments[i].node(), "gravity"});
    if (root) {
      if constexpr (!K::rotates_about_z) across_joint = across();
      return;
    }

    begin(f, in, "(16)");
    if constexpr (K::rotates_about_z) {
      if (order.frame == Order::child) rotate_own(M, D, mc);
      if (order.frame != Order::before_displacement && !order.one_shift) displace(M, D, mc);
      // E is the same on both sides of the joint.
      for (std::size_t i = 0; i < NV; ++i) impose(M, basis.columns[i], basis.pivots[i]);
      const Vector3<T> r = offset();
      rotate_x(M, k.cos_a, k.sin_a), rotate_z(M, k.cos_b, k.sin_b);
      rotate_x(D.l, k.cos_a, k.sin_a), rotate_x(D.h, k.cos_a, k.sin_a);
      rotate_z(D.l, k.cos_b, k.sin_b), rotate_z(D.h, k.cos_b, k.sin_b);
      rotate_x(mc, k.cos_a, k.sin_a), rotate_z(mc, k.cos_b, k.sin_b);
      shift(M, r), shift(D, r);
      mc += mass * r;
    } else {
      across_joint = across();
      rotate(M, across_joint.R);
      shift(M, across_joint.r);
      across_joint.inboard(D);
      mc = across_joint.R * mc + mass * across_joint.r;
    }
    store_mass("to.M", M);
    store(f.last, "to.D.l", D.l), store(f.last, "to.D.h", D.h), store(f.last, "to.mc", mc);
  }

  // The parts of a screw's transform.
  void rotate_own(SpatialMass<T>& M, Force<T>& D, Vector3<T>& mc) {
    rotate_z(M, screw.c, screw.s), rotate_z(D.l, screw.c, screw.s), rotate_z(D.h, screw.c, screw.s);
    rotate_z(mc, screw.c, screw.s);
  }
  void displace(SpatialMass<T>& M, Force<T>& D, Vector3<T>& mc) {
    const Vector3<T> along{T(0), T(0), screw.d};
    shift(M, along), shift(D, along);
    mc.z = mc.z + mass * screw.d;
  }
  /// The placement's offset, with the displacement of the joint if both are one shift.
  Vector3<T> offset() {
    Vector3<T> r{T(0), T(0), order.one_shift ? screw.d : T(0)};
    rotate_x(r, k.cos_a, k.sin_a), rotate_z(r, k.cos_b, k.sin_b);
    return k.r + r;
  }

  void outboard() {
    Function& f = out.outboard;
    begin(f, in, "(17): into the joint's frame");
    Motion<T> velocity{zero(), zero()};  // the ground rests
    if (!root) velocity = {in.numbers_of("out.velocity.v"), in.numbers_of("out.velocity.w")};
    Vector3<T> gravity = in.numbers_of("out.gravity");
    if constexpr (K::rotates_about_z) {
      shift_outboard(velocity, offset());
      placement_outboard<false>(k, velocity.v), placement_outboard<false>(k, velocity.w), placement_outboard<false>(k, gravity);
      if (!order.one_shift && order.frame != Order::before_displacement)
        shift_outboard(velocity, Vector3<T>{T(0), T(0), screw.d});
      if (order.frame == Order::child) rotate_out(velocity, gravity, screw.c, screw.s);
    } else {
      across_joint.outboard(velocity), across_joint.outboard(gravity);
    }
    begin(f, in, "(27)");
    const Six before = six(velocity);
    std::vector<T> u_basis(NV);
    const Six now = joint_velocity(before, u_basis);
    std::array<T, NV> u;
    for (std::size_t i = 0; i < NV; ++i) {
      u[i] = T(0);
      for (std::size_t j = 0; j < NV; ++j) u[i] = u[i] + basis.Q[j][i] * u_basis[j];
    }
    begin(f, in, "(21)");
    const Six Pb = articulated_momentum(before);
    begin(f, in, "(15), (20)");
    const Force<T> weight = accumulated_force(mass, in.numbers_of("w.mc"), gravity);
    const std::array<T, NV> rate = momentum_rate(weight, velocity_of_F(before, now, u), Pb);
    for (std::size_t i = 0; i < NV; ++i) {
      const std::string place = '[' + std::to_string(i) + ']';
      f.stores.push_back({"u" + place, u[i].node(), {}});
      f.stores.push_back({"pdot" + place, rate[i].node(), {}});
    }
    begin(f, in, "rates of the coordinates");
    std::array<T, NQ> qdot;
    K::template coordinate_rate<T>(q.data(), u.data(), qdot.data());
    for (std::size_t i = 0; i < NQ; ++i) f.stores.push_back({"qdot[" + std::to_string(i) + ']', qdot[i].node(), {}});
    if (leaf) return;  // nothing reads its velocity
    begin(f, in, "(17): the body's own velocity");
    velocity = motion(now);
    if (kind.angle >= 0) {
      const T &cos = c[at(kind.angle)], &sin = s[at(kind.angle)];
      rotate_out(velocity, gravity, cos, sin);
    }
    if constexpr (K::rotates_about_z) {
      if (order.frame == Order::before_displacement) shift_outboard(velocity, Vector3<T>{T(0), T(0), screw.d});
      if (order.frame != Order::child) rotate_out(velocity, gravity, screw.c, screw.s);
    }
    store(f.last, "out.velocity.v", velocity.v), store(f.last, "out.velocity.w", velocity.w),
        store(f.last, "out.gravity", gravity);
  }

  /// (27) for one column after the other, the last reduced first, and (17): the body's velocity, from that before the joint's
  /// own. In a pivot's row it is the velocity that the column's pivot contributes in total.
  Six joint_velocity(const Six& before, std::vector<T>& u_basis) const {
    Six now = before;
    for (std::size_t i = NV; i-- > 0;) {
      const Six& e = basis.columns[i];
      const std::size_t pivot = basis.pivots[i];
      const T turning = now[pivot];
      T total = eliminated[i].u0;
      for (std::size_t j = 0; j < 6; ++j)
        if (j != pivot) total = total - eliminated[i].g[j] * (now[j] - e[j] * turning);
      u_basis[i] = total - turning;
      for (std::size_t j = 0; j < 6; ++j)
        if (j != pivot) now[j] = now[j] + e[j] * u_basis[i];
      now[pivot] = total;
    }
    return now;
  }
  /// (21): Pb = M̂ X Ω_parent + D̂. M̂ does not act on velocities along the columns, and Eᵀ Pb = p gives the rows of the pivots.
  Six articulated_momentum(const Six& before) {
    Six rest = before;
    for (std::size_t i = 0; i < NV; ++i) {
      const T along = before[basis.pivots[i]];
      for (std::size_t j = 0; j < 6; ++j) rest[j] = j == basis.pivots[i] ? T(0) : rest[j] - basis.columns[i][j] * along;
    }
    Six Pb = six(D_hat);
    const auto is_pivot = [&](std::size_t j) { return std::count(basis.pivots.begin(), basis.pivots.end(), j) > 0; };
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t l = 0; l < 6 && !is_pivot(j); ++l) Pb[j] = Pb[j] + element(M_hat, j, l) * rest[l];
    for (std::size_t i = 0; i < NV; ++i) {
      const std::size_t pivot = basis.pivots[i];
      Pb[pivot] = p_basis[i];
      for (std::size_t j = 0; j < 6; ++j)
        if (j != pivot) Pb[pivot] = Pb[pivot] - basis.columns[i][j] * Pb[j];
    }
    return Pb;
  }
  /// Without the motion between F and the body.
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
  /// (20): ṗ = Eᵀ (Tb − Ω × Pb), E being constant in F.
  std::array<T, NV> momentum_rate(const Force<T>& weight, const Six& frame, const Six& Pb) const {
    const Six wrench = six(weight - gyroscopic(motion(frame), force(Pb)));
    std::array<T, NV> rate;
    for (std::size_t i = 0; i < NV; ++i) {
      rate[i] = T(0);
      for (std::size_t j = 0; j < 6; ++j) rate[i] = rate[i] + E[i][j] * wrench[j];
    }
    return rate;
  }

  Force<T> gyroscopic(const Motion<T>& frame, const Force<T>& Pb) const {
    if constexpr (requires { K::template gyroscopic<T>(k.body.mc, frame, Pb); })
      if (root && leaf) return K::template gyroscopic<T>(k.body.mc, frame, Pb);
    return cross(frame, Pb);
  }

  static void rotate_out(Motion<T>& velocity, Vector3<T>& gravity, const T& cos, const T& sin) {
    rotate_z(velocity.v, cos, -sin), rotate_z(velocity.w, cos, -sin), rotate_z(gravity, cos, -sin);
  }
  /// The transform from F to the parent, (16), (17).
  DenseTransform<T> across() {
    Matrix3<T> own;
    Vector3<T> r;
    K::template pose<T>(k, JointState<T>{q.data(), c_F.data(), s_F.data()}, own, r);
    return {k.R0 * own, k.r + k.R0 * r};
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
  void store_mass(const std::string& name, const SpatialMass<T>& M) {
    std::vector<Store>& to = out.inboard.last;
    const auto put = [&](const char* element, const T& x) { to.push_back({name + element, x.node(), {}}); };
    put(".A.xx", M.A.xx), put(".A.yy", M.A.yy), put(".A.zz", M.A.zz), put(".A.xy", M.A.xy), put(".A.xz", M.A.xz);
    put(".A.yz", M.A.yz), put(".B.xx", M.B.xx), put(".B.xy", M.B.xy), put(".B.xz", M.B.xz), put(".B.yx", M.B.yx);
    put(".B.yy", M.B.yy), put(".B.yz", M.B.yz), put(".B.zx", M.B.zx), put(".B.zy", M.B.zy), put(".B.zz", M.B.zz);
    put(".J.xx", M.J.xx), put(".J.yy", M.J.yy), put(".J.zz", M.J.zz), put(".J.xy", M.J.xy), put(".J.xz", M.J.xz);
    put(".J.yz", M.J.yz);
  }

  /// The operations below `own` that the outward step needs: it reads them from the record.
  std::vector<int> nodes_before(int own) const {
    const auto& nodes = in.expressions.nodes();
    std::vector<bool> needed(nodes.size(), false);
    for (const auto* list : {&out.outboard.stores, &out.outboard.last})
      for (const Store& one : *list) needed[at(one.node)] = true;
    std::vector<int> found;
    for (std::size_t i = nodes.size(); i-- > 0;) {
      if (!needed[i]) continue;
      const auto& node = nodes[i];
      if (binary(node.operation) && static_cast<int>(i) < own) {
        found.push_back(static_cast<int>(i));
        continue;
      }
      if (unary(node.operation) || binary(node.operation)) needed[at(node.a)] = true;
      if (binary(node.operation)) needed[at(node.b)] = true;
    }
    return {found.rbegin(), found.rend()};
  }

  std::array<T, K::angles.size()> c_F, s_F;
  std::vector<Six> E;
  Basis basis;
  std::vector<T> p_basis;
  std::vector<Eliminated> eliminated;
  SpatialMass<T> M_hat;
  Force<T> D_hat;
  DenseTransform<T> across_joint;
  Screw<T> screw;
};

}  // namespace momentree::derive
