#pragma once
// The pages of web/ with what they are to show: one file each, that needs nothing else.
#include <string>
#include <string_view>

namespace momentree::io {

/// JSON as it can stand in a page: no name in it may end the element that it stands in.
std::string json_for_page(std::string_view json);

/// The report's page with the data of a run (report_data).
std::string report_page(std::string_view page, std::string_view data);

/// The playground's page, which begins with the text of a scenario.
std::string playground_page(std::string_view page, std::string_view scenario);

/// The content policy that the page itself states: for a server that says the same.
std::string content_policy(std::string_view page);

}  // namespace momentree::io
