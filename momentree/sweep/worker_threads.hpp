#pragma once
#include <atomic>
#include <functional>

#include <momentree/sweep/work_source.hpp>

namespace momentree::sweep {

/// Works on a sweep with so many threads of this process until everything is given out or `stop` is set: chunks that have been
/// begun are then finished. `watch` is called about ten times a second by the calling thread, which sets `stop`. An exception of
/// a thread ends the others and is thrown again.
void work_with_threads(WorkSource& work, const RunChunk& run, int threads, std::atomic<bool>& stop,
                       const std::function<void()>& watch);

}  // namespace momentree::sweep
