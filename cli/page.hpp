#pragma once
// The pages built from web/, embedded in the program.
#include <string_view>

namespace momentree::cli {

/// web/dist/report.html; io::report_page inserts data into it.
std::string_view report_html();
/// web/dist/playground.html; io::playground_page inserts a scenario into it.
std::string_view playground_html();

}  // namespace momentree::cli
