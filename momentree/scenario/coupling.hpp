#pragma once
// Joints that follow other joints through springs: [[coupling]] of a scenario, and `mimic` of model files.
#include <vector>

#include <momentree/simulate/simulation.hpp>

namespace momentree::io {

/// A spring and a damper between two coordinates. With e = q(joint) − multiplier·q(leader) − offset, they exert −(stiffness·e +
/// damping·ė) on the joint and −multiplier times that on its leader. Both joints have one degree of freedom.
struct JointCoupling {
  JointId joint, leader;
  double multiplier = 1;  ///< units of the joint per unit of its leader
  double offset = 0;      ///< rad or m
  double stiffness = 0;   ///< N m/rad or N/m, of the joint
  double damping = 0;     ///< N m s/rad or N s/m
};

/// Spring and damper for the joints that follow others, in the units of JointCoupling; the stiffness is positive.
struct CouplingSpring {
  double stiffness = 0, damping = 0;
};

/// Couples the joints of a simulation from now on. In each world a coupling acts as long as both joints are still those of the
/// model (not broken, freed or changed); it persists through locks, snapshots and branches. The work of the springs is counted
/// in `work`. Called again, as after a state was restored, it renews them.
void couple(Simulation& simulation, const std::vector<JointCoupling>& couplings);

}  // namespace momentree::io
