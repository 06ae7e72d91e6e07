#pragma once
#include <vector>

#include <momentree/tree/tree.hpp>

namespace momentree::forces {

/// A spring on a DoF whose velocity is the rate of a coordinate: ṗ −= stiffness (q − rest). `q`, `p`: indices in packed arrays.
struct LinearSpring {
  int q, p;
  double stiffness, rest;  ///< N m/rad, rad; N/m, m
};
/// True for kinds all of whose springs are linear; the others have a quaternion.
inline bool has_linear_springs(Kind kind) noexcept { return info(kind).nq == info(kind).nv; }
/// The linear springs of a tree, without those of locked DoFs.
std::vector<LinearSpring> linear_springs(const Tree& tree);

}  // namespace momentree::forces
