#include <momentree/sweep/machines/coordinator.hpp>

#include <algorithm>

#include <momentree/base/check.hpp>
#include <momentree/base/error.hpp>
#include <momentree/sweep/machines/encoding.hpp>

namespace momentree::sweep {

Coordinator::Coordinator(Journal& journal, CoordinatorOptions options) : journal_(journal), options_(options) {
  std::vector<Chunk> done;
  for (const Journal::Entry& entry : journal.entries()) done.push_back(entry.chunk);
  std::sort(done.begin(), done.end(), [](const Chunk& a, const Chunk& b) { return a.first < b.first; });
  std::uint64_t next = 0;
  for (const Chunk& chunk : done) {
    if (chunk.first > next) gaps_.push_back({next, chunk.first - next});
    next = chunk.first + chunk.count;
    done_ += chunk.count;
  }
  const std::uint64_t worlds = journal.identity().worlds;
  if (next < worlds) gaps_.push_back({next, worlds - next});
  before_ = done_;
  ungiven_ = worlds - done_;
}

std::uint64_t Coordinator::chunk_size() const {
  const auto workers = static_cast<std::uint64_t>(std::max(options_.workers, 1));
  std::uint64_t size = 1;
  if (const std::uint64_t now = done_ - before_; now > 0) {
    const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
    // Rank 0 takes a result in about 5 µs: this leaves it three quarters of its time.
    const double seconds = std::max(options_.seconds, 2e-5 * static_cast<double>(workers));
    const double fitting = seconds * static_cast<double>(now) / std::max(elapsed * static_cast<double>(workers), 1e-9);
    size = fitting < static_cast<double>(options_.largest) ? static_cast<std::uint64_t>(fitting) : options_.largest;
  }
  size = std::min(size, ungiven_ / (3 * workers) + 1);
  size = std::clamp<std::uint64_t>(size, 1, options_.largest);
  return (size + options_.multiple - 1) / options_.multiple * options_.multiple;
}

std::optional<Chunk> Coordinator::next() {
  const std::lock_guard lock(mutex_);
  while (!again_.empty()) {
    const Chunk chunk = again_.front();
    again_.pop_front();
    if (!finished_.contains(chunk.first)) return chunk;
  }
  if (gaps_.empty()) return std::nullopt;
  Chunk& gap = gaps_.front();
  const Chunk chunk{gap.first, std::min(chunk_size(), gap.count)};
  gap.first += chunk.count;
  gap.count -= chunk.count;
  ungiven_ -= chunk.count;
  if (gap.count == 0) gaps_.pop_front();
  return chunk;
}

void Coordinator::finished(Chunk chunk, std::string encoded) {
  std::uint64_t failed = 0, worlds = 0;
  ResultReader reader(encoded, journal_.identity().measures);
  for (WorldResult result; reader.next(result); ++worlds) failed += !result.done();
  if (worlds != chunk.count || !reader.at_end())
    throw_error({"a worker sent results that cannot be read", "", "do all workers run the same version?"});
  const std::lock_guard lock(mutex_);
  if (finished_.contains(chunk.first)) return;
  journal_.append(chunk, encoded);
  finished_.insert(chunk.first);
  done_ += chunk.count;
  failed_ += failed;
}

bool Coordinator::complete() const {
  const std::lock_guard lock(mutex_);
  return done_ == journal_.identity().worlds;
}

void Coordinator::give_again(Chunk chunk) {
  const std::lock_guard lock(mutex_);
  if (!finished_.contains(chunk.first)) again_.push_back(chunk);
}

Coordinator::Progress Coordinator::progress() const {
  const std::lock_guard lock(mutex_);
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  return {done_, failed_, elapsed > 0 ? static_cast<double>(done_ - before_) / elapsed : 0};
}

}  // namespace momentree::sweep
