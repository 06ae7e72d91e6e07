#pragma once
// Exact couplings of joints: gears, belts, racks and pinions, and fingers that follow each other.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <momentree/model/ids.hpp>

namespace momentree {

class Model;

/// Handle of a coupling: its place in the order in which the couplings of the model were added.
struct CouplingId {
  int index = -1;
  friend bool operator==(CouplingId, CouplingId) = default;
};

/// An equation between the coordinates of two joints of the tree with one DoF each: q(joint) = f(q(follows)), where
/// f(x) = offset + multiplier·x + higher[0]·x² + higher[1]·x³ + higher[2]·x⁴, in rad or m. Without `follows` the joint is held at
/// `offset`. It holds exactly: the coupling exerts the effort λ on the joint, and −f′(q)·λ on the joint that it follows.
struct Coupling {
  JointId joint, follows{};
  double multiplier = 1, offset = 0;
  std::array<double, 3> higher{};
  friend bool operator==(const Coupling&, const Coupling&) = default;

  bool leads() const { return follows.index >= 0; }
  /// f, f′ and f″; without `follows` the offset, 0 and 0.
  double value(double x) const {
    return leads() ? offset + x * (multiplier + x * (higher[0] + x * (higher[1] + x * higher[2]))) : offset;
  }
  template <class T>
  T slope(const T& x) const {
    return leads() ? multiplier + x * (2 * higher[0] + x * (3 * higher[1] + x * 4 * higher[2])) : T(0);
  }
  template <class T>
  T curvature(const T& x) const {
    return leads() ? 2 * higher[0] + x * (6 * higher[1] + x * 12 * higher[2]) : T(0);
  }
  /// The sum of the magnitudes of the terms of f: rounding of f is relative to it.
  double size(double x) const {
    const double y = std::fabs(x);
    return std::fabs(offset) + (leads() ? y * (std::fabs(multiplier) +
                                               y * (std::fabs(higher[0]) + y * (std::fabs(higher[1]) + y * std::fabs(higher[2]))))
                                        : 0.0);
  }
};

/// The faults of a coupling of joints of a model. `field`: the scenario key at fault.
struct CouplingProblem {
  std::string field, what, hint;
};
std::vector<CouplingProblem> check_coupling(const Coupling& coupling, const Model& model);

/// "'a' with 'b'": the joints of a coupling.
std::string coupling_text(const Coupling& coupling, const std::string& joint, const std::string& follows);

/// A coupling as the recursions use it: the bodies that carry its joints.
struct CouplingEnds {
  int coupling = -1;             ///< by its number; −1: none
  int joint = -1, follows = -1;  ///< bodies; −1: none
};

}  // namespace momentree
