#pragma once
// The passes over one body of a StepTable, by the texts of body_passes.hpp.
//
// In stages in velocities the accelerations are those of points, v̇ + ω × v at the body's origin. Then velocities may be relative
// to a frame that moves with the parent's origin: linear ones, which would only cancel, are not handed on.
#include <momentree/base/inline.hpp>
#include <momentree/dynamics/steps/step_table.hpp>
#include <momentree/dynamics/workspace_data.hpp>
#include <momentree/joint/body_passes.hpp>
#include <momentree/joint/dispatch.hpp>
#include <momentree/machine/evaluate.hpp>

namespace momentree {

/// What nobody reads after a stage.
template <class T>
struct Unread {
  BodySweep<T> motion;
  Motion<T> inboard_acceleration;
  Force<T> reduced_bias_wrench;
};

/// What the steps of a body are called with.
template <class K, class T, Passes P>
struct StepOfBody {
  using Sum = std::conditional_t<numbers_of_sum(P) == 6, Force<T>, Inboard<T>>;
  using Handed = std::conditional_t<in_momenta(P), Outboard<T>, Motion<T>>;

  const StepEntry& e;
  const StepArrays& s;
  Unread<T>& unread;
  const GenericBody& own = *static_cast<const GenericBody*>(e.constants);

  static T* at(void* array, std::int32_t bytes) { return reinterpret_cast<T*>(static_cast<char*>(array) + bytes); }
  static const T* at(const void* array, std::int32_t bytes) {
    return reinterpret_cast<const T*>(static_cast<const char*>(array) + bytes);
  }
  /// Of a body's memory in an array.
  template <class V>
  static V& of(void* array, std::int32_t place) {
    return keeps_results(P) ? static_cast<V*>(array)[place] : *reinterpret_cast<V*>(static_cast<char*>(array) + place);
  }
  template <class V>
  V& own_of(void* array, V& otherwise) const {
    return keeps_results(P) ? static_cast<V*>(array)[own.body] : otherwise;
  }
  const double* armature() const { return s.model_armature + e.dof / static_cast<std::int32_t>(sizeof(T)); }
  BodyBias<T>& bias() const { return static_cast<BodyBias<T>*>(s.biases)[own.body]; }
  PassBody<K, T> of_pass() const {
    return {.link = own.link,
            .joint = {at(s.q, e.q), at(s.cos, e.angle), at(s.sin, e.angle)},
            .aligned = own.aligned,
            .root = own.root,
            .alone = own.alone,
            .record = *reinterpret_cast<typename K::template Record<T>*>(keeps_results(P) ? static_cast<T*>(s.records) + e.record
                                                                                          : at(s.records, e.record)),
            .u = at(s.u, e.dof),
            .qdot = at(s.qdot, e.q),
            .a = at(s.a, e.dof),
            .p = at(s.p, e.dof),
            .pdot = at(s.pdot, e.dof),
            .motion = &own_of(s.body_sweeps, unread.motion),
            .bias = &bias(),
            .inboard_acceleration = &own_of(s.inboard_accelerations, unread.inboard_acceleration),
            .reduced_bias_wrench = &own_of(s.reduced_bias_wrenches, unread.reduced_bias_wrench),
            .load = static_cast<const Force<T>*>(s.loads) + own.body};
  }
};

template <class K, class T, Passes P>
struct GenericSteps {
  using Body = StepOfBody<K, T, P>;
  using Sum = typename Body::Sum;
  using Handed = typename Body::Handed;

  /// In velocities, the first pass.
  [[gnu::flatten]] static void velocities(const StepEntry& e, const StepArrays& s) {
    Unread<T> unread;
    const Body b{e, s, unread};
    Motion<T> a{};
    if (!b.own.root) {
      const Motion<T>& parent = Body::template of<Motion<T>>(s.motions, e.in);
      a.w = parent.w;
      if constexpr (keeps_results(P)) a.v = parent.v;
    }
    velocity_outboard(b.of_pass(), a);
    if constexpr (!keeps_results(P)) {
      BodyBias<T>& bias = b.bias();
      bias.acceleration.v += cross(a.w, a.v);
      a.v = {T(0), T(0), T(0)};
      put(gyroscopic_wrench(b.own.link.body, a), bias.wrench);
    }
    if (!b.own.leaf) put(a, Body::template of<Motion<T>>(s.motions, e.to));
  }
  template <bool Adds>
  [[gnu::flatten]] static void inboard(const StepEntry& e, const StepArrays& s) {
    constexpr bool moments = in_momenta(P) || numbers_of_sum(P) == 6;
    Unread<T> unread;
    const Body b{e, s, unread};
    Sum a{};
    if (!b.own.leaf) {
      const Sum& from = Body::template of<Sum>(s.sums, e.in);
      if constexpr (moments)
        put(from, a);
      else
        put_without_moments(from, a);
    }
    if constexpr (in_momenta(P))
      momentum_inboard(b.of_pass(), b.armature(), b.own.mass, true, a);
    else if constexpr (in_velocities(P))
      force_inboard(b.of_pass(), b.armature(), a);
    else if constexpr (P == Passes::rates)
      rate_inboard(b.of_pass(), a);
    else
      solution_inboard(b.of_pass(), a);
    if (b.own.root) return;
    Sum& to = Body::template of<Sum>(s.sums, e.to);
    if constexpr (Adds && moments)
      to += a;
    else if constexpr (Adds)
      add_without_moments(a, to);
    else if constexpr (moments)
      put(a, to);
    else
      put_without_moments(a, to);
  }
  [[gnu::flatten]] static void outboard(const StepEntry& e, const StepArrays& s) {
    Unread<T> unread;
    const Body b{e, s, unread};
    const Handed& parent = Body::template of<Handed>(s.motions, e.in);
    Handed a{};
    if constexpr (in_momenta(P)) {
      a.gravity = parent.gravity;
      if (!b.own.root) a.velocity = parent.velocity;
      momentum_outboard(b.of_pass(), b.own.mass, a);
    } else {
      a.v = parent.v;
      if (!b.own.root) a.w = parent.w;
      if constexpr (in_velocities(P))
        acceleration_outboard(b.of_pass(), a);
      else if constexpr (P == Passes::rates)
        rate_outboard(b.of_pass(), a);
      else
        solution_outboard(b.of_pass(), a);
    }
    if (!b.own.leaf) put(a, Body::template of<Handed>(s.motions, e.to));
  }
};

template <class T, Passes P>
GenericStep generic_step(Kind kind, Variant variant, bool adds) noexcept {
  return dispatch_kernels(kind, variant, [adds](auto tag) -> GenericStep {
    using K = typename decltype(tag)::type;
    constexpr std::size_t record = sizeof(typename K::template Record<T>) / sizeof(T);
    if constexpr (K::rigid && !keeps_results(P)) {
      return {};  // welds are part of other bodies
    } else {
      using Steps = GenericSteps<K, T, P>;
      const StepFunction inboard = adds ? Steps::template inboard<true> : Steps::template inboard<false>;
      if constexpr (in_velocities(P))
        return {{Steps::velocities, inboard, Steps::outboard}, record};
      else
        return {{inboard, Steps::outboard}, record};
    }
  });
}

template <class T>
void put_number(void* to, double x) noexcept {
  *static_cast<T*>(to) = T(x);
}
/// What a table needs to know of T. `width`: of the machine code for it.
template <class T, Passes P>
StepScalar step_scalar(StepWidth width) {
  return {P, sizeof(T), &put_number<T>, &generic_step<T, P>, width, {}};
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
template <class T, Passes P>
StepScalar interpreting_scalar() {
  StepScalar scalar = step_scalar<T, P>(StepWidth::none);
  scalar.interpreted = {interpreted_step<T, 0>, interpreted_step<T, 1>, interpreted_step<T, 2>};
  return scalar;
}

}  // namespace momentree
