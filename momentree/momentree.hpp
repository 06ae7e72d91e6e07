#pragma once
// The front door: build a Model, run a Simulation, look at its World. One level down, for a loop of one's own:
// compile, forward_dynamics, apply.
#include <momentree/base/error.hpp>
#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/dynamics/momentum.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/snapshot.hpp>
#include <momentree/tree/model.hpp>
