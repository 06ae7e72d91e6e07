#include <momentree/sweep/machines/distribute.hpp>

#include <momentree/base/check.hpp>
#include <momentree/sweep/machines/distributor.hpp>
#include <momentree/sweep/machines/worker.hpp>

namespace momentree::sweep {

int distribute(Communicator* communicator, WorkSource* source, const RunChunk& run, const DistributeOptions& options) {
  const bool first = communicator == nullptr || communicator->rank() == 0;
  MT_REQUIRE(run && options.threads >= 1, "work, and threads that do it");
  MT_REQUIRE(first == (source != nullptr), "rank 0 alone has the source");
  MT_REQUIRE(!first || options.conclude, "rank 0 concludes");
  if (first) return Distributor(communicator, *source, run, options).distribute();
  Worker(*communicator, run, options).work();
  return 0;
}

}  // namespace momentree::sweep
