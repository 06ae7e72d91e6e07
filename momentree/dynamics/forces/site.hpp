#pragma once
// The joint and instant at which a force element acts.
#include <momentree/dynamics/workspace_data.hpp>

namespace momentree::forces {

struct Site {
  const JointParameters& parameters;
  int nv;
  unsigned acts;  ///< a bit per DoF that is not locked
  double t;       ///< s
  const double *q, *u;
  double* force;  ///< added to by the elements: N m, N
  Power* power;   ///< W; owned by the caller

  bool on(int dof) const { return (acts >> dof & 1u) != 0; }
};

/// A force that resists motion: its value (N m, N), and its slopes −∂force/∂u and −∂force/∂q.
struct Resistance {
  double force = 0, slope = 0, stiffness = 0;
};

inline Site site_of(const Tree& tree, double t, const double* q, const double* v, int b, double* force, Power& power) noexcept {
  static const JointParameters none;
  const JointParameters* p = tree.parameters(b);
  return {p != nullptr ? *p : none, info(tree.kind(b)).nv, ~tree.joint(b).locked,   t,
          q + tree.first_q(b),      v + tree.first_p(b),   force + tree.first_p(b), &power};
}

/// The signal of a DoF; null if the list is empty.
inline const Signal* signal_of(const std::vector<Signal>& list, int dof) {
  if (list.empty()) return nullptr;
  return &list[list.size() == 1 ? 0 : static_cast<std::size_t>(dof)];
}

}  // namespace momentree::forces
