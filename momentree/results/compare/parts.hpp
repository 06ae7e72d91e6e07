#pragma once
// What comparisons of tables and documents share.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <momentree/base/value.hpp>
#include <momentree/results/compare/compare.hpp>

namespace momentree::io {

struct Compared {
  std::filesystem::path one, other;
  double tolerance = 0;
};

/// True for equal numbers, within the tolerance.
bool near_enough(double one, double other, double tolerance);

/// How far two tables were compared.
struct TableEnds {
  std::size_t rows = 0;       ///< in both
  double one = 0, other = 0;  ///< the time of the last row of each (s)
};
/// Adds the first difference of the two tables.
TableEnds compare_tables(const Compared& folders, const char* file, std::vector<Difference>& found);

/// Adds the first difference of the two documents, without members of the root of that name.
void compare_documents(const Compared& folders, const char* file, const char* without, std::vector<Difference>& found);

/// Adds the first difference of the events, as far as both runs go. Returns the number of events compared.
std::size_t compare_events(const Compared& folders, const TableEnds& ends, std::vector<Difference>& found);

}  // namespace momentree::io
