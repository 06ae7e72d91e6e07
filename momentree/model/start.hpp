#pragma once
// Where joints start before loops and couplings are closed.
#include <momentree/model/model.hpp>

namespace momentree {

/// The coordinates within hard stops that are nearest to q.
Values within_stops(const JointLimits& limits, Values q);

/// The start coordinates of a body's inboard joint: those given; otherwise those within its hard stops that are nearest to zero.
Values start_coordinates(const BodySpec& spec);

}  // namespace momentree
