#pragma once
// A result directory as the data of a page that shows it, and the page with its data: one file that needs nothing else.
#include <filesystem>
#include <string>
#include <string_view>

namespace momentree::io {

/// More numbers than these in the tables of a report are thinned: every so many rows are kept, and the last one.
inline constexpr std::size_t most_report_numbers = 3'000'000;

struct ReportOptions {
  bool pose = false;  ///< a model to be posed by hand: its joints get sliders
  std::size_t most_numbers = most_report_numbers;
};

/// The tables and documents of a result as JSON that can stand in a page: it has no '<'. Poses and joints in single precision,
/// times and energies in double. Joints are left out where fewer than 300 rows would be left with them. Rows from the first one
/// whose poses are no numbers on (a run that diverged) are left out.
/// Throws Error, with file and line, where the directory lacks model.json or bodies.csv, or a file is not as it was written.
std::string report_data(const std::filesystem::path& directory, const ReportOptions& options = {});

/// `page` with `data` in the place that it keeps for them.
std::string report_page(std::string_view page, std::string_view data);

/// The content policy that the page itself states: for a server that says the same.
std::string content_policy(std::string_view page);

}  // namespace momentree::io
