#pragma once
// Where a force element acts: one joint at one instant.
#include <momentree/dynamics/work.hpp>

namespace momentree::forces {

struct Site {
  const JointParameters& parameters;
  int nv;
  unsigned acts;  ///< a bit per freedom that is not locked
  double t;       ///< s
  const double *q, *u;
  double* force;  ///< to be added to: N m, N
  Power* power;   ///< W; the caller's

  bool on(int freedom) const { return (acts >> freedom & 1u) != 0; }
};

/// The signal of a freedom; nothing where the list is empty.
inline const Signal* signal_of(const std::vector<Signal>& list, int freedom) {
  if (list.empty()) return nullptr;
  return &list[list.size() == 1 ? 0 : static_cast<std::size_t>(freedom)];
}

}  // namespace momentree::forces
