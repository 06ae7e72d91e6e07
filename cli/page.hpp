#pragma once
// The pages that web/ builds: part of the program.
#include <string_view>

namespace momentree::cli {

/// web/dist/report.html; io::report_page puts data into it.
std::string_view report_html();
/// web/dist/playground.html; io::playground_page puts a scenario into it.
std::string_view playground_html();

}  // namespace momentree::cli
