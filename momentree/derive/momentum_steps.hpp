#pragma once
// The steps of both passes across a joint of any kind, as a text that runs on symbols: (22)–(26) and (16) inboard, (17), (27),
// (21) and (20) outboard.
#include <momentree/derive/crossing.hpp>

namespace momentree::derive {

template <class K, std::size_t NQ, std::size_t NV>
struct MomentumSteps : Crossing<K, NQ, NV> {
  using Base = Crossing<K, NQ, NV>;
  using Base::kind, Base::leaf, Base::root, Base::order, Base::in, Base::k, Base::mass, Base::q, Base::c, Base::s;
  using Base::out, Base::E, Base::basis, Base::eliminated, Base::M_hat, Base::D_hat, Base::across_joint, Base::screw;

  std::vector<T> p_basis;

  bool has_gravity;

  MomentumSteps(const Traits& of, std::optional<PlacementShape> shape, BodyPlace place, const Order& by_order, Recorder& recorder,
                bool gravity)
      : Base(of, shape, place, by_order, recorder, "p"), p_basis(this->along_basis(this->given)), has_gravity(gravity) {}

  Derived run() {
    inboard();
    outboard();
    out.find_record(in.expressions.nodes(), in.numbers);
    return out;
  }

 private:
  void inboard() {
    Function& f = this->begin("(22), (23): the body and its children");
    SpatialMass<T> M = this->mass_of_children();
    Force<T> D = this->force_of_children();
    Vector3<T> mc = leaf || !has_gravity ? this->zero() : in.numbers_of("a.mc");
    articulated_mass(k.body, M), remainder_momentum(D);
    if (has_gravity) mc += k.body.mc;
    this->before_last_rotation(M, D.l, D.h, mc);
    const auto displace = [&] {
      Base::displace(M, D);
      if (has_gravity) mc.z = mc.z + mass * screw.d;
    };
    if constexpr (K::rotates_about_z) {
      this->find_screw();
      if (order.frame != Order::child) this->rotate_own(M, D.l, D.h, mc);
      if (order.frame == Order::before_displacement) displace();
    }
    this->part("(24), (25), (26), column by column");
    eliminated = reduce(basis, p_basis, M, D, f.first);
    M_hat = M, D_hat = D;
    const char* const axes[] = {"x", "y", "z"};
    const T moments[] = {mc.x, mc.y, mc.z};
    for (std::size_t i = 0; i < 3 && has_gravity; ++i) f.stores.push_back({"w.mc." + std::string(axes[i]), moments[i].node()});
    if (root) {
      if constexpr (!K::rotates_about_z) this->find_transform();
      return this->end();
    }

    this->part("(16)");
    if constexpr (K::rotates_about_z) {
      if (order.frame == Order::child) this->rotate_own(M, D.l, D.h, mc);
      if (order.frame != Order::before_displacement && !order.one_shift) displace();
      this->impose_again(M);
      const Vector3<T> r = this->offset();
      this->rotate_placement(M), this->rotate_placement(D.l, D.h), this->rotate_placement(mc);
      shift(M, r), shift(D, r);
      if (has_gravity) mc += mass * r;
    } else {
      this->find_transform();
      rotate(M, across_joint.R);
      shift(M, across_joint.r);
      across_joint.inboard(D);
      if (has_gravity) mc = across_joint.R * mc + mass * across_joint.r;
    }
    this->store(f.last, "to.M", M);
    this->store(f.last, "to.D.l", D.l), this->store(f.last, "to.D.h", D.h);
    if (has_gravity) this->store(f.last, "to.mc", mc);
    this->end();
  }

  void outboard() {
    Function& f = this->begin("(17): into the joint's frame");
    Motion<T> velocity{this->zero(), this->zero()};  // the ground rests
    if (!root) velocity = {in.numbers_of("out.velocity.v"), in.numbers_of("out.velocity.w")};
    Vector3<T> gravity = has_gravity ? in.numbers_of("out.gravity") : this->zero();
    if constexpr (K::rotates_about_z) {
      shift_outboard(velocity, this->offset());
      this->placement_out(velocity.v, velocity.w, gravity);
      if (!order.one_shift && order.frame != Order::before_displacement)
        shift_outboard(velocity, Vector3<T>{T(0), T(0), screw.d});
      if (order.frame == Order::child) this->rotate_out(screw.c, screw.s, velocity.v, velocity.w, gravity);
    } else {
      across_joint.outboard(velocity), across_joint.outboard(gravity);
    }
    this->part("(27)");
    const Six before = six(velocity);
    std::vector<T> u_basis(NV);
    const Six now = this->joint_velocity(before, u_basis);
    const std::array<T, NV> u = this->from_basis(u_basis);
    this->part("(21)");
    const Six Pb = this->reduced_sum(before, p_basis);
    this->part("(15), (20)");
    Force<T> weight{this->zero(), this->zero()};
    if (has_gravity) weight = accumulated_force(mass, in.numbers_of("w.mc"), gravity);
    const std::array<T, NV> rate = momentum_rate(weight, this->velocity_of_F(before, now, u), Pb);
    for (std::size_t i = 0; i < NV; ++i) {
      const std::string place = '[' + std::to_string(i) + ']';
      f.stores.push_back({"u" + place, u[i].node()});
      f.stores.push_back({"pdot" + place, rate[i].node()});
    }
    this->part("rates of the coordinates");
    std::array<T, NQ> qdot;
    K::template coordinate_rate<T>(q.data(), u.data(), qdot.data());
    for (std::size_t i = 0; i < NQ; ++i) f.stores.push_back({"qdot[" + std::to_string(i) + ']', qdot[i].node()});
    if (leaf) return this->end();  // nothing reads its velocity
    this->part("(17): the body's own velocity");
    velocity = motion(now);
    if (order.frame == Order::before_displacement) shift_outboard(velocity, Vector3<T>{T(0), T(0), screw.d});
    this->to_child(velocity.v, velocity.w, gravity);
    this->store(f.last, "out.velocity.v", velocity.v), this->store(f.last, "out.velocity.w", velocity.w);
    if (has_gravity) this->store(f.last, "out.gravity", gravity);
    this->end();
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
  /// Ω × Pb
  Force<T> gyroscopic(const Motion<T>& frame, const Force<T>& Pb) const {
    if constexpr (requires { K::template gyroscopic<T>(k.body.mc, frame, Pb); })
      if (root && leaf) return K::template gyroscopic<T>(k.body.mc, frame, Pb);
    return cross(frame, Pb);
  }
};

}  // namespace momentree::derive
