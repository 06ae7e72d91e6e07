#pragma once
// What the closed contacts of a world do at present: their slip, their forces, and what moves with them.
#include <vector>

#include <momentree/simulate/contact/contact_world.hpp>

namespace momentree {

/// The velocity with which the bodies of a contact slip along each other (m/s).
Vec3 slip_velocity(const ContactWorld& world, const Contact& contact);

/// Of the present forces: how far they are outside of what contacts can exert, relative to the largest force of their island.
struct ForceExcess {
  double excess = -1;
  std::size_t contact = 0;  ///< one of that island
};
ForceExcess force_excess(const ContactWorld& world);

/// Kinetic energies (J) of the islands of closed contacts, by their numbers, without those of armatures.
std::vector<double> kinetic_by_island(const ContactWorld& world);
/// The bodies of the closed contact with the largest force.
std::vector<int> most_loaded(const ContactWorld& world);
/// The bodies of the contact with the slowest slip; of any closed contact if none slips.
std::vector<int> slowest_slip_of(const ContactWorld& world);
/// The next instant at which a bouncing body comes to rest, or infinity.
double next_rest(const ContactWorld& world);

}  // namespace momentree
