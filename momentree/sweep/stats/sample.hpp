#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace momentree::sweep {

/// A bounded uniform sample of worlds, each with a row of numbers: all worlds, or those with the smallest hashes. It does not
/// depend on the order of worlds.
class Sample {
 public:
  Sample(std::size_t columns, std::size_t capacity, std::uint64_t seed);

  void add(std::uint64_t world, std::span<const double> row);
  /// Adds the worlds of a sample with the same columns, capacity and seed.
  void merge(const Sample& other);

  /// Worlds that were added, whether kept or not.
  std::uint64_t offered() const { return offered_; }
  std::size_t size() const { return entries_.size(); }
  bool complete() const { return offered_ == entries_.size(); }
  /// The kept worlds in ascending order, and a column of their values in the same order.
  std::vector<std::uint64_t> worlds() const;
  std::vector<double> column(std::size_t column) const;
  /// A smaller uniform sample: the places in worlds() of the worlds with the smallest hashes, at most `count`, ascending.
  std::vector<std::size_t> smallest(std::size_t count) const;

 private:
  struct Entry {
    std::uint64_t hash, world;
    std::size_t place;  ///< of its row
    bool operator<(const Entry& other) const { return hash != other.hash ? hash < other.hash : world < other.world; }
  };
  void keep(Entry entry, std::span<const double> row);
  std::vector<Entry> in_order() const;

  std::size_t columns_, capacity_;
  std::uint64_t seed_, offered_ = 0;
  std::vector<Entry> entries_;  ///< a heap, the largest hash first, once the capacity is reached
  std::vector<double> rows_;
};

}  // namespace momentree::sweep
