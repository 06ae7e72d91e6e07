#pragma once
// All public headers of the library: build a Model, run a Simulation, read its World. For your own loop: compile, start_state,
// forward_dynamics, apply.
#include <momentree/base/build_info.hpp>
#include <momentree/base/error.hpp>
#include <momentree/dynamics/acceleration.hpp>
#include <momentree/dynamics/energy.hpp>
#include <momentree/dynamics/equations.hpp>
#include <momentree/dynamics/forward.hpp>
#include <momentree/joint/kinds.hpp>
#include <momentree/model/model.hpp>
#include <momentree/simulate/analysis/equilibrium.hpp>
#include <momentree/simulate/analysis/inverse_kinematics.hpp>
#include <momentree/simulate/analysis/linearization.hpp>
#include <momentree/simulate/simulation.hpp>
#include <momentree/topology/change.hpp>
#include <momentree/topology/snapshot.hpp>
#include <momentree/tree/edit.hpp>
