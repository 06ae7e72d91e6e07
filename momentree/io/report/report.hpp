#pragma once
// A result directory as the data of the page that shows it.
#include <filesystem>
#include <string>

namespace momentree::io {

/// More numbers than these in the tables of a report are thinned: every so many rows are kept, and the last one.
inline constexpr std::size_t most_report_numbers = 3'000'000;

struct ReportOptions {
  bool pose = false;  ///< a model to be posed by hand: its joints get sliders
  std::size_t most_numbers = most_report_numbers;
  std::string summary = {};  ///< the text of summary.json, where that is not written yet
};

/// The tables and documents of a result as JSON that can stand in a page: it has no '<'. Poses and joints in single precision,
/// times and energies in double. Joints are left out where fewer than 300 rows would be left with them. Rows from the first one
/// whose poses are no numbers on (a run that diverged) are left out.
/// Throws Error, with file and line, where the directory lacks model.json or bodies.csv, or a file is not as it was written.
std::string report_data(const std::filesystem::path& directory, const ReportOptions& options = {});

}  // namespace momentree::io
