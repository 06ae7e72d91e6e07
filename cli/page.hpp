#pragma once
// The page that shows a run, as web/ builds it: part of the program.
#include <string_view>

namespace momentree::cli {

/// web/dist/report.html; io::report_page puts data into it.
std::string_view report_html();

}  // namespace momentree::cli
