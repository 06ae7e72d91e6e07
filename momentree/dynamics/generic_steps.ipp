#pragma once
// The passes of stages over one body of a StepTable, by the generic functions of its joint's kernels.
//
// In velocities the accelerations are those of points, v̇ + ω × v at the body's origin. Then velocities may be relative to a
// frame that moves with the parent's origin: linear ones, which would only cancel, are not handed on.
#include <momentree/base/inline.hpp>
#include <momentree/dynamics/step_table.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/machine/evaluate.hpp>

namespace momentree {

/// What the steps of a body are called with.
template <class K, class T>
struct StepOfBody {
  using Record = typename K::template Record<T>;

  const StepEntry& e;
  const StepArrays& s;
  const GenericBody& own = *static_cast<const GenericBody*>(e.constants);

  template <class X = T>
  static X* at(void* array, std::int32_t bytes) {
    return reinterpret_cast<X*>(static_cast<char*>(array) + bytes);
  }
  static const T* at(const void* array, std::int32_t bytes) {
    return reinterpret_cast<const T*>(static_cast<const char*>(array) + bytes);
  }
  JointState<T> joint() const { return {at(s.q, e.q), at(s.cos, e.angle), at(s.sin, e.angle)}; }
  Record& record() const { return *at<Record>(s.records, e.record); }
  BodyBias<T>& bias() const { return static_cast<BodyBias<T>*>(s.biases)[own.body]; }
  const double* armature() const { return s.model_armature + e.dof / static_cast<std::int32_t>(sizeof(T)); }
  /// Calls f(std::bool_constant<the link needs no rotation about the parent's z>).
  template <class F>
  MOMENTREE_INLINE void by_alignment(F&& f) const {
    if (K::rotates_about_z && aligned(own.link))
      f(std::true_type{});
    else
      f(std::false_type{});
  }
};

/// In velocities.
template <class K, class T>
struct GenericVelocitySteps {
  using Body = StepOfBody<K, T>;

  /// From its parent's motion to its own, with its bias: (17), (39).
  static void velocities(const StepEntry& e, const StepArrays& s) {
    const Body b{e, s};
    const JointState<T> j = b.joint();
    const LinkConstants& link = b.own.link;
    const T* const u = Body::at(static_cast<const void*>(s.u), e.dof);
    Motion<T> a{};
    if (!b.own.root) a.w = Body::template at<Motion<T>>(s.motions, e.in)->w;
    b.by_alignment([&](auto is_aligned) MOMENTREE_INLINE_LAMBDA {
      K::template joint_transform<is_aligned(), T>(link, j, b.record()).outboard(a);
    });
    a = K::template spatial_velocity<T>(link, j, a, u);  // (17)
    BodyBias<T>& to = b.bias();
    put(K::template acceleration_bias<T>(link, j, a, u), to.acceleration);  // (39)
    to.acceleration.v += cross(a.w, a.v);
    K::template coordinate_rate<T>(j.q, u, Body::at(s.qdot, e.q));
    a.v = {T(0), T(0), T(0)};
    put(gyroscopic_wrench(link.body, a), to.wrench);
    if (!b.own.leaf) put(a, *Body::template at<Motion<T>>(s.motions, e.to));
  }
  /// From the contributions of its children to its own: (22)–(26), (16).
  template <bool Adds>
  static void inboard(const StepEntry& e, const StepArrays& s) {
    const Body b{e, s};
    const JointState<T> j = b.joint();
    Inboard<T> a{};
    if (!b.own.leaf) put_without_moments(*Body::template at<Inboard<T>>(s.sums, e.in), a);
    const BodyBias<T>& from = b.bias();
    add_rigid_mass(a.M, b.own.link.body);                                                            // (22)
    a.D += from.wrench;                                                                              // (23)
    K::template reduce<T>(b.own.link, j, Body::at(s.a, e.dof), b.armature(), a.M, a.D, b.record());  // (24)–(26)
    if (b.own.root) return;
    K::add_reduced_bias(b.record(), from.acceleration, a.D);
    b.by_alignment([&](auto is_aligned) MOMENTREE_INLINE_LAMBDA {
      const auto transform = K::template cached_transform<is_aligned(), T>(b.own.link, j, b.record());
      transform.inboard(a.M);  // (16)
      transform.inboard(a.D);
    });
    if constexpr (Adds)
      add_without_moments(a, *Body::template at<Inboard<T>>(s.sums, e.to));
    else
      put_without_moments(a, *Body::template at<Inboard<T>>(s.sums, e.to));
  }
  /// From its parent's acceleration to its own: (39), (27), (17).
  static void outboard(const StepEntry& e, const StepArrays& s) {
    const Body b{e, s};
    const JointState<T> j = b.joint();
    const Motion<T>& parent = *Body::template at<Motion<T>>(s.motions, e.in);
    Motion<T> a{};
    a.v = parent.v;
    if (!b.own.root) a.w = parent.w;
    b.by_alignment([&](auto is_aligned) MOMENTREE_INLINE_LAMBDA {
      K::template cached_transform<is_aligned(), T>(b.own.link, j, b.record()).outboard(a);
    });
    a = a + b.bias().acceleration;
    T* const udot = Body::at(s.a, e.dof);
    K::joint_velocity(b.record(), a, udot);  // (27)
    if (b.own.leaf) return;
    put(K::template spatial_velocity<T>(b.own.link, j, a, udot), *Body::template at<Motion<T>>(s.motions, e.to));  // (17)
  }
};

/// In momenta.
template <class K, class T>
struct GenericMomentumSteps {
  using Body = StepOfBody<K, T>;

  /// (22)–(26), (16)
  template <bool Adds>
  static void inboard(const StepEntry& e, const StepArrays& s) {
    const Body b{e, s};
    const JointState<T> j = b.joint();
    Inboard<T> a{};
    if (!b.own.leaf) put(*Body::template at<Inboard<T>>(s.sums, e.in), a);
    SpatialMass<T>& M = articulated_mass(b.own.link.body, a.M);  // (22)
    Force<T>& D = remainder_momentum(a.D);                       // (23)
    const Vec3& own = b.own.link.body.mc;
    a.mc.x += own.x, a.mc.y += own.y, a.mc.z += own.z;
    b.record().mc = a.mc;
    K::template reduce<T>(b.own.link, j, Body::at(s.p, e.dof), b.armature(), M, D, b.record());  // (24)–(26)
    b.by_alignment([&](auto is_aligned) MOMENTREE_INLINE_LAMBDA {
      const auto transform = K::template joint_transform<is_aligned(), T>(b.own.link, j, b.record());
      if (b.own.root) return;
      transform.inboard(M);  // (16)
      transform.inboard(D);
      transform.inboard(a.mc, b.own.mass);
    });
    if (b.own.root) return;
    if constexpr (Adds)
      *Body::template at<Inboard<T>>(s.sums, e.to) += a;
    else
      put(a, *Body::template at<Inboard<T>>(s.sums, e.to));
  }
  /// (17), (27), (21), (15), (20)
  static void outboard(const StepEntry& e, const StepArrays& s) {
    const Body b{e, s};
    const JointState<T> j = b.joint();
    const Outboard<T>& parent = *Body::template at<Outboard<T>>(s.motions, e.in);
    Outboard<T> a{};
    a.gravity = parent.gravity;
    if (!b.own.root) a.velocity = parent.velocity;
    b.by_alignment([&](auto is_aligned) MOMENTREE_INLINE_LAMBDA {
      const auto transform = K::template cached_transform<is_aligned(), T>(b.own.link, j, b.record());
      transform.outboard(a.velocity);
      transform.outboard(a.gravity);
    });
    T* const u = Body::at(s.u, e.dof);
    K::joint_velocity(b.record(), a.velocity, u);                                               // (27)
    const Force<T> Pb = K::articulated_momentum(b.record(), Body::at(s.p, e.dof), a.velocity);  // (21)
    a.velocity = K::template spatial_velocity<T>(b.own.link, j, a.velocity, u);                 // (17)
    const Force<T> weight = accumulated_force(b.own.mass, b.record().mc, a.gravity);            // (15)
    const auto gyroscopic = [&] {
      if constexpr (requires { K::template gyroscopic<T>(b.own.link.body.mc, a.velocity, Pb); })
        if (b.own.root && b.own.leaf) return K::template gyroscopic<T>(b.own.link.body.mc, a.velocity, Pb);
      return cross(a.velocity, Pb);
    };
    const Force<T> wrench = weight - gyroscopic();                                        // (9), (20)
    K::template momentum_rate<T>(b.own.link, j, u, Pb, wrench, Body::at(s.pdot, e.dof));  // (20)
    K::template coordinate_rate<T>(j.q, u, Body::at(s.qdot, e.q));
    if (!b.own.leaf) put(a, *Body::template at<Outboard<T>>(s.motions, e.to));
  }
};

namespace detail {
/// Kernels with the generic functions.
template <class K>
struct WithoutSteps {
  using type = K;
};
template <class K>
requires requires { typename K::Generic; }
struct WithoutSteps<K> {
  using type = typename K::Generic;
};
}  // namespace detail

template <class T, bool Momenta>
GenericStep generic_step(Kind kind, Variant variant, bool adds) noexcept {
  return dispatch_kernels(kind, variant, [adds](auto tag) -> GenericStep {
    using K = typename detail::WithoutSteps<typename decltype(tag)::type>::type;
    constexpr std::size_t record = sizeof(typename K::template Record<T>) / sizeof(T);
    if constexpr (K::rigid) {
      return {};  // welds are part of other bodies
    } else if constexpr (Momenta) {
      using Steps = GenericMomentumSteps<K, T>;
      return {{adds ? Steps::template inboard<true> : Steps::template inboard<false>, Steps::outboard}, record};
    } else {
      using Steps = GenericVelocitySteps<K, T>;
      return {{Steps::velocities, adds ? Steps::template inboard<true> : Steps::template inboard<false>, Steps::outboard},
              record};
    }
  });
}

template <class T>
void put_number(void* to, double x) noexcept {
  *static_cast<T*>(to) = T(x);
}
/// What a table needs to know of T. `width`: of the machine code for it.
template <class T, bool Momenta>
StepScalar step_scalar(StepWidth width) {
  return {Momenta, sizeof(T), &put_number<T>, &generic_step<T, Momenta>, width, {}};
}

/// A derived step, carried out operation by operation.
template <class T, std::size_t Pass>
void interpreted_step(const StepEntry& e, const StepArrays& s) {
  const auto& own = *static_cast<const InterpretedStep*>(e.constants);
  StepEntry entry = e;
  entry.constants = own.constants;
  machine::evaluate<T, double>((*own.passes)[Pass], {.number = sizeof(T), .fused = false}, &entry, &s,
                               std::span(static_cast<T*>(own.room->values), own.room->most));
}
/// For a table that carries out derived steps like this, so that T can record or count them.
template <class T, bool Momenta>
StepScalar interpreting_scalar() {
  StepScalar scalar = step_scalar<T, Momenta>(StepWidth::none);
  scalar.interpreted = {interpreted_step<T, 0>, interpreted_step<T, 1>, interpreted_step<T, 2>};
  return scalar;
}

}  // namespace momentree
