#pragma once
// The passes over one body that keep what others read of it. One text for numbers and for symbols, with which machine code is
// derived.
//
// Velocities as the state need three passes, outward, inward, outward. The inward pass and the second outward pass are those of
// the momenta, (22)–(27) and (17), with other quantities in the same places: joint forces τ for the momenta p, bias wrenches W
// for the remainders Db, accelerations for velocities. Between them a body adds its own bias, which the first pass found from the
// velocities:
//
//   outward   Ω = X Ω_parent + E u,  bias a = Ω × E u + Ė u,  gyroscopic wrench Z less the external one          (17), (39)
//   inward    Wb = Z + Σ Xᵀ (Ŵ + M̂ a),  Ŵ = Wb + G (τ − Eᵀ Wb)                                                  (23), (26)
//   outward   a′ = X Ω̇_parent + a,  u̇ = Mj⁻¹ (τ − Eᵀ Wb) − Gᵀ a′,  Ω̇ = a′ + E u̇                                 (27), (17)
//
// The ground accelerates against gravity, which gives every body its weight.
//
// With momenta as the state, accelerations follow from the records of its passes. The paper propagates Ṗb outward and computes
// Tr = Ṗb + Ω × Pb − Tb from it (32), a difference that nearly cancels if the outboard bodies are heavy and fast. Tr itself obeys
// the same recursion: Tr = Mb Ω̇ + W, with the bias wrench W = Ω × P of the body plus the contributions of its children, and Ω̇
// less gravity. No digits are lost that way.
#include <type_traits>

#include <momentree/base/inline.hpp>
#include <momentree/joint/kernels.hpp>
#include <momentree/joint/pass_data.hpp>

namespace momentree {

/// What the passes read and write of one body, whose joint has kernels K.
template <class K, class T, class L = LinkConstants>
struct PassBody {
  using Kernels = K;
  using Record = typename K::template Record<T>;

  const L& link;
  JointState<T> joint;
  bool aligned = false;  ///< its link needs no rotation about the parent's z
  bool root = false;     ///< it is attached to the ground
  bool alone = false;    ///< it carries no other and is attached to the ground, directly or by welds
  Record& record;
  T* u = nullptr;  ///< joint velocities
  T* qdot = nullptr;
  T* a = nullptr;        ///< joint forces τ, then accelerations u̇
  const T* p = nullptr;  ///< momenta
  T* pdot = nullptr;
  BodySweep<T>* motion = nullptr;
  BodyBias<T>* bias = nullptr;
  Motion<T>* inboard_acceleration = nullptr;  ///< a′
  Force<T>* reduced_bias_wrench = nullptr;    ///< Ŵ
  const Force<T>* load = nullptr;             ///< the external wrench on it
};

/// Calls f with the transform of a body's joint. The first pass computes it; later ones find what it cost to compute in the
/// record.
template <bool First = false, class B, class F>
MOMENTREE_INLINE void with_transform(const B& b, F&& f) {
  using K = typename B::Kernels;
  const auto find = [&](auto aligned) MOMENTREE_INLINE_LAMBDA {
    if constexpr (First)
      f(K::template joint_transform<aligned()>(b.link, b.joint, b.record));
    else
      f(K::template cached_transform<aligned()>(b.link, b.joint, b.record));
  };
  if (K::rotates_about_z && b.aligned)
    find(std::true_type{});
  else
    find(std::false_type{});
}

// Momenta. `armature`: of the joint's DoFs. `mass`: of the body and of all bodies outboard.

/// From the contributions of its children to its own: (22)–(26), (16).
template <class B, class T>
MOMENTREE_INLINE void momentum_inboard(const B& b, const auto* armature, const auto& mass, bool has_gravity, Inboard<T>& a) {
  using K = typename B::Kernels;
  SpatialMass<T>& M = articulated_mass(b.link.body, a.M);  // (22)
  Force<T>& D = remainder_momentum(a.D);                   // (23)
  const auto& own = b.link.body.mc;
  a.mc.x = a.mc.x + own.x, a.mc.y = a.mc.y + own.y, a.mc.z = a.mc.z + own.z;
  if constexpr (K::rigid) {
    b.record.M = M, b.record.D = D;
  } else {
    b.record.mc = has_gravity ? a.mc : Vector3<T>{T(0), T(0), T(0)};
    K::template reduce<T>(b.link, b.joint, b.p, armature, M, D, b.record);  // (24)–(26)
    with_transform<true>(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA {
      if (b.root) return;    // the ground needs no output
      transform.inboard(M);  // (16)
      transform.inboard(D);
      transform.inboard(a.mc, mass);
    });
  }
}

/// From the velocity of its parent, and gravity in the parent's axes, to its own. Stores Ω and Pb.
template <class B, class T>
MOMENTREE_INLINE void momentum_outboard(const B& b, const auto& mass, Outboard<T>& a) {
  using K = typename B::Kernels;
  if constexpr (K::rigid) {
    *b.motion = {a.velocity, b.record.M * a.velocity + b.record.D};  // (21)
  } else {
    with_transform(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA {
      transform.outboard(a.velocity);
      transform.outboard(a.gravity);
    });
    const Force<T> Pb = K::articulated_momentum(b.record, b.p, a.velocity);        // (21)
    a.velocity = K::template move<T>(b.link, b.joint, b.record, a.velocity, b.u);  // (27), (17)
    *b.motion = {a.velocity, Pb};
    const Force<T> weight = accumulated_force(mass, b.record.mc, a.gravity);  // (15)
    const auto gyroscopic = [&]() MOMENTREE_INLINE_LAMBDA {
      if constexpr (requires { K::template gyroscopic<T>(b.link.body.mc, a.velocity, Pb); })
        if (b.alone) return K::template gyroscopic<T>(b.link.body.mc, a.velocity, Pb);
      return cross(a.velocity, Pb);
    };
    const Force<T> wrench = weight - gyroscopic();                           // (9), (20)
    K::template momentum_rate<T>(b.link, b.joint, b.u, Pb, wrench, b.pdot);  // (20)
    K::template coordinate_rate<T>(b.joint.q, b.u, b.qdot);
  }
}

// Velocities.

/// From the velocity of its parent to its own, with its bias.
template <class B, class T>
MOMENTREE_INLINE void velocity_outboard(const B& b, Motion<T>& a) {
  using K = typename B::Kernels;
  if constexpr (K::rigid) {
    b.bias->acceleration = {};
  } else {
    with_transform<true>(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA { transform.outboard(a); });
    a = K::template spatial_velocity<T>(b.link, b.joint, a, b.u);                          // (17)
    put(K::template acceleration_bias<T>(b.link, b.joint, a, b.u), b.bias->acceleration);  // (39)
    K::template coordinate_rate<T>(b.joint.q, b.u, b.qdot);
  }
  put(gyroscopic_wrench(b.link.body, a), b.bias->wrench);
  put(a, b.motion->velocity);
}

/// From the contributions of its children to its own, with the joint forces τ.
template <class B, class T>
MOMENTREE_INLINE void force_inboard(const B& b, const auto* armature, Inboard<T>& a) {
  using K = typename B::Kernels;
  add_rigid_mass(a.M, b.link.body);  // (22)
  a.D += b.bias->wrench;             // (23)
  if constexpr (K::rigid) {
    b.record.M = a.M, b.record.D = a.D;
  } else {
    K::template reduce<T>(b.link, b.joint, b.a, armature, a.M, a.D, b.record);  // (24)–(26)
  }
  put(a.D, *b.reduced_bias_wrench);
  if constexpr (!K::rigid) {
    if (b.root) return;
    K::add_reduced_bias(b.record, b.bias->acceleration, a.D);
    with_transform(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA {
      transform.inboard(a.M);  // (16)
      transform.inboard(a.D);
    });
  }
}

/// From the acceleration of its parent to its own.
template <class B, class T>
MOMENTREE_INLINE void acceleration_outboard(const B& b, Motion<T>& a) {
  using K = typename B::Kernels;
  if constexpr (!K::rigid) {
    with_transform(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA { transform.outboard(a); });
    a = a + b.bias->acceleration;
  }
  put(a, *b.inboard_acceleration);
  if constexpr (!K::rigid) {
    a = K::template move<T>(b.link, b.joint, b.record, a, b.a);  // (27), (17)
  }
}

// Accelerations after the passes of momenta.

/// With joint forces τ in `a`, which become Mj⁻¹ (τ − Eᵀ W). Of Tr = M̂ a′ + Ŵ it stores Ŵ; Tr itself is computed on request
/// only.
template <class B, class T>
MOMENTREE_INLINE void rate_inboard(const B& b, Force<T>& W) {
  using K = typename B::Kernels;
  W += gyroscopic_wrench(b.link.body, b.motion->velocity);
  W = W - *b.load;
  if constexpr (K::rigid) {
    put(W, *b.reduced_bias_wrench);
  } else {
    K::template reduce_wrench<T>(b.link, b.joint, b.record, b.a, W, b.a);  // (51)
    put(W, *b.reduced_bias_wrench);
    const Motion<T> bias = K::template acceleration_bias<T>(b.link, b.joint, b.motion->velocity, b.u);  // (39)
    K::add_reduced_bias(b.record, bias, W);
    put(bias, b.bias->acceleration);
    with_transform(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA { transform.inboard(W); });  // (45)
  }
}
template <class B, class T>
MOMENTREE_INLINE void rate_outboard(const B& b, Motion<T>& a) {
  using K = typename B::Kernels;
  if constexpr (K::rigid) {
    put(a, *b.inboard_acceleration);
  } else {
    with_transform(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA { transform.outboard(a); });
    a = a + b.bias->acceleration;  // a′ = X Ω̇_parent + bias
    put(a, *b.inboard_acceleration);
    a = K::template accelerate<T>(b.link, b.joint, b.record, a, b.a);  // (47), (39)
  }
}

// Further right-hand sides M u = r: only the parts of both recursions that are linear in p or τ are left, (26), (27) and (17), or
// (51), (47) and (39), without velocities, bodies' own momenta and gravity. `a` holds r, then u.

template <class B, class T>
MOMENTREE_INLINE void solution_inboard(const B& b, Force<T>& W) {
  using K = typename B::Kernels;
  if constexpr (!K::rigid) {
    if constexpr (requires { b.link.locked; })  // those of symbols have none
      for (std::size_t k = 0; k < std::size(K::template columns<T>(b.link, b.joint)); ++k)
        if ((b.link.locked >> k & 1u) != 0) b.a[k] = T(0);
    K::template reduce_wrench<T>(b.link, b.joint, b.record, b.a, W, b.a);                             // (51)
    with_transform(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA { transform.inboard(W); });  // (45)
  }
}
template <class B, class T>
MOMENTREE_INLINE void solution_outboard(const B& b, Motion<T>& a) {
  using K = typename B::Kernels;
  if constexpr (!K::rigid) {
    with_transform(b, [&](const auto& transform) MOMENTREE_INLINE_LAMBDA { transform.outboard(a); });
    a = K::template accelerate<T>(b.link, b.joint, b.record, a, b.a);  // (47), (39)
  }
}

}  // namespace momentree
