#pragma once
#include <string_view>

namespace momentree::io {

/// True where a line of the text says the format of scenarios, or begins a mechanism. Any file may be named as a scenario;
/// messages show lines only of one that is known for one, whether or not it can be read.
bool is_known_scenario(std::string_view text);

}  // namespace momentree::io
