#include <momentree/sweep/machines/launch.hpp>

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <momentree/sweep/machines/mpi_communicator.hpp>

namespace momentree::sweep {

// SLURM_NTASKS and SLURM_PROCID are also set in scripts of sbatch, whose commands srun does not start; those of steps are not.
Launch detect_launch(const std::function<const char*(const char*)>& get) {
  for (const char* const variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    const char* const text = get(variable);
    int size = 0;
    if (text == nullptr || std::from_chars(text, text + std::strlen(text), size).ec != std::errc() || size < 1) continue;
    return {true, size, variable};
  }
  if (get("PMIX_RANK") != nullptr) return {true, std::nullopt, "PMIX_RANK"};
  return {};
}

std::unique_ptr<Communicator> launch() {
  const Launch launch = detect_launch([](const char* name) -> const char* { return std::getenv(name); });
  if (!launch.launched || launch.size == 1) return nullptr;
  return connect_mpi(launch);
}

}  // namespace momentree::sweep
