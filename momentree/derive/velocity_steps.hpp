#pragma once
// The steps of the three passes of a stage in velocities, as a text that runs on symbols: velocities outboard, (22)–(26), (39)
// and (16) inboard, accelerations (39), (27), (17) outboard.
//
// The accelerations are those of points, a = v̇ + ω × v at the body's origin. Then the wrench of a body's own motion and the bias
// contain angular velocities only, and no linear velocities are found.
#include <momentree/derive/crossing.hpp>

namespace momentree::derive {

template <class K, std::size_t NQ, std::size_t NV>
struct VelocitySteps : Crossing<K, NQ, NV> {
  using Base = Crossing<K, NQ, NV>;
  using Base::kind, Base::leaf, Base::root, Base::order, Base::in, Base::k, Base::q, Base::c, Base::s;
  using Base::out, Base::E, Base::basis, Base::eliminated, Base::M_hat, Base::D_hat, Base::across_joint, Base::screw;

  VelocitySteps(const Traits& of, std::optional<PlacementShape> shape, BodyPlace place, const Order& by_order, Recorder& recorder)
      : Base(of, shape, place, by_order, recorder, "u") {}

  Derived run() {
    velocities();
    inboard();
    outboard();
    out.find_record(in.expressions.nodes(), in.numbers);
    return out;
  }

 private:
  void velocities() {
    Function& f = this->begin("(17), (39): angular velocity and centripetal acceleration, into the joint's frame");
    Vector3<T> w = root ? this->zero() : in.numbers_of("velocity.w");
    const auto centripetal = [&w](const Vector3<T>& r) { return cross(w, cross(w, r)); };
    Vector3<T> a = this->zero();
    if constexpr (K::rotates_about_z) {
      this->find_screw();
      a = centripetal(this->offset());
      this->placement_out(w, a);
      if (!order.one_shift) a += centripetal({T(0), T(0), screw.d});
      if (order.frame == Order::child) this->rotate_out(screw.c, screw.s, w, a);
    } else {
      this->find_transform();
      a = centripetal(across_joint.r);
      across_joint.outboard(w), across_joint.outboard(a);
    }
    this->part("(17)");
    const std::array<T, NV>& u = this->given;
    Motion<T> relative{this->zero(), this->zero()};
    for (std::size_t i = 0; i < NV; ++i) relative = relative + Motion<T>{u[i] * motion(E[i]).v, u[i] * motion(E[i]).w};
    const Six before = six(Motion<T>{this->zero(), w}), now = six(Motion<T>{relative.v, w + relative.w});
    this->part("(39): the bias");
    const Vector3<T> w_F = motion(this->velocity_of_F(before, now, u)).w;
    bias = {a + cross(w_F + w, relative.v), cross(w_F, relative.w)};
    if (order.frame == Order::before_displacement) shift_outboard(bias, Vector3<T>{T(0), T(0), -screw.d});
    this->part("rates of the coordinates");
    std::array<T, NQ> qdot;
    K::template coordinate_rate<T>(q.data(), u.data(), qdot.data());
    for (std::size_t i = 0; i < NQ; ++i) f.stores.push_back({"qdot[" + std::to_string(i) + ']', qdot[i].node()});
    this->part("(17): the body's own angular velocity");
    angular = motion(now).w;
    this->to_child(angular);
    if (!leaf) this->store(f.last, "velocity.w", angular);
    this->end();
  }

  void inboard() {
    Function& f = this->begin("(9): the wrench of the body's own motion");
    const Force<T> own{cross(angular, cross(angular, k.body.mc)), cross(angular, k.body.J * angular)};
    this->part("(22), (23): the body and its children");
    SpatialMass<T> M = this->mass_of_children();
    Force<T> W = this->force_of_children();
    articulated_mass(k.body, M);
    W = W + own;
    this->before_last_rotation(M, W.l, W.h);
    if constexpr (K::rotates_about_z) {
      if (order.frame != Order::child) this->rotate_own(M, W.l, W.h);
      if (order.frame == Order::before_displacement) this->displace(M, W);
    }
    this->part("(24), (25), (26), column by column");
    const std::vector<T> tau = this->along_basis(Base::template inputs<NV>("tau"));
    eliminated = reduce(basis, tau, M, W, f.first);
    if (root) return this->end();

    M_hat = M, D_hat = W;
    const auto add_bias = [&] {
      this->part("(39): the bias");
      W = force(this->reduced_sum(six(bias), tau));
      this->part("(16)");
    };
    this->part("(16)");
    if constexpr (K::rotates_about_z) {
      add_bias();
      if (order.frame == Order::child) this->rotate_own(M, W.l, W.h);
      if (order.frame != Order::before_displacement && !order.one_shift) this->displace(M, W);
      this->impose_again(M);
      const Vector3<T> r = this->offset();
      this->rotate_placement(M), this->rotate_placement(W.l, W.h);
      shift(M, r), shift(W, r);
    } else {
      rotate(M, across_joint.R);
      shift(M, across_joint.r);
      add_bias();
      across_joint.inboard(W);
    }
    this->store(f.last, "to.M", M);
    this->store(f.last, "to.D.l", W.l), this->store(f.last, "to.D.h", W.h);
    this->end();
  }

  void outboard() {
    Function& f = this->begin("(39): into the joint's frame");
    Motion<T> a{in.numbers_of("a.v"), root ? this->zero() : in.numbers_of("a.w")};  // the ground does not turn
    if constexpr (K::rotates_about_z) {
      shift_outboard(a, this->offset());
      this->placement_out(a.v, a.w);
      if (order.frame != Order::before_displacement && !order.one_shift) shift_outboard(a, Vector3<T>{T(0), T(0), screw.d});
      if (order.frame == Order::child) this->rotate_out(screw.c, screw.s, a.v, a.w);
    } else {
      across_joint.outboard(a);
    }
    a = a + bias;
    this->part("(27)");
    std::vector<T> udot_basis(NV);
    const Six now = this->joint_velocity(six(a), udot_basis);
    const std::array<T, NV> udot = this->from_basis(udot_basis);
    for (std::size_t i = 0; i < NV; ++i) f.stores.push_back({"udot[" + std::to_string(i) + ']', udot[i].node()});
    if (leaf) return this->end();  // nothing reads its acceleration
    this->part("(17): the body's own acceleration");
    a = motion(now);
    if (order.frame == Order::before_displacement) shift_outboard(a, Vector3<T>{T(0), T(0), screw.d});
    this->to_child(a.v, a.w);
    this->store(f.last, "a.v", a.v), this->store(f.last, "a.w", a.w);
    this->end();
  }

  Motion<T> bias;
  Vector3<T> angular;  // of the body, in its own axes
};

}  // namespace momentree::derive
