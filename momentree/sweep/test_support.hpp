#pragma once
// For tests: ranks that are threads of one process, and a source that counts.
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <momentree/sweep/machines/communicator.hpp>
#include <momentree/sweep/machines/work_source.hpp>

namespace momentree::sweep::test {

/// Thrown on every rank when one has called abort().
struct Aborted {
  int code;
};

class Network {
 public:
  explicit Network(int size) : boxes_(static_cast<std::size_t>(size)) {}

  class Rank final : public Communicator {
   public:
    Rank(Network& network, int rank) : network_(network), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return static_cast<int>(network_.boxes_.size()); }
    void send(int to, std::string_view bytes) override {
      const std::lock_guard lock(network_.mutex_);
      network_.boxes_[static_cast<std::size_t>(to)].push_back({rank_, std::string(bytes)});
      network_.changed_.notify_all();
    }
    std::optional<Message> receive(std::chrono::milliseconds timeout) override {
      std::unique_lock lock(network_.mutex_);
      std::deque<Message>& box = network_.boxes_[static_cast<std::size_t>(rank_)];
      network_.changed_.wait_for(lock, timeout, [&] { return network_.code_ >= 0 || !box.empty(); });
      if (network_.code_ >= 0) throw Aborted{network_.code_};
      if (box.empty()) return std::nullopt;
      Message message = std::move(box.front());
      box.pop_front();
      return message;
    }
    void finish() override {
      std::unique_lock lock(network_.mutex_);
      ++network_.finished_;
      network_.changed_.notify_all();
      network_.changed_.wait(lock, [&] { return network_.finished_ == size() || network_.code_ >= 0; });
    }
    [[noreturn]] void abort(int code) override {
      const std::lock_guard lock(network_.mutex_);
      network_.code_ = code;
      network_.changed_.notify_all();
      throw Aborted{code};
    }

   private:
    Network& network_;
    int rank_;
  };

  /// How many ranks have finished; the code of abort(), −1 without one.
  int finished() const { return finished_; }
  int code() const { return code_; }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::deque<Communicator::Message>> boxes_;
  int finished_ = 0, code_ = -1;
};

/// What run() makes of a chunk in these tests: each item squared.
inline std::string squares(Chunk chunk) {
  std::string text;
  for (std::uint64_t i = chunk.first; i < chunk.first + chunk.count; ++i) text += std::to_string(i * i) + ' ';
  return text;
}

/// Items in chunks of a fixed size.
class Squares final : public WorkSource {
 public:
  Squares(std::uint64_t items, std::uint64_t size) : items_(items), size_(size) {}
  std::optional<Chunk> next() override {
    const std::lock_guard lock(mutex_);
    if (!again_.empty()) {
      const Chunk chunk = again_.back();
      again_.pop_back();
      return chunk;
    }
    if (first_ >= items_) return std::nullopt;
    const Chunk chunk{first_, std::min(size_, items_ - first_)};
    first_ += chunk.count;
    return chunk;
  }
  void finished(Chunk chunk, std::string encoded) override {
    const std::lock_guard lock(mutex_);
    ++calls;
    if (encoded != squares(chunk)) ++wrong;
    if (done_.insert(chunk).second) items_done += chunk.count;
    if (on_finished) on_finished();
  }
  bool complete() const override {
    const std::lock_guard lock(mutex_);
    return items_done == items_;
  }
  void give_again(Chunk chunk) override {
    const std::lock_guard lock(mutex_);
    ++given_again;
    if (!done_.contains(chunk)) again_.push_back(chunk);
  }

  std::uint64_t items_done = 0;
  std::atomic<int> calls = 0;
  int wrong = 0, given_again = 0;
  std::function<void()> on_finished;

 private:
  mutable std::mutex mutex_;
  const std::uint64_t items_, size_;
  std::uint64_t first_ = 0;
  std::vector<Chunk> again_;
  std::set<Chunk> done_;
};

}  // namespace momentree::sweep::test
