#pragma once
// Joints that follow others by springs: [[coupling]] of a scenario, and `mimic` of model files.
#include <vector>

#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// A spring and a damper between two coordinates: with e = q(joint) − multiplier·q(leader) − offset they act with
/// −(stiffness·e + damping·ė) on the joint and with −multiplier times that on its leader. Joints have one freedom each.
struct JointCoupling {
  JointId joint, leader;
  double multiplier = 1;  ///< units of the joint per unit of its leader
  double offset = 0;      ///< rad or m
  double stiffness = 0;   ///< N m/rad or N/m, of the joint
  double damping = 0;     ///< N m s/rad or N s/m
};

/// What springs between joints may ask: a positive stiffness.
struct CouplingSpring {
  double stiffness = 0, damping = 0;
};

/// Couples the joints of a simulation from now on, in each as long as both joints are those of the model (broken, freed and
/// changed ones are not), through locks, snapshots and branches. What the springs do counts as work. To be called once.
void couple(Simulation& simulation, const std::vector<JointCoupling>& couplings);

}  // namespace momentree::io
