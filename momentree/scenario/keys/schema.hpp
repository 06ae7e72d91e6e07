#pragma once
// The JSON Schema of scenario files, made from the descriptions that their readers use.
#include <string>

namespace momentree::io {

/// A document of draft 7, as text.
std::string scenario_schema();

}  // namespace momentree::io
