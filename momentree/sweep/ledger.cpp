#include <momentree/sweep/ledger.hpp>

#include <algorithm>

namespace momentree::sweep {

void Ledger::give(int rank, Chunk chunk, Time now) {
  at(rank).chunks.push_back({chunk, now});
  ++copies_[chunk];
}

void Ledger::remove(int rank, Chunk chunk, Time now) {
  Rank& holder = at(rank);
  const auto found = std::ranges::find(holder.chunks, chunk, &Held::chunk);
  if (found == holder.chunks.end()) return;
  const auto threads = static_cast<std::ptrdiff_t>(holder.threads);
  if (found - holder.chunks.begin() < threads && threads < std::ssize(holder.chunks)) holder.chunks[holder.threads].since = now;
  holder.chunks.erase(found);
  if (--copies_[chunk] == 0) copies_.erase(chunk);
}

std::vector<int> Ledger::finish(int rank, Chunk chunk, double seconds, Time now) {
  seconds_ += seconds;
  items_ += chunk.count;
  std::vector<int> others;
  for (int i = 0; i < static_cast<int>(ranks_.size()); ++i) {
    if (std::ranges::find(at(i).chunks, chunk, &Held::chunk) == at(i).chunks.end()) continue;
    if (i != rank) others.push_back(i);
    remove(i, chunk, now);
  }
  return others;
}

double Ledger::patience(Chunk chunk, int copies) const {
  constexpr double least = 0.1, unknown = 5;
  const double usual = items_ > 0 ? seconds_ / static_cast<double>(items_) * static_cast<double>(chunk.count) : unknown;
  return std::max(2 * usual, least) * copies;
}

std::optional<Ledger::Again> Ledger::overdue(int rank, Time now) {
  const auto has = [&](Chunk chunk) {
    const std::vector<Held>& own = at(rank).chunks;
    return std::ranges::find(own, chunk, &Held::chunk) != own.end();
  };
  // The rank with the most waiting chunks gives its last one.
  int longest = -1;
  std::ptrdiff_t most = 0;
  for (int i = 0; i < static_cast<int>(ranks_.size()); ++i) {
    const std::ptrdiff_t waiting = std::ssize(at(i).chunks) - at(i).threads;
    if (i != rank && waiting > most && !has(at(i).chunks.back().chunk)) longest = i, most = waiting;
  }
  if (longest >= 0) {
    const Chunk chunk = at(longest).chunks.back().chunk;
    remove(longest, chunk, now);
    return Again{chunk, longest};
  }
  std::optional<Again> best;
  double latest = 0;
  for (int i = 0; i < static_cast<int>(ranks_.size()); ++i) {
    if (i == rank) continue;
    for (const Held& held : at(i).chunks) {
      if (has(held.chunk)) continue;
      const double late = std::chrono::duration<double>(now - held.since).count() - patience(held.chunk, copies_.at(held.chunk));
      if (late > latest) best = Again{held.chunk, std::nullopt}, latest = late;
    }
  }
  return best;
}

}  // namespace momentree::sweep
