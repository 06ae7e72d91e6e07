#pragma once
// Names of files as files have them.
#include <string>

namespace momentree::io {

/// True where a name as it is written can't mean a file in the folder or below it, whatever stands there: an absolute path, one
/// with more `..` than folders, one of another system, or one with characters that are not seen.
bool leaves_folder(const std::string& name);

}  // namespace momentree::io
