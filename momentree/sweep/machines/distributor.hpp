#pragma once
// Rank 0 of distribute(): gives out chunks, computes some itself, and ends the other ranks.
#include <condition_variable>
#include <exception>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <momentree/sweep/ledger.hpp>
#include <momentree/sweep/machines/distribute.hpp>
#include <momentree/sweep/machines/messages.hpp>

namespace momentree::sweep {

class Distributor {
 public:
  Distributor(Communicator* communicator, WorkSource& source, const RunChunk& run, const DistributeOptions& options);
  ~Distributor();
  Distributor(const Distributor&) = delete;
  Distributor& operator=(const Distributor&) = delete;
  /// All of it; returns the exit code.
  int distribute();

 private:
  using Clock = std::chrono::steady_clock;

  void start_threads();
  void join_threads();
  void compute();
  void serve();
  void hear(const Communicator::Message& message);
  void check_hello(int rank, const Note& note);
  void take_result(int rank, Note note);
  void fill();
  std::optional<Chunk> chunk_for(int rank, int wanted, Clock::time_point now);
  void fail(std::exception_ptr failure);
  Ending end();
  int take_leave(int code, Clock::time_point told);
  bool interrupted() const { return options_.stop != nullptr && options_.stop->load(); }

  Communicator* const communicator_;
  WorkSource& source_;
  const RunChunk& run_;
  const DistributeOptions& options_;
  const int ranks_;

  std::mutex mutex_;  // of what follows; held while the source hands out a chunk, not while it stores a result
  std::condition_variable changed_;
  Ledger ledger_;
  bool over_ = false, complete_ = false;
  int storing_ = 0;  ///< threads inside WorkSource::finished
  std::exception_ptr failure_;

  std::vector<std::thread> threads_;
  std::vector<std::string> hosts_;  ///< empty until the rank has joined
  std::set<int> ended_;
  bool rank_interrupted_ = false;
};

}  // namespace momentree::sweep
