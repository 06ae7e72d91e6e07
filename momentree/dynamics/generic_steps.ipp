#pragma once
// The passes of stages over one body of a StepTable, by the texts of body_passes.hpp.
//
// In velocities the accelerations are those of points, v̇ + ω × v at the body's origin. Then velocities may be relative to a
// frame that moves with the parent's origin: linear ones, which would only cancel, are not handed on.
#include <momentree/base/inline.hpp>
#include <momentree/dynamics/body_passes.hpp>
#include <momentree/dynamics/step_table.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/machine/evaluate.hpp>

namespace momentree {

/// What the steps of a body are called with.
template <class K, class T>
struct StepOfBody {
  using Record = typename K::template Record<T>;
  /// What nobody reads after a stage.
  struct Kept {
    BodySweep<T> motion;
    Motion<T> inboard_acceleration;
    Force<T> reduced_bias_wrench;
  };

  const StepEntry& e;
  const StepArrays& s;
  Kept& kept;
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
  PassBody<K, T> of_pass() const {
    return {.link = own.link,
            .joint = joint(),
            .flags = own.flags,
            .record = record(),
            .u = at(s.u, e.dof),
            .qdot = at(s.qdot, e.q),
            .a = at(s.a, e.dof),
            .p = at(s.p, e.dof),
            .pdot = at(s.pdot, e.dof),
            .motion = &kept.motion,
            .bias = &bias(),
            .inboard_acceleration = &kept.inboard_acceleration,
            .reduced_bias_wrench = &kept.reduced_bias_wrench};
  }
  bool leaf() const { return (own.flags & node::leaf) != 0; }
  bool root() const { return (own.flags & node::root) != 0; }
};

/// In velocities.
template <class K, class T>
struct GenericVelocitySteps {
  using Body = StepOfBody<K, T>;

  static void velocities(const StepEntry& e, const StepArrays& s) {
    typename Body::Kept unread;
    const Body b{e, s, unread};
    Motion<T> a{};
    if (!b.root()) a.w = Body::template at<Motion<T>>(s.motions, e.in)->w;
    velocity_outboard(b.of_pass(), a);
    BodyBias<T>& bias = b.bias();
    bias.acceleration.v += cross(a.w, a.v);
    a.v = {T(0), T(0), T(0)};
    put(gyroscopic_wrench(b.own.link.body, a), bias.wrench);
    if (!b.leaf()) put(a, *Body::template at<Motion<T>>(s.motions, e.to));
  }
  template <bool Adds>
  static void inboard(const StepEntry& e, const StepArrays& s) {
    typename Body::Kept unread;
    const Body b{e, s, unread};
    Inboard<T> a{};
    if (!b.leaf()) put_without_moments(*Body::template at<Inboard<T>>(s.sums, e.in), a);
    force_inboard(b.of_pass(), b.armature(), a);
    if (b.root()) return;
    if constexpr (Adds)
      add_without_moments(a, *Body::template at<Inboard<T>>(s.sums, e.to));
    else
      put_without_moments(a, *Body::template at<Inboard<T>>(s.sums, e.to));
  }
  static void outboard(const StepEntry& e, const StepArrays& s) {
    typename Body::Kept unread;
    const Body b{e, s, unread};
    const Motion<T>& parent = *Body::template at<Motion<T>>(s.motions, e.in);
    Motion<T> a{};
    a.v = parent.v;
    if (!b.root()) a.w = parent.w;
    acceleration_outboard(b.of_pass(), a);
    if (!b.leaf()) put(a, *Body::template at<Motion<T>>(s.motions, e.to));
  }
};

/// In momenta.
template <class K, class T>
struct GenericMomentumSteps {
  using Body = StepOfBody<K, T>;

  template <bool Adds>
  static void inboard(const StepEntry& e, const StepArrays& s) {
    typename Body::Kept unread;
    const Body b{e, s, unread};
    Inboard<T> a{};
    if (!b.leaf()) put(*Body::template at<Inboard<T>>(s.sums, e.in), a);
    momentum_inboard(b.of_pass(), b.armature(), b.own.mass, true, a);
    if (b.root()) return;
    if constexpr (Adds)
      *Body::template at<Inboard<T>>(s.sums, e.to) += a;
    else
      put(a, *Body::template at<Inboard<T>>(s.sums, e.to));
  }
  static void outboard(const StepEntry& e, const StepArrays& s) {
    typename Body::Kept unread;
    const Body b{e, s, unread};
    const Outboard<T>& parent = *Body::template at<Outboard<T>>(s.motions, e.in);
    Outboard<T> a{};
    a.gravity = parent.gravity;
    if (!b.root()) a.velocity = parent.velocity;
    momentum_outboard(b.of_pass(), b.own.mass, a);
    if (!b.leaf()) put(a, *Body::template at<Outboard<T>>(s.motions, e.to));
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
