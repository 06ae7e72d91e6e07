#pragma once
// Where a force element acts: one joint at one instant.
#include <momentree/dynamics/workspace.hpp>

namespace momentree::forces {

struct Site {
  const JointParameters& parameters;
  int nv;
  unsigned acts;  ///< a bit per freedom that is not locked
  double t;       ///< s
  const double *q, *u;
  double* force;  ///< to be added to: N m, N
  Power* power;   ///< W; the caller's

  bool on(int dof) const { return (acts >> dof & 1u) != 0; }
};

/// A force that resists motion: what it is at a velocity (N m, N), and how fast it grows against that, −∂force/∂u.
struct Resistance {
  double force = 0, slope = 0;
};

inline Site site_of(const Tree& tree, double t, const double* q, const double* v, int b, double* force, Power& power) noexcept {
  static const JointParameters none;
  const JointParameters* p = tree.parameters(b);
  return {p != nullptr ? *p : none, info(tree.kind(b)).nv, ~tree.joint(b).locked,   t,
          q + tree.first_q(b),      v + tree.first_p(b),   force + tree.first_p(b), &power};
}

/// The signal of a freedom; nothing where the list is empty.
inline const Signal* signal_of(const std::vector<Signal>& list, int dof) {
  if (list.empty()) return nullptr;
  return &list[list.size() == 1 ? 0 : static_cast<std::size_t>(dof)];
}

}  // namespace momentree::forces
