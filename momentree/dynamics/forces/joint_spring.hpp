#pragma once
// Springs in joints.
#include <momentree/dynamics/evaluate.hpp>
#include <momentree/joint/dispatch.hpp>

namespace momentree {

template <class T>
T joint_spring_at(const Tree& tree, const T* q, int b, T* force) noexcept {
  return dispatch(tree.kind(b), [&](auto tag) {
    using K = typename decltype(tag)::type;
    constexpr int nq = K::info.nq, nv = K::info.nv;
    MT_REQUIRE(tree.parameters(b) != nullptr, "the joint has a spring");
    const JointParameters& p = *tree.parameters(b);
    double stiffness[nv > 0 ? nv : 1], rest[nq > 0 ? nq : 1];
    for (int i = 0; i < nv; ++i) stiffness[i] = p.stiffness.of(i);
    if (p.rest.empty())
      K::Kernels::zero(rest);
    else
      for (int i = 0; i < nq; ++i) rest[i] = p.rest[i];
    return K::Kernels::spring(q, rest, stiffness, force);
  });
}

}  // namespace momentree
