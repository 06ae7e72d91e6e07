#pragma once
// Whole steps of both passes for kinds of joint with several DoFs, derived from the functions of the kind by tools/derive: the
// files in derived/. They serve the stages of integrators; everything else uses the generic functions.
#include <momentree/joint/kernels.hpp>

namespace momentree {

/// The steps of kernels K for a link with β = 0 (`Aligned`), for a body without children (`Leaf`); specialised in derived/.
template <class K, bool Aligned, bool Leaf>
struct DerivedSteps;

/// True for kernels with derived steps. They require a joint as declared, without armature.
template <class K>
inline constexpr bool has_derived_steps = false;

/// Numbers that an inward step stores for the outward step, in the memory of the kind's own record.
template <class T, int N>
struct DerivedRecord {
  Vector3<T> mc;  ///< first moment of the subtree (kg m)
  T x[N];
};

}  // namespace momentree
