#pragma once
// Finds out whether this process is one of several that work together.
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <momentree/sweep/machines/communicator.hpp>

namespace momentree::sweep {

/// What the environment variables of a launcher (mpirun, mpiexec, srun) say.
struct Launch {
  bool launched = false;    ///< one of them has started this process, so that MPI may be used
  std::optional<int> size;  ///< the number of ranks, if known
  std::string variable;     ///< that says so: "OMPI_COMM_WORLD_SIZE"
};

/// `get`: the value of an environment variable, or null.
Launch detect_launch(const std::function<const char*(const char*)>& get);

/// Connects the ranks of this run with MPI, loading momentree-mpi.so; null if no launcher has started this process with more than
/// one rank. Throws Error if the plugin is missing, or if MPI does not connect as many ranks as the launcher has started: each
/// would then do all the work.
[[nodiscard]] std::unique_ptr<Communicator> launch();

}  // namespace momentree::sweep
