#pragma once
// Lists of distinct values.
#include <cstdint>
#include <vector>

namespace momentree::detail {

/// Finds the index of a value in a list of distinct values. The list itself belongs to the caller.
class Distinct {
 public:
  Distinct() : table_(16) {}

  /// Returns the index of a value. `words`: equal for equal values. same(i): true if entry i of the list equals the value; add()
  /// appends the value and is called if no entry does.
  template <class Words, class Same, class Add>
  int number(const Words& words, const Same& same, const Add& add) {
    if (2 * std::size_t{count_} >= table_.size()) grow();
    std::uint64_t hash = 0;
    for (const std::uint64_t word : words) {
      hash = (hash ^ word) * 0xff51afd7ed558ccdu;
      hash ^= hash >> 32;
    }
    const auto mark = static_cast<std::uint32_t>(hash);
    for (std::size_t i = slot(mark);; i = slot(i + 1)) {
      Entry& entry = table_[i];
      if (entry.number == none) {
        add();
        entry = {count_, mark};
        return static_cast<int>(count_++);
      }
      if (entry.mark == mark && same(entry.number)) return static_cast<int>(entry.number);
    }
  }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  struct Entry {
    std::uint32_t number = none, mark = 0;
  };
  std::size_t slot(std::size_t i) const { return i & (table_.size() - 1); }
  void grow() {
    std::vector<Entry> larger(2 * table_.size());
    table_.swap(larger);
    for (const Entry& entry : larger) {
      if (entry.number == none) continue;
      std::size_t i = slot(entry.mark);
      while (table_[i].number != none) i = slot(i + 1);
      table_[i] = entry;
    }
  }

  std::vector<Entry> table_;  // open addressing; the size is a power of two
  std::uint32_t count_ = 0;
};

}  // namespace momentree::detail
