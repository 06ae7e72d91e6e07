#include <momentree/sweep/machines/launch.hpp>

#include <doctest/doctest.h>

#include <map>

using namespace momentree::sweep;

namespace {

Launch detect(const std::map<std::string, std::string>& environment) {
  return detect_launch([&](const char* name) -> const char* {
    const auto found = environment.find(name);
    return found == environment.end() ? nullptr : found->second.c_str();
  });
}

}  // namespace

TEST_CASE("processes of mpirun, mpiexec and srun know their number; others are alone") {
  CHECK(!detect({}).launched);
  CHECK(detect({{"OMPI_COMM_WORLD_SIZE", "4"}, {"PMIX_RANK", "0"}}).size == 4);
  CHECK(detect({{"PMI_SIZE", "3"}, {"PMI_RANK", "2"}}).size == 3);
  CHECK(detect({{"SLURM_STEP_NUM_TASKS", "8"}, {"SLURM_PROCID", "1"}, {"PMIX_RANK", "1"}}).size == 8);
  CHECK(detect({{"PMI_SIZE", "3"}}).variable == "PMI_SIZE");
}

TEST_CASE("a command in a script of sbatch, which srun does not start, is alone") {
  CHECK(!detect({{"SLURM_NTASKS", "64"}, {"SLURM_PROCID", "0"}, {"SLURM_JOB_ID", "1"}}).launched);
}

TEST_CASE("a launcher that does not tell the size is asked by MPI") {
  const Launch launch = detect({{"PMIX_RANK", "0"}});
  CHECK(launch.launched);
  CHECK(!launch.size);
}

TEST_CASE("sizes that are no numbers are ignored") {
  CHECK(!detect({{"OMPI_COMM_WORLD_SIZE", ""}}).launched);
  CHECK(!detect({{"OMPI_COMM_WORLD_SIZE", "many"}, {"PMI_SIZE", "0"}}).launched);
}
