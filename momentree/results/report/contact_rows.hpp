#pragma once
// The rows of contacts.csv, for pages.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace momentree::io {

struct ContactRow {
  double time = 0;  ///< s
  std::string one, other;
  std::array<double, 10> numbers{};  ///< point, normal, force on the first body, speed of slip
};

/// In the order of the file; a last line without a line end is left out. Throws Error: a missing file, a row with too few cells
/// or with a cell that is not a number.
std::vector<ContactRow> read_contact_rows(const std::filesystem::path& file);

}  // namespace momentree::io
