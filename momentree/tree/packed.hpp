#pragma once
// Checks of packed arrays that users provide: coordinates, velocities, momenta and efforts of all joints of a tree.
#include <functional>
#include <span>
#include <string>

#include <momentree/tree/tree.hpp>

namespace momentree {

/// The name of a joint, by its number, for messages.
using JointNamer = std::function<std::string(int)>;

/// Throws Error for a list of another length than nq (`coordinates`) or nv, and for a number that is not finite. `what`: what the
/// numbers are, in the plural, for messages.
void check_packed(const Tree& tree, const char* what, bool coordinates, std::span<const double> all, const JointNamer& name);

/// Throws Error for a coordinate that is more than 1e-6 (rad, m; of 1 + the limit) beyond a hard stop of its joint.
void check_limits(const Tree& tree, std::span<const double> q, const JointNamer& name);

/// Normalises the quaternions among packed coordinates; those of unit length keep their bits. Throws Error, with some of them
/// normalised, for one whose length differs from 1 by more than 1e-6.
void normalise_quaternions(const Tree& tree, std::span<double> q, const JointNamer& name);

/// Sets the entries of locked DoFs to zero, in an array packed as p; not those of prescribed motions.
void clear_locked(const Tree& tree, double* p) noexcept;

}  // namespace momentree
