#pragma once
// The Communicator of momentree-mpi.so.
#include <memory>

#include <momentree/sweep/machines/launch.hpp>

namespace momentree::sweep {

/// Loads the plugin and starts MPI; null if there is only one rank. Throws Error as launch() does.
std::unique_ptr<Communicator> connect_mpi(const Launch& launch);

}  // namespace momentree::sweep
