#include <momentree/sweep/worker_threads.hpp>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace momentree::sweep {

void work_with_threads(WorkSource& work, const RunChunk& run, int threads, std::atomic<bool>& stop,
                       const std::function<void()>& watch) {
  std::mutex mutex;
  std::condition_variable ended;
  int running = std::max(threads, 1);
  std::exception_ptr error;
  const auto loop = [&] {
    try {
      while (!stop.load(std::memory_order_relaxed)) {
        const std::optional<Chunk> chunk = work.next();
        if (!chunk) break;
        std::string encoded = run(*chunk);
        if (encoded.empty()) break;
        work.finished(*chunk, std::move(encoded));
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
      stop = true;
    }
    const std::lock_guard lock(mutex);
    if (--running == 0) ended.notify_all();
  };
  std::vector<std::jthread> all;
  const int wanted = running;
  try {
    for (int i = 0; i < wanted; ++i) all.emplace_back(loop);
  } catch (const std::system_error&) {  // fewer threads than wanted; without any the work is done here
    std::unique_lock lock(mutex);
    running -= wanted - static_cast<int>(all.size());
    if (all.empty()) {
      running = 1;
      lock.unlock();
      loop();
    }
  }
  std::unique_lock lock(mutex);
  while (running > 0) {
    ended.wait_for(lock, std::chrono::milliseconds(100), [&] { return running <= 0; });
    if (!watch) continue;
    lock.unlock();
    watch();
    lock.lock();
  }
  lock.unlock();
  all.clear();
  if (error) std::rethrow_exception(error);
}

}  // namespace momentree::sweep
