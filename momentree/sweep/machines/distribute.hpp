#pragma once
// Gives the chunks of a WorkSource to the threads of all ranks, as they become free.
#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <string>

#include <momentree/sweep/machines/communicator.hpp>
#include <momentree/sweep/machines/work_source.hpp>

namespace momentree::sweep {

/// How the work ended.
enum class Ending {
  complete,
  interrupted,  ///< `stop` was set, on any rank
  failed        ///< a rank has failed, or a result could not be stored
};

struct DistributeOptions {
  int threads = 1;  ///< of this rank, for computing; at least 1
  /// All ranks must have the same; otherwise the work fails with an Error that says which rank differs.
  std::string version;  ///< of the program
  std::string work;     ///< identifies what is to be computed: a hash of the input
  /// Called at least 10 times per second, by the calling thread; on rank 0 also at the end. May set `*stop`.
  std::function<void()> progress;
  /// Rank 0: called once, when the work has ended and no more results arrive, before the other ranks are waited for: publishes
  /// the results or reports the error (`failure`, null unless the ending is `failed`), and returns the exit code. Must not throw.
  std::function<int(Ending, const std::exception_ptr& failure)> conclude;
  /// Rank 0: called before the program is ended because ranks did not answer; says which. Must not throw.
  std::function<void(const std::string&)> warn;
  /// Ends the work when set, on any rank. What a chunk returns or throws after that is ignored.
  const std::atomic<bool>* stop = nullptr;
  /// Set by distribute() as soon as the results of running chunks are no longer needed, if not null: RunChunk may then return or
  /// throw anything.
  std::atomic<bool>* cancel = nullptr;
  /// How long ranks have to answer after the end. Then they are ended by Communicator::abort.
  std::chrono::milliseconds grace{10000};
};

/// Does the work with all ranks; all call it. An exception of a chunk ends the work of all ranks; those of other ranks arrive as
/// an Error, or as a std::runtime_error if they were neither an Error nor std::bad_alloc. A rank has a chunk ready for each of
/// its threads while they compute. Near the end, chunks that wait on a busy rank or that take long are given to idle ranks, too,
/// and the first result counts: neither slow nor unresponsive ranks hold up the run. Returns, on rank 0, the exit code of
/// `conclude`, elsewhere 0, after Communicator::finish(); does not return if ranks do not answer. `communicator`: null if this
/// process is alone. `source`: on rank 0 only.
[[nodiscard]] int distribute(Communicator* communicator, WorkSource* source, const RunChunk& run,
                             const DistributeOptions& options);

}  // namespace momentree::sweep
