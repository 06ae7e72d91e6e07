#pragma once
// The ranks of distribute() other than 0: compute the chunks that rank 0 gives them.
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include <momentree/sweep/machines/distribute.hpp>
#include <momentree/sweep/machines/messages.hpp>

namespace momentree::sweep {

class Worker {
 public:
  Worker(Communicator& communicator, const RunChunk& run, const DistributeOptions& options);
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  /// From the first message to Communicator::finish().
  void work();

 private:
  void start_threads();
  void join_threads();
  void compute();
  void serve();
  void fail(const std::exception_ptr& failure) noexcept;
  bool interrupted() const { return options_.stop != nullptr && options_.stop->load(); }

  Communicator& communicator_;
  const RunChunk& run_;
  const DistributeOptions& options_;
  const std::string no_memory_;  ///< an encoded message, made while there is memory
  std::mutex mutex_;             // of what follows
  std::condition_variable changed_;
  std::deque<Chunk> waiting_;
  bool over_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace momentree::sweep
