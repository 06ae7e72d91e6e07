#pragma once
#include <string_view>

namespace momentree::io {

/// True if a line of the text gives the scenario format or begins a mechanism. Any file may be named as a scenario, so messages
/// quote lines only of files recognised as scenarios, whether or not they can be read.
bool is_known_scenario(std::string_view text);

}  // namespace momentree::io
