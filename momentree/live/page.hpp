#pragma once
// The page of the live view, built from web/ and embedded in the library.
#include <string_view>

namespace momentree::live {

/// web/dist/live.html; io::live_page inserts data into it.
std::string_view live_html();

}  // namespace momentree::live
