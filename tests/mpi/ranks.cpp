// A program for the tests of ranks: squares of whole numbers by distribute(), kept in a journal.
//   mpi-ranks JOURNAL ITEMS [RANK MISHAP]
// Each line of JOURNAL is an item and its square; a second call continues it. MISHAP of that RANK in its third item:
// freeze (SIGSTOP), die (SIGKILL), throw (an Error), memory (std::bad_alloc), or at the start: version, work (differ).
// Prints, on rank 0: the ending, how many items this call computed, and on how many ranks.

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <mutex>
#include <new>
#include <set>
#include <sstream>
#include <string>
#include <thread>

#include <momentree/base/error.hpp>
#include <momentree/sweep/machines/distribute.hpp>
#include <momentree/sweep/machines/launch.hpp>

using namespace momentree;
using namespace momentree::sweep;

namespace {

std::atomic<bool> stop = false;

class Journal final : public WorkSource {
 public:
  Journal(const std::string& path, std::uint64_t items) : items_(items) {
    std::ifstream before(path);
    for (std::uint64_t item = 0, square = 0; before >> item >> square;) done_.insert(item);
    for (std::uint64_t item = 0; item < items; ++item)
      if (!done_.contains(item)) waiting_.insert(item);
    file_.open(path, std::ios::app);
  }
  std::optional<Chunk> next() override {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) return std::nullopt;
    const std::uint64_t first = *waiting_.begin();
    waiting_.erase(waiting_.begin());
    return Chunk{first, 1};
  }
  void finished(Chunk chunk, std::string encoded) override {
    const std::lock_guard lock(mutex_);
    if (!done_.insert(chunk.first).second) return;
    std::istringstream text(encoded);
    int rank = 0;
    std::uint64_t square = 0;
    text >> rank >> square;
    ranks.insert(rank);
    ++computed;
    file_ << chunk.first << ' ' << square << std::endl;
  }
  bool complete() const override {
    const std::lock_guard lock(mutex_);
    return done_.size() == items_;
  }
  void give_again(Chunk chunk) override {
    const std::lock_guard lock(mutex_);
    if (!done_.contains(chunk.first)) waiting_.insert(chunk.first);
  }

  std::set<int> ranks;
  std::uint64_t computed = 0;

 private:
  mutable std::mutex mutex_;
  const std::uint64_t items_;
  std::set<std::uint64_t> waiting_, done_;
  std::ofstream file_;
};

void misbehave(const std::string& mishap) {
  if (mishap == "freeze") raise(SIGSTOP);
  if (mishap == "die") raise(SIGKILL);
  if (mishap == "throw") throw_error({"this item is wrong", "items.txt:3:1", "mend it"});
  if (mishap == "memory") throw std::bad_alloc();
}

int run(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::unique_ptr<Communicator> ranks = launch();
  const int rank = ranks ? ranks->rank() : 0;
  const std::string mishap = argc > 4 && std::atoi(argv[3]) == rank ? argv[4] : "";
  std::atomic<int> begun = 0;
  std::atomic<bool> cancel = false;

  std::unique_ptr<Journal> journal;
  if (rank == 0) journal = std::make_unique<Journal>(argv[1], std::strtoull(argv[2], nullptr, 10));
  DistributeOptions options;
  options.version = mishap == "version" ? "2" : "1";
  options.work = mishap == "work" ? "other" : argv[2];
  options.stop = &stop;
  options.cancel = &cancel;
  options.grace = std::chrono::seconds(2);
  options.warn = [](const std::string& text) { std::cerr << "warning: " << text << std::endl; };
  options.conclude = [&](Ending ending, const std::exception_ptr& failure) {
    try {
      if (failure) std::rethrow_exception(failure);
    } catch (const std::exception& error) {
      std::cerr << error.what() << std::endl;
    }
    const char* const names[] = {"complete", "interrupted", "failed"};
    std::cout << names[static_cast<int>(ending)] << ' ' << journal->computed << ' ' << journal->ranks.size() << std::endl;
    return ending == Ending::complete ? 0 : ending == Ending::interrupted ? 3 : 1;
  };
  const RunChunk square = [&](Chunk chunk) {
    if (++begun == 3) misbehave(mishap);
    // Long enough for every rank to get some.
    for (int i = 0; i < 20 && !cancel && !stop; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return std::to_string(rank) + ' ' + std::to_string(chunk.first * chunk.first);
  };
  return distribute(ranks.get(), journal.get(), square, options);
}

}  // namespace

int main(int argc, char** argv) {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop = true; });
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << std::endl;
    return 2;
  }
}
