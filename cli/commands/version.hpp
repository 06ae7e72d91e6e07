#pragma once
// What `momentree --version` and `momentree -V` print.
#include <string>
#include <string_view>

namespace momentree::cli {

/// "momentree 0.1.0", and a line that says how it was built. `commit`: empty if it is not known.
std::string version_text(std::string_view commit);
/// The same line by line, with the flags of the compiler and the formats of files.
std::string long_version_text(std::string_view commit);

}  // namespace momentree::cli
