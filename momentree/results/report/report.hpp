#pragma once
// A result directory as the data of the page that shows it.
#include <filesystem>
#include <string>

namespace momentree::io {

/// Tables with more rows than a reader can see are thinned in a report: every n-th row is kept, the last one, and those next to
/// events. All rows are kept of tables of up to `plenty` numbers, and of larger ones 60 for each second of the run, but at least
/// 600 and at most 3000; fewer if there would be more than `most_numbers` numbers.
struct ReportOptions {
  std::size_t plenty = 100'000;
  std::size_t most_numbers = 3'000'000;
  std::string summary = {};  ///< the text of summary.json, if that file is not yet written
};

/// The tables and documents of a result as JSON that can be embedded in a page: it contains no '<'. Poses and joints in single
/// precision, times and energies in double. Joints are left out if fewer than 300 rows would be left with them. If a run
/// diverged, its rows from the first one with invalid poses on are left out. Throws Error, with file and line, if the directory
/// lacks model.json or bodies.csv, or if a file is damaged.
std::string report_data(const std::filesystem::path& directory, const ReportOptions& options = {});

}  // namespace momentree::io
