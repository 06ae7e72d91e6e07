#pragma once
// Steps that are not machine code, for a StepTable.
#include <momentree/dynamics/velocity.ipp>

namespace momentree {

/// The passes over a body of a StepTable by the generic functions of its joint's kernels.
template <class K>
struct GenericSteps {
  using Sweep = VelocitySweep<double, false>;
  using Record = typename K::template Record<double>;

  static const GenericBody& body(const StepEntry& e) { return *static_cast<const GenericBody*>(e.constants); }
  static double* at(double* array, std::int32_t bytes) { return array + bytes / static_cast<std::int32_t>(sizeof(double)); }
  static const double* at(const double* array, std::int32_t bytes) {
    return array + bytes / static_cast<std::int32_t>(sizeof(double));
  }
  template <class X>
  static X& in(double* array, std::int32_t bytes) {
    return *reinterpret_cast<X*>(at(array, bytes));
  }
  static JointState<double> joint(const StepEntry& e, const StepArrays& s) {
    return {at(s.q, e.q), at(s.cos, e.angle), at(s.sin, e.angle)};
  }
  static BodyBias<double>& bias(const StepEntry& e, const StepArrays& s) {
    return reinterpret_cast<BodyBias<double>*>(s.biases)[body(e).body];
  }

  static void velocities(const StepEntry& e, const StepArrays& s) {
    const GenericBody& own = body(e);
    Motion<double> a{};
    if (!own.root) a.w = in<Motion<double>>(s.motions, e.in).w;
    Sweep::body_velocities<K>(own.link, aligned(own.link), joint(e, s), at(s.u, e.dof), in<Record>(s.records, e.record),
                              bias(e, s), a, at(s.qdot, e.q));
    if (!own.leaf) put(a, in<Motion<double>>(s.motions, e.to));
  }
  template <bool Adds>
  static void inboard(const StepEntry& e, const StepArrays& s) {
    const GenericBody& own = body(e);
    Inboard<double> a{};
    if (!own.leaf) put_without_moments(in<Inboard<double>>(s.sums, e.in), a);
    auto& record = in<Record>(s.records, e.record);
    add_rigid_mass(a.M, own.link.body);                                                                          // (22)
    a.D += bias(e, s).wrench;                                                                                    // (23)
    K::template reduce<double>(own.link, joint(e, s), at(s.a, e.dof), at(s.armature, e.dof), a.M, a.D, record);  // (24)–(26)
    Sweep::body_contribution<K>(own.link, aligned(own.link), own.root, joint(e, s), record, bias(e, s), a);
    if (own.root) return;
    if constexpr (Adds)
      add_without_moments(a, in<Inboard<double>>(s.sums, e.to));
    else
      put_without_moments(a, in<Inboard<double>>(s.sums, e.to));
  }
  static void outboard(const StepEntry& e, const StepArrays& s) {
    const GenericBody& own = body(e);
    Motion<double> a{};
    const Motion<double>& parent = in<Motion<double>>(s.motions, e.in);
    a.v = parent.v;
    if (!own.root) a.w = parent.w;
    const auto& record = in<Record>(s.records, e.record);
    Sweep::body_acceleration<K>(own.link, aligned(own.link), joint(e, s), record, bias(e, s), a);
    double* const udot = at(s.a, e.dof);
    K::joint_velocity(record, a, udot);  // (27)
    if (own.leaf) return;
    put(K::template spatial_velocity<double>(own.link, joint(e, s), a, udot), in<Motion<double>>(s.motions, e.to));  // (17)
  }
};

}  // namespace momentree
